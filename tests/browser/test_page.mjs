// The page by itself, against a program that says on cue what the real one says rarely.

import assert from 'node:assert/strict';
import { copyFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import {
  banner, colourAt, command, isWiderThanScreen, keepScreenshot, kPhone, look, openPage, smallTargets, untilBanner, untilTriangles, useBrowser,
} from './browser.mjs';
import { MockProgram, binaryMessage, chunkBody } from './mock_program.mjs';
import { chunksOfVase, depthJpeg, orbitPose } from './mock_scan.mjs';
import { temporaryFolder } from './program.mjs';

const kPage = join(dirname(fileURLToPath(import.meta.url)), '../../view/page');

/// The page as it is built, where the mock can serve it.
function builtPage() {
  const folder = temporaryFolder();
  for (const name of ['index.html', 'view.css', 'icon.svg']) { copyFileSync(join(kPage, name), join(folder, name)); }
  copyFileSync(process.env.SCANKNIT_VIEW_SCRIPT, join(folder, 'view.js'));
  return folder;
}

useBrowser();
const folder = builtPage();

async function startMock(context) {
  const program = await new MockProgram(folder).listen();
  context.after(() => program.close());
  return program;
}

/// A square of side 2 in the plane z = 0, seen from -z (y down, as a camera sees), corners in four colours.
const kCorners = [[200, 60, 40], [60, 180, 75], [40, 90, 200], [7, 1, 30]];
function square({ colours = kCorners, normal = [0, 0, -1], hasColours = true, shift = 0, coverage } = {}) {
  const places = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
  const vertices = places.map(([x, y], i) => ({ p: [x + shift, y, 0], colour: colours[i], normal, coverage }));
  return chunkBody(vertices, [0, 2, 1, 0, 3, 2], { hasColours });
}
const lookAtSquare = (page) => page.evaluate(() => window.scanknit.look([0, 0, -3], [0, 0, 0]));

test('unlit pixels are the bytes of the vertices, however dark', async (context) => {
  const program = await startMock(context);
  program.hello.commands = [];
  for (const [i, colour] of [...kCorners, [0, 0, 0], [255, 255, 255], [1, 2, 3], [10, 11, 12]].entries()) {
    program.sendBinary(binaryMessage(1, i, 1, square({ colours: [colour, colour, colour, colour], shift: 3 * i })));
  }
  const page = await openPage(program.url);
  await untilTriangles(page, 16);
  await page.evaluate(() => { window.scanknit.shading = 'unlit'; });
  for (const [i, colour] of [...kCorners, [0, 0, 0], [255, 255, 255], [1, 2, 3], [10, 11, 12]].entries()) {
    await page.evaluate((x) => window.scanknit.look([x, 0, -3], [x, 0, 0]), 3 * i);
    assert.deepEqual(await colourAt(page, [3 * i + 0.3, 0.2, 0]), colour);
  }
  assert.deepEqual(page.problems, []);
});

test('shadings show light, normals and coverage', async (context) => {
  const program = await startMock(context);
  const grey = [150, 150, 150];
  program.sendBinary(binaryMessage(1, 1, 1, square({ colours: [grey, grey, grey, grey], coverage: 0 })));
  program.sendBinary(binaryMessage(1, 2, 1, square({ colours: [grey, grey, grey, grey], coverage: 255, shift: 2 })));
  const page = await openPage(program.url);
  await untilTriangles(page, 4);
  await page.evaluate(() => window.scanknit.look([1, 0, -4], [1, 0, 0]));
  const at = async (shading, x) => {
    await page.evaluate((name) => { window.scanknit.shading = name; }, shading);
    return colourAt(page, [x, 0, 0]);
  };
  assert.deepEqual(await at('normals', 0), [128, 128, 0], '(0, 0, -1) as a colour');
  const lit = await at('lit', 0);
  assert.ok(lit[0] > 60 && lit[0] < 255 && lit[0] === lit[1], `lit grey stays grey: ${lit}`);
  const [poor, good] = [await at('coverage', 0), await at('coverage', 2)];
  assert.ok(good[1] > poor[1] + 80, `well seen is brighter: ${poor} ${good}`);
  assert.equal(await page.locator('#legend').isVisible(), true);
});

test('a chunk without normals is lit by its faces, one without colours is clay', async (context) => {
  const program = await startMock(context);
  program.sendBinary(binaryMessage(1, 1, 1, square({ normal: [0, 0, 0], hasColours: false })));
  const page = await openPage(program.url);
  await untilTriangles(page, 2);
  await lookAtSquare(page);
  const [a, b] = [await colourAt(page, [-0.5, -0.5, 0]), await colourAt(page, [0.5, 0.5, 0])];
  assert.deepEqual(a, b, 'one face, one light, no corner colours');
  assert.ok(a[0] > 100, `lit: ${a}`);
});

test('a newer revision replaces a chunk, and a chunk that is gone leaves nothing behind', async (context) => {
  const program = await startMock(context);
  const page = await openPage(program.url);
  await page.waitForFunction(() => window.scanknit.link === 'open');
  for (let revision = 1; revision <= 20; ++revision) { program.sendBinary(binaryMessage(1, 7, revision, square())); }
  await page.waitForFunction(() => window.scanknit.revisions[7] === 20);
  assert.equal(await look(page, 'chunks'), 1);
  assert.equal(await look(page, 'triangles'), 2);
  await lookAtSquare(page);
  const held = await look(page, 'geometries');
  program.sendBinary(binaryMessage(2, 7, 21));
  await page.waitForFunction(() => window.scanknit.chunks === 0);
  await lookAtSquare(page);
  assert.equal(await look(page, 'geometries'), held - 1);
  assert.equal(await look(page, 'bounds'), null);
});

test('indices of 32 bits reach vertices beyond 65,535', async (context) => {
  const program = await startMock(context);
  const spare = { p: [0, 0, 0], colour: [0, 0, 0], normal: [0, 0, -1] };
  const colour = [60, 180, 75];
  const corners = [[-1, -1], [1, -1], [1, 1]].map(([x, y]) => ({ p: [x, y, 0], colour, normal: [0, 0, -1] }));
  program.sendBinary(binaryMessage(1, 1, 1, chunkBody([...Array(70_000).fill(spare), ...corners], [70_000, 70_002, 70_001])));
  const page = await openPage(program.url);
  await untilTriangles(page, 1);
  await lookAtSquare(page);
  await page.evaluate(() => { window.scanknit.shading = 'unlit'; });
  assert.deepEqual(await colourAt(page, [0.4, -0.4, 0]), colour);
});

test('the banner says in words, colour and sign how it goes and what to do', async (context) => {
  const program = await startMock(context);
  const page = await openPage(program.url);
  const cases = [
    [{ phase: 'waiting', frame: 3 }, { tone: 'quiet', head: 'Waiting for the first frame', advice: 'Of 3 so far none could be used.' }],
    [{ phase: 'scanning', tracking: 'ok', reason: '', advice: '' }, { tone: 'good', head: 'Tracking well', advice: '' }],
    [{ silent_s: 5 }, { tone: 'warn', head: 'No frames come', advice: 'Nothing from the scanner for 5 s.' }],
    [{ silent_s: 0, tracking: 'weak', reason: 'flat scene', advice: 'let something with edges into view' },
      { tone: 'warn', head: 'Weak: flat scene', advice: 'Let something with edges into view' }],
    [{ tracking: 'lost', reason: 'turned too fast', advice: 'turn back a little' },
      { tone: 'bad', head: 'Lost: turned too fast', advice: 'Turn back a little' }],
    [{ tracking: 'recovered', reason: '', advice: '' }, { tone: 'good', head: 'Found again', advice: '' }],
    [{ tracking: 'none' }, { tone: 'good', head: 'Scanning', advice: '' }],
    [{ phase: 'paused' }, { tone: 'quiet', head: 'Paused', advice: 'Start goes on where it stopped.' }],
    [{ phase: 'failed', message: 'the disk is full' }, { tone: 'bad', head: 'The scan failed', advice: 'The disk is full' }],
  ];
  const signs = new Set();
  for (const [state, words] of cases) {
    program.sendText({ type: 'state', ...state });
    await untilBanner(page, words.head);
    assert.deepEqual(await banner(page), words);
    if (words.tone !== 'good') { signs.add(await page.locator('#banner-sign').textContent()); }
  }
  assert.equal(signs.size, 4, 'not by colour only: waiting, warned, lost (as failed) and paused have signs of their own');
  assert.equal(await page.locator('#banner-words').getAttribute('aria-live'), 'assertive');
});

test('a broken connection is said, and mended with the whole mesh', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning' });
  program.sendBinary(binaryMessage(1, 1, 1, square()));
  program.sendBinary(binaryMessage(1, 2, 1, square({ shift: 2 })));
  const page = await openPage(program.url);
  await untilTriangles(page, 4);
  program.chunks.delete(2);  // gone while the page is away
  program.drop();
  await page.waitForFunction(() => window.heads.includes('Connection lost'));
  await untilBanner(page, 'Tracking well');
  await page.waitForFunction(() => window.scanknit.triangles === 2);
  assert.equal(await look(page, 'chunks'), 1);
});

test('a page that there is no room for is told so, and let in later', async (context) => {
  const program = await startMock(context);
  program.isFull = true;
  program.sendText({ type: 'state', phase: 'scanning' });
  const page = await openPage(program.url);
  await untilBanner(page, 'No room');
  program.isFull = false;
  await untilBanner(page, 'Tracking well');
});

test('a connection that brings nothing while the scan goes on is opened anew', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning', frame: 1 });
  const page = await openPage(program.url);
  await untilBanner(page, 'Tracking well');
  program.state = { ...program.state, frame: 2 };  // that the page should have heard of
  await page.waitForFunction(() => window.scanknit.state.frame === 2);
});

test('a message that is none costs no credit', async (context) => {
  const program = await startMock(context);
  const page = await openPage(program.url);
  await page.waitForFunction(() => window.scanknit.link === 'open');
  for (let i = 0; i < 20; ++i) { program.sendBinary(new Uint8Array(20)); }
  program.sendBinary(binaryMessage(1, 1, 1, square()));
  await untilTriangles(page, 2);
});

test('a program that begins anew finds a page without the files and the crop box of the one before', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning' });
  program.sendText({ type: 'files', files: [{ name: 'model.glb', bytes: 7 }] });
  program.sendText({ type: 'crop', box: [[-1, -1, -1], [0, 1, 1]] });
  const grey = [150, 150, 150];
  program.sendBinary(binaryMessage(1, 1, 1, square({ colours: [grey, grey, grey, grey] })));
  const page = await openPage(program.url);
  await untilTriangles(page, 2);
  await page.locator('#files-open').waitFor();
  await page.locator('#ring-toggle').click();
  await lookAtSquare(page);
  await page.evaluate(() => { window.scanknit.shading = 'unlit'; });
  assert.notDeepEqual(await colourAt(page, [0.5, 0.2, 0]), grey, 'outside the box');
  for (const message of [{ type: 'files', files: [] }, { type: 'crop', box: null }]) { program.others.set(message.type, message); }
  program.drop();
  await page.waitForFunction(() => window.heads.includes('Connection lost'));
  await untilBanner(page, 'Tracking well');
  await untilTriangles(page, 2);
  assert.equal(await page.locator('#files-open').isVisible(), false);
  assert.deepEqual(await colourAt(page, [0.5, 0.2, 0]), grey);
  assert.equal(await page.locator('#ring').isVisible(), false, 'whoever hid the ring did not ask for it again');
});

test('a graphics card that forgets everything gets the mesh again', async (context) => {
  const program = await startMock(context);
  const grey = [150, 150, 150];
  program.sendText({ type: 'state', phase: 'scanning' });
  program.sendBinary(binaryMessage(1, 1, 1, square({ colours: [grey, grey, grey, grey] })));
  const page = await openPage(program.url);
  await untilTriangles(page, 2);
  await lookAtSquare(page);
  await page.evaluate(async () => {
    const extension = document.getElementById('view').getContext('webgl2').getExtension('WEBGL_lose_context');
    const happened = (name) => new Promise((resolve) => document.getElementById('view').addEventListener(name, resolve, { once: true }));
    const lost = happened('webglcontextlost');
    extension.loseContext();
    await lost;
    const restored = happened('webglcontextrestored');
    setTimeout(() => extension.restoreContext(), 50);
    await restored;
    window.scanknit.look([0, 0, -3], [0, 0, 0]);  // drawn before the mesh has come again
  });
  await page.waitForFunction(() => window.scanknit.link === 'open' && window.scanknit.triangles === 2);
  await page.evaluate(() => { window.scanknit.shading = 'unlit'; });
  assert.deepEqual(await colourAt(page, [0.3, 0.2, 0]), grey);
  assert.deepEqual(page.problems, []);
});

test('the crop panel closes when there is nothing to be cut any more', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning' });
  const page = await openPage(program.url);
  await untilBanner(page, 'Tracking well');
  await command(page, 'crop').click();
  await page.locator('#note').waitFor();
  assert.match(await page.locator('#note').textContent(), /no mesh yet/);
  program.sendBinary(binaryMessage(1, 1, 1, square()));
  await untilTriangles(page, 2);
  for (const end of [{ type: 'trail', points: [] }, { type: 'state', phase: 'finished' }]) {
    await command(page, 'crop').click();
    await page.locator('#crop').waitFor();
    assert.equal(await command(page, 'crop').getAttribute('aria-expanded'), 'true');
    program.sendText(end);
    await page.locator('#crop').waitFor({ state: 'hidden' });
    assert.equal(await command(page, 'crop').getAttribute('aria-expanded'), 'false');
  }
});

test('what a program that is gone cannot give is not offered', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning', fps: 24 });
  program.sendText({ type: 'files', files: [{ name: 'model.glb', bytes: 7 }] });
  const page = await openPage(program.url);
  await page.locator('#files-open').click();
  await page.locator('#files').waitFor();
  assert.equal(await page.locator('#fps').textContent(), '24 /s');
  program.isFull = true;
  program.drop();
  await page.waitForFunction(() => window.heads.includes('Connection lost'));
  assert.equal(await page.locator('#files').isVisible(), false);
  assert.equal(await page.locator('#files-open').isDisabled(), true);
  assert.equal(await page.locator('#fps').textContent(), '–');
});

test('pictures that were lost before fusion are a line of their own, when there are any', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning' });
  const page = await openPage(program.url, { size: kPhone });
  await untilBanner(page, 'Tracking well');
  assert.equal(await page.locator('#stream').isVisible(), false);
  program.sendText({ type: 'state', losses: { transport: 3, writer: 1200 } });
  await page.locator('#stream').waitFor();
  assert.equal(await page.locator('#stream-losses').textContent(), '3 on the way, 1,200 not recorded');
  assert.equal(await isWiderThanScreen(page), false);
});

test('only the commands that the scan takes are shown, and a refusal is told', async (context) => {
  const program = await startMock(context);
  program.hello.commands = ['pause', 'export'];
  program.sendText({ type: 'state', phase: 'scanning' });
  program.answer = ({ cmd }) => (cmd === 'export' ? 'nothing to write yet' : '');
  const page = await openPage(program.url);
  await command(page, 'pause').waitFor();
  const shown = await page.locator('[data-command]:visible').evaluateAll((buttons) => buttons.map((button) => button.dataset.command));
  assert.deepEqual(shown, ['pause', 'export']);
  await command(page, 'export').click();
  await page.locator('#note.bad').waitFor();
  assert.equal(await page.locator('#note').textContent(), 'Export: nothing to write yet');
});

test('reset asks once more', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning' });
  const page = await openPage(program.url);
  await command(page, 'reset').click();
  await page.keyboard.press('Escape');
  await command(page, 'reset').click();
  await page.locator('#ask-no').click();
  assert.deepEqual(program.commands, []);
  await command(page, 'reset').click();
  await page.locator('#ask-yes').click();
  await page.locator('#note').waitFor();
  assert.deepEqual(program.commands.map(({ cmd }) => cmd), ['reset']);
});

test('Start is there while the scan is paused, and Pause else', async (context) => {
  const program = await startMock(context);
  const page = await openPage(program.url);
  const shown = async (phase) => {
    program.sendText({ type: 'state', phase });
    await page.waitForFunction((name) => window.scanknit.state.phase === name, phase);
    return page.locator('[data-command=start]:visible, [data-command=pause]:visible').evaluateAll((buttons) => buttons.map((button) => button.textContent));
  };
  const phases = ['waiting', 'scanning', 'exporting', 'paused', 'exporting'];
  const seen = [];
  for (const phase of phases) { seen.push(await shown(phase)); }
  assert.deepEqual(seen, [['Pause'], ['Pause'], ['Pause'], ['Start'], ['Start']]);
});

test('a command is not sent when the scan has ended behind its question', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning' });
  const page = await openPage(program.url);
  await command(page, 'reset').click();
  await page.locator('#ask-yes').waitFor();
  program.sendText({ type: 'state', phase: 'finished' });
  await untilBanner(page, 'Finished');
  await page.locator('#ask-yes').click();
  await page.locator('#note.bad').waitFor();
  assert.match(await page.locator('#note').textContent(), /^Reset: not possible/);
  assert.deepEqual(program.commands, []);
});

test('a crop box that holds nothing is told at once, and what Finish then writes before it is pressed', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning' });
  const page = await openPage(program.url);
  await command(page, 'finish').click();
  const usual = await page.locator('#ask-text').textContent();
  await page.locator('#ask-no').click();
  program.sendText({ type: 'state', is_crop_empty: true });
  await page.locator('#note.bad').waitFor();
  await command(page, 'finish').click();
  assert.notEqual(await page.locator('#ask-text').textContent(), usual);
  assert.match(await page.locator('#ask-text').textContent(), /whole mesh/);
});

test('the crop box is drawn, moved by keys and by a finger, and sent in metres of the world', async (context) => {
  const program = await startMock(context);
  program.hello.up = [0, 0, 1];  // whatever is up: the box keeps to the scan's axes
  program.sendText({ type: 'state', phase: 'paused' });
  const vase = chunksOfVase(chunkBody);
  for (const { number, body } of vase.revealed(1)) { program.sendBinary(binaryMessage(1, number, 1, body)); }
  const page = await openPage(program.url, { size: kPhone });
  await untilTriangles(page, vase.triangles(1));
  await command(page, 'crop').click();
  const [low] = await look(page, 'bounds');
  await page.getByLabel('X from').focus();
  for (let i = 0; i < 100; ++i) { await page.keyboard.press('ArrowRight'); }
  await page.evaluate(() => window.scanknit.look([0, -0.1, -0.6], [0, -0.1, 0]));
  const canvas = await page.locator('#view').boundingBox();
  const handle = await page.evaluate(() => window.scanknit.cropHandle('X', 'max'));
  const [x, y] = [canvas.x + handle[0], canvas.y + handle[1]];
  await page.mouse.move(x, y);
  await page.mouse.down();
  const [right] = await page.evaluate(() => window.scanknit.place([1, 0, 0]));
  const inwards = right > handle[0] - canvas.x ? -1 : 1;
  await page.mouse.move(x + 30 * inwards, y, { steps: 3 });
  await page.mouse.up();
  const screen = await page.locator('#crop-rows output').allTextContents();
  await keepScreenshot(page, 'crop_phone');
  await page.locator('#crop-apply').click();
  await page.locator('#crop').waitFor({ state: 'hidden' });
  const [{ cmd, box }] = program.commands;
  assert.equal(cmd, 'crop');
  assert.ok(box[0][0] > low[0] + 0.02 && box[0][0] < box[1][0], `the low side of x went in: ${box}`);
  assert.ok(box[1][0] < 0.08, `the high side of x was dragged in: ${box}`);
  assert.equal(screen[0], `${(1000 * box[0][0]).toFixed(0)} mm`);
});

test('the ring tells from which sides the object was seen', async (context) => {
  const program = await startMock(context);
  const vase = chunksOfVase(chunkBody);
  for (const { number, body } of vase.revealed(1)) { program.sendBinary(binaryMessage(1, number, 1, body)); }
  const steps = 90;
  program.sendText({ type: 'trail', points: Array.from({ length: steps }, (_, i) => orbitPose((Math.PI * (i + 0.5)) / steps).slice(12, 15)) });
  const page = await openPage(program.url);
  await untilTriangles(page, vase.triangles(1));
  await page.waitForFunction(() => window.scanknit.sectorsSeen > 0);
  const half = await look(page, 'sectorsSeen');
  assert.ok(half >= 17 && half <= 20, `half a turn is half of 36 sectors, and one or two at the ends: ${half}`);
  for (let i = 0; i <= steps; ++i) {
    program.sendText({ type: 'pose', T: orbitPose(Math.PI * (1 + i / steps)), half: [0.5, 0.4], is_lost: false });
  }
  await page.waitForFunction(() => window.scanknit.sectorsSeen === 36);
  assert.equal(await page.locator('#ring-text').textContent(), '36 of 36 sides seen');
});

test('a reset empties the ring, and a new scan fills it again', async (context) => {
  const program = await startMock(context);
  program.sendBinary(binaryMessage(1, 1, 1, square()));
  program.sendText({ type: 'trail', points: Array.from({ length: 40 }, (_, i) => orbitPose(i / 20).slice(12, 15)) });
  const page = await openPage(program.url);
  const drawn = () => page.locator('#ring-sectors path.seen').count();
  await page.waitForFunction(() => window.scanknit.sectorsSeen > 5);
  assert.ok((await drawn()) > 5);
  program.sendBinary(binaryMessage(2, 1, 2));
  program.sendText({ type: 'trail', points: [] });
  await page.waitForFunction(() => window.scanknit.sectorsSeen === 0);
  assert.equal(await drawn(), 0);
  assert.equal(await page.locator('#ring-text').textContent(), '0 of 36 sides seen');
  program.sendBinary(binaryMessage(1, 1, 3, square()));
  program.sendText({ type: 'pose', T: orbitPose(1), half: [0.5, 0.4], is_lost: false });
  await page.waitForFunction(() => window.scanknit.sectorsSeen === 1);
});

test('a lost scanner leaves no trail and turns no sector on', async (context) => {
  const program = await startMock(context);
  program.sendBinary(binaryMessage(1, 1, 1, square()));
  const page = await openPage(program.url);
  await untilTriangles(page, 2);
  program.sendText({ type: 'pose', T: orbitPose(1), half: [0.5, 0.4], is_lost: false });
  for (let i = 0; i < 30; ++i) { program.sendText({ type: 'pose', T: orbitPose(1 + i / 10), half: [0.5, 0.4], is_lost: true }); }
  program.sendText({ type: 'state', frame: 77 });
  await page.waitForFunction(() => window.scanknit.state.frame === 77);
  assert.equal(await look(page, 'trailPoints'), 1);
});

test('nothing is drawn while nothing happens', async (context) => {
  const program = await startMock(context);
  program.sendBinary(binaryMessage(1, 1, 1, square()));
  const page = await openPage(program.url);
  await untilTriangles(page, 2);
  await page.waitForFunction(async () => {
    const before = window.scanknit.picturesDrawn;
    for (let i = 0; i < 20; ++i) { await new Promise((resolve) => requestAnimationFrame(resolve)); }
    return window.scanknit.picturesDrawn === before;
  });
});

test('the depth picture is shown, and a broken one is not', async (context) => {
  const program = await startMock(context);
  const page = await openPage(program.url);
  await page.waitForFunction(() => window.scanknit.link === 'open');
  program.sendBinary(binaryMessage(3, 0, 1, new Uint8Array([1, 2, 3])));
  program.sendBinary(binaryMessage(3, 0, 2, depthJpeg()));
  await page.waitForFunction(() => window.scanknit.depthPictures === 1);
  assert.equal(await page.locator('#depth').isVisible(), true);
  await page.locator('#depth').click();
  assert.equal(await page.locator('#depth').getAttribute('aria-expanded'), 'true');
});

test('on a phone everything fits and every button can be hit', async (context) => {
  const program = await startMock(context);
  const vase = chunksOfVase(chunkBody);
  for (const { number, body } of vase.revealed(1)) { program.sendBinary(binaryMessage(1, number, 1, body)); }
  program.sendText({ type: 'files', files: [{ name: 'model.glb', bytes: 1712344 }, { name: 'a long name of a mesh <b>.stl', bytes: 343 }] });
  program.sendText({
    type: 'state', phase: 'scanning', tracking: 'lost', reason: 'place not recognised', advice: 'show something that was scanned before',
    frame: 123456, frames_total: 234567, lost: 1234, dropped: 5678, fps: 29.97, triangles: 12345678, memory_mib: 4096,
  });
  for (const size of [kPhone, { ...kPhone, viewport: { width: 320, height: 640 } }, { ...kPhone, viewport: { width: 844, height: 390 } }]) {
    const page = await openPage(program.url, { size });
    await untilTriangles(page, vase.triangles(1));
    await page.locator('#files-open').click();
    assert.deepEqual(await smallTargets(page), []);
    assert.equal(await isWiderThanScreen(page), false);
    assert.equal(await page.locator('#file-list a').last().getAttribute('href'), 'files/a%20long%20name%20of%20a%20mesh%20%3Cb%3E.stl');
    await page.locator('#files-close').click();
    const stage = await page.locator('#view').boundingBox();
    assert.ok(stage.height > 100 && stage.width > 200, `there is room for the mesh: ${stage.width} x ${stage.height}`);
    await keepScreenshot(page, `lost_${size.viewport.width}`);
    assert.deepEqual(page.problems, []);
  }
});

test('the crop panel covers nothing that is shown, and leaves the mesh to be seen', async (context) => {
  const program = await startMock(context);
  const vase = chunksOfVase(chunkBody);
  for (const { number, body } of vase.revealed(1)) { program.sendBinary(binaryMessage(1, number, 1, body)); }
  program.sendText({ type: 'files', files: [{ name: 'model.glb', bytes: 1712344 }] });
  program.sendText({
    type: 'state', phase: 'scanning', tracking: 'lost', reason: 'place not recognised', advice: 'show something that was scanned before',
    frame: 12345, frames_total: 23456, lost: 1234, dropped: 5678, fps: 29.97, triangles: 1234567, losses: { transport: 3, writer: 12 },
  });
  for (const [width, height] of [[320, 640], [390, 844], [844, 390], [1280, 800]]) {
    const page = await openPage(program.url, { size: width < 1000 ? { ...kPhone, viewport: { width, height } } : undefined });
    await untilTriangles(page, vase.triangles(1));
    program.sendBinary(binaryMessage(3, 0, 1, depthJpeg()));
    await page.waitForFunction(() => window.scanknit.depthPictures > 0);
    await command(page, 'crop').click();
    await page.locator('#crop').waitFor();
    const covered = await page.evaluate(() => {
      const box = (element) => element.getBoundingClientRect();
      const panel = box(document.getElementById('crop'));
      const others = ['#banner', '#numbers', '#depth', '#ring', '#files-open', '#actions', '.toggles', '.segments'].map((name) => [name, document.querySelector(name)]);
      return others.filter(([, element]) => element.checkVisibility()).filter(([, element]) => {
        const { left, right, top, bottom } = box(element);
        return left < panel.right - 1 && panel.left < right - 1 && top < panel.bottom - 1 && panel.top < bottom - 1;
      }).map(([name]) => name);
    });
    assert.deepEqual(covered, [], `${width} x ${height}`);
    assert.deepEqual(await smallTargets(page), []);
    const panel = await page.locator('#crop').boundingBox();
    assert.ok(panel.y >= 0 && panel.y + panel.height <= height, `all of it is on a screen of ${width} x ${height}`);
    const stage = await page.locator('#view').boundingBox();
    assert.ok(stage.height > 120 && stage.width > 200, `there is room for the mesh: ${stage.width} x ${stage.height}`);
    await keepScreenshot(page, `crop_${width}`);
  }
});

test('all of it is reached by keys', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning' });
  program.sendBinary(binaryMessage(1, 1, 1, square()));
  const page = await openPage(program.url);
  await untilTriangles(page, 2);
  const reached = new Set();
  for (let i = 0; i < 20; ++i) {
    await page.keyboard.press('Tab');
    reached.add(await page.evaluate(() => document.activeElement.id || document.activeElement.dataset.command || document.activeElement.dataset.shading));
  }
  for (const name of ['view', 'lit', 'fit', 'follow', 'ring-toggle', 'pause', 'reset', 'crop', 'export', 'finish']) {
    assert.ok(reached.has(name), `${name} is reached: ${[...reached]}`);
  }
  await page.locator('[data-shading=lit]').focus();
  await page.keyboard.press('ArrowRight');
  assert.equal(await look(page, 'shading'), 'unlit');
  await page.locator('#view').focus();
  const before = await page.evaluate(() => window.scanknit.place([1, 1, 0]));
  await page.keyboard.press('ArrowRight');
  await page.waitForFunction((was) => Math.abs(window.scanknit.place([1, 1, 0])[0] - was) > 1, before[0]);
});

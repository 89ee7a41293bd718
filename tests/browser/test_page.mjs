// What the page draws, and how it fits a screen, a finger and a keyboard.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  colourAt, command, isWiderThanScreen, keepScreenshot, kPhone, look, openPage,
  smallTargets, untilTriangles, useBrowser,
} from './browser.mjs';
import { kCorners, lookAtSquare, square, startMock } from './mock_page.mjs';
import { binaryMessage, chunkBody } from './mock_program.mjs';
import { chunksOfVase, depthJpeg, orbitPose } from './mock_scan.mjs';

useBrowser();

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
  await page.waitForFunction(() => window.scanknit.state?.frame === 77);
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

/// A picture of what a turntable's scanner is cut to.
const jpegOf = (page, width, height) => page.evaluate(([w, h]) => {
  const canvas = Object.assign(document.createElement('canvas'), { width: w, height: h });
  canvas.getContext('2d').fillRect(0, 0, w, h);
  return canvas.toDataURL('image/jpeg').split(',')[1];
}, [width, height]).then((base64) => Buffer.from(base64, 'base64'));

const isOnScreen = (page, selector) => page.locator(selector).evaluateAll((elements) => elements.length > 0 && elements.every((element) => {
  const { left, top, right, bottom } = element.getBoundingClientRect();
  const isInside = left >= 0 && top >= 0 && right <= window.innerWidth && bottom <= window.innerHeight;
  const isPassedThrough = getComputedStyle(element).pointerEvents === 'none';
  return isInside && (isPassedThrough || element.contains(document.elementFromPoint((left + right) / 2, (top + bottom) / 2)));
}));

test('a tall depth picture leaves the ring, the files and the handles of the crop box on the screen', async (context) => {
  const program = await startMock(context);
  const vase = chunksOfVase(chunkBody);
  for (const { number, body } of vase.revealed(1)) { program.sendBinary(binaryMessage(1, number, 1, body)); }
  program.hello.is_orbit = true;
  program.sendText({ type: 'state', phase: 'paused', fused: 9, triangles: 347608, is_behind: true });
  program.sendText({ type: 'trail', points: Array.from({ length: 9 }, (_, i) => orbitPose(i / 9).slice(12, 15)) });
  program.sendText({ type: 'files', files: [{ name: 'model.glb', bytes: 1712344 }, { name: 'model.stl', bytes: 343 }] });
  const desk = (width, height) => ({ viewport: { width, height } });
  for (const size of [desk(1280, 800), desk(1024, 768), desk(1366, 650), kPhone]) {
    const page = await openPage(program.url, { size });
    const { width, height } = size.viewport;
    await untilTriangles(page, vase.triangles(1));
    program.sendBinary(binaryMessage(3, 0, 1, new Uint8Array(await jpegOf(page, 150, 360))));
    await page.waitForFunction(() => window.scanknit.depthPictures > 0);
    await keepScreenshot(page, `tall_picture_${width}_${height}`);
    assert.ok(await isOnScreen(page, '#depth'), `the depth picture, ${width} x ${height}`);
    if (size !== kPhone) { assert.ok(await isOnScreen(page, '#ring-text'), `the ring, ${width} x ${height}`); }
    await page.locator('#files-open').dispatchEvent('click');  // does not scroll to it
    assert.ok(await isOnScreen(page, '#file-list a'), `the files, ${width} x ${height}`);
    await page.locator('#files-close').click();
    assert.equal(await page.locator('#triangles').evaluate((figure) => figure.getClientRects().length), 1);
    await command(page, 'crop').click();
    await page.waitForFunction(() => document.getElementById('crop').checkVisibility());
    assert.equal(await page.locator('#depth').isVisible(), size !== kPhone, 'it would cover a handle');
    await keepScreenshot(page, `tall_picture_crop_${width}_${height}`);
  }
});

test('on a phone everything fits and every button can be hit', async (context) => {
  const program = await startMock(context);
  const vase = chunksOfVase(chunkBody);
  for (const { number, body } of vase.revealed(1)) { program.sendBinary(binaryMessage(1, number, 1, body)); }
  program.sendText({ type: 'files', files: [{ name: 'model.glb', bytes: 1712344 }, { name: 'a long name of a mesh <b>.stl', bytes: 343 }] });
  program.sendText({
    type: 'state', phase: 'scanning', fused: 9, tracking: 'lost', reason: 'place not recognised', advice: 'show something that was scanned before',
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

test('all of it is reached by keys', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning', fused: 9 });
  program.sendBinary(binaryMessage(1, 1, 1, square()));
  const page = await openPage(program.url);
  await untilTriangles(page, 2);
  const reached = new Set();
  for (let i = 0; i < 20; ++i) {
    await page.keyboard.press('Tab');
    reached.add(await page.evaluate(() => document.activeElement.id || document.activeElement.dataset.command || document.activeElement.dataset.shading));
  }
  for (const name of ['view', 'lit', 'measure-open', 'fit', 'follow', 'ring-toggle', 'pause', 'reset', 'crop', 'export', 'finish']) {
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

// What the page says of the scan and of its connection, and what it does when that breaks.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { banner, colourAt, isWiderThanScreen, kPhone, look, openPage, untilBanner, untilTriangles, useBrowser } from './browser.mjs';
import { lookAtSquare, square, startMock } from './mock_page.mjs';
import { binaryMessage } from './mock_program.mjs';

useBrowser();

test('the banner says in words, colour and sign how it goes and what to do', async (context) => {
  const program = await startMock(context);
  const page = await openPage(program.url);
  const cases = [
    [{ phase: 'waiting', frame: 3 }, { tone: 'quiet', head: 'Waiting for the first frame', advice: 'Of 3 so far none could be used.' }],
    [{ phase: 'waiting', frame: 0, message: 'learning what stands still 3 of 48' },
      { tone: 'quiet', head: 'Getting ready', advice: 'Learning what stands still 3 of 48' }],
    [{ phase: 'scanning', message: '', tracking: 'ok', reason: '', advice: '' }, { tone: 'good', head: 'Tracking well', advice: '' }],
    [{ silent_s: 5 }, { tone: 'warn', head: 'No frames come', advice: 'Nothing from the scanner for 5 s.' }],
    [{ silent_s: 0, tracking: 'weak', reason: 'flat scene', advice: 'let something with edges into view' },
      { tone: 'warn', head: 'Weak: flat scene', advice: 'Let something with edges into view' }],
    [{ tracking: 'lost', reason: 'turned too fast', advice: 'turn back a little' },
      { tone: 'bad', head: 'Lost: turned too fast', advice: 'Turn back a little' }],
    [{ tracking: 'recovered', reason: '', advice: '' }, { tone: 'good', head: 'Found again', advice: '' }],
    [{ tracking: 'none' }, { tone: 'good', head: 'Scanning', advice: '' }],
    [{ tracking: 'unusable', reason: 'nothing seen', advice: 'uncover the lens, or move closer' },
      { tone: 'bad', head: 'No usable frame: nothing seen', advice: 'Uncover the lens, or move closer' }],
    [{ phase: 'paused' }, { tone: 'quiet', head: 'Paused', advice: 'Start goes on where it stopped.' }],
    [{ phase: 'exporting', message: 'fusing again 3 of 7' }, { tone: 'quiet', head: 'Working on the mesh', advice: 'Fusing again 3 of 7' }],
    [{ phase: 'exporting', message: '' }, { tone: 'quiet', head: 'Writing the mesh', advice: '' }],
    [{ phase: 'failed', message: 'the disk is full' }, { tone: 'bad', head: 'The scan failed', advice: 'The disk is full' }],
  ];
  const signs = new Set();
  for (const [state, words] of cases) {
    program.sendText({ type: 'state', ...state });
    await page.waitForFunction(({ head, advice }) => document.getElementById('banner-head').textContent === head
      && document.getElementById('banner-advice').textContent === advice, words);
    assert.deepEqual(await banner(page), words);
    if (words.tone !== 'good') { signs.add(await page.locator('#banner-sign').textContent()); }
  }
  assert.equal(signs.size, 5, 'not by colour only: waiting, warned, lost (as failed), paused and writing have signs of their own');
  assert.equal(await page.locator('#banner-words').getAttribute('aria-live'), 'assertive');
});

test('frames that come whether they are taken or not do not wait for a pause to end', async (context) => {
  const program = await startMock(context);
  program.hello.is_paced = true;
  program.sendText({ type: 'state', phase: 'paused' });
  const page = await openPage(program.url);
  await untilBanner(page, 'Paused');
  assert.equal((await banner(page)).advice, 'Frames pass by meanwhile. Start goes on with those that come then.');
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
  await page.waitForFunction(() => window.scanknit.state?.frame === 2);
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

// The buttons that steer the scan, and the crop box.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { command, keepScreenshot, kPhone, look, openPage, smallTargets, untilBanner, untilPhase, untilTriangles, useBrowser } from './browser.mjs';
import { square, startMock } from './mock_page.mjs';
import { binaryMessage, chunkBody } from './mock_program.mjs';
import { chunksOfVase, depthJpeg } from './mock_scan.mjs';

useBrowser();

test('the crop panel closes when there is nothing to be cut any more', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning', fused: 9 });
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

test('only the commands that the scan takes are shown, and a refusal is told', async (context) => {
  const program = await startMock(context);
  program.hello.commands = ['pause', 'export'];
  program.sendText({ type: 'state', phase: 'scanning', fused: 9 });
  program.answer = ({ cmd }) => (cmd === 'export' ? 'nothing to write yet' : '');
  const page = await openPage(program.url);
  await command(page, 'pause').waitFor();
  const shown = await page.locator('[data-command]:visible').evaluateAll((buttons) => buttons.map((button) => button.dataset.command));
  assert.deepEqual(shown, ['pause', 'export']);
  await command(page, 'export').click();
  await page.locator('#note.bad').waitFor();
  assert.equal(await page.locator('#note').textContent(), 'Export: nothing to write yet');
});

test('what needs a scan waits until something is fused', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning', fused: 0 });
  const page = await openPage(program.url);
  const possible = () => page.locator('[data-command]:visible:enabled').evaluateAll((buttons) => buttons.map((button) => button.dataset.command));
  await page.waitForFunction(() => window.scanknit.state?.phase === 'scanning');
  assert.deepEqual(await possible(), ['pause', 'finish']);
  program.sendText({ type: 'state', fused: 1 });
  await command(page, 'export').and(page.locator(':enabled')).waitFor();
  assert.deepEqual(await possible(), ['pause', 'reset', 'crop', 'export', 'finish']);
});

test('reset asks once more', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning', fused: 9 });
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
    await untilPhase(page, phase);
    return page.locator('[data-command=start]:visible, [data-command=pause]:visible').evaluateAll((buttons) => buttons.map((button) => button.textContent));
  };
  const phases = ['waiting', 'scanning', 'exporting', 'paused', 'exporting'];
  const seen = [];
  for (const phase of phases) { seen.push(await shown(phase)); }
  assert.deepEqual(seen, [['Pause'], ['Pause'], ['Pause'], ['Start'], ['Start']]);
});

test('a command is not sent when the scan has ended behind its question', async (context) => {
  const program = await startMock(context);
  program.sendText({ type: 'state', phase: 'scanning', fused: 9 });
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
  program.sendText({ type: 'state', phase: 'scanning', fused: 9 });
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
  program.sendText({ type: 'state', phase: 'paused', fused: 9 });
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

test('the crop panel covers nothing that is shown, and leaves the mesh to be seen', async (context) => {
  const program = await startMock(context);
  const vase = chunksOfVase(chunkBody);
  for (const { number, body } of vase.revealed(1)) { program.sendBinary(binaryMessage(1, number, 1, body)); }
  program.sendText({ type: 'files', files: [{ name: 'model.glb', bytes: 1712344 }] });
  program.sendText({
    type: 'state', phase: 'scanning', fused: 9, tracking: 'lost', reason: 'place not recognised', advice: 'show something that was scanned before',
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

// The measuring tool: picks on known shapes give their measures, by mouse, finger and keys.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { isWiderThanScreen, kPhone, keepScreenshot, look, openPage, smallTargets, untilTriangles, useBrowser } from './browser.mjs';
import { boxOf, chunkOf, plyOf, sphereOf, tubeOf } from './known_shapes.mjs';
import { startMock } from './mock_page.mjs';
import { binaryMessage, chunkBody } from './mock_program.mjs';
import { startProgram, temporaryFolder } from './program.mjs';

useBrowser();

function assertWithin1Percent(value, expected, what) {
  assert.ok(Math.abs(value - expected) <= 0.01 * Math.abs(expected), `${what}: ${value}, expected ${expected}`);
}

async function beginMeasuring(page, eye, triangles) {
  await untilTriangles(page, triangles);
  await page.evaluate((from) => window.scanknit.look(from, [0, 0, 0]), eye);
  await page.locator('#measure-open').click();
}

/// The shape on a page of the mock program, seen from `eye`, with the tool open; {page, program}.
async function openShape(context, shape, { size, mode = 'file', voxel = 0, coverage = 255, eye }) {
  const program = await startMock(context);
  Object.assign(program.hello, { title: 'shape.ply', mode, up: [0, 0, 1], voxel_size_m: voxel, commands: [] });
  program.sendText({ type: 'state', phase: mode === 'file' ? 'finished' : 'scanning', triangles: shape.triangles.length });
  program.sendBinary(binaryMessage(1, 1, 1, chunkBody(...chunkOf(shape, coverage), { hasColours: false })));
  const page = await openPage(program.url, { size });
  await beginMeasuring(page, eye, shape.triangles.length);
  return { page, program };
}

/** Where the point is in the window, once that stays the same for two pictures: panels that grow move the view. */
async function placeOf(page, p) {
  return page.evaluate(async (point) => {
    const place = () => {
      const { left, top } = document.getElementById('view').getBoundingClientRect();
      const [x, y] = window.scanknit.place(point);
      return [left + x, top + y];
    };
    const nextPicture = () => new Promise((done) => requestAnimationFrame(done));
    for (let before = place(), same = 0; ;) {
      await nextPicture();
      const now = place();
      same = now[0] === before[0] && now[1] === before[1] ? same + 1 : 0;
      if (same === 2) { return now; }
      before = now;
    }
  }, p);
}
const pick = async (page, ...points) => {
  for (const p of points) { await page.mouse.click(...await placeOf(page, p)); }
};
const choose = (page, kind) => page.locator(`[data-kind=${kind}]`).click();
const around = (radius, turns, z) => turns.map((turn) => [radius * Math.cos(turn), radius * Math.sin(turn), z]);

test('a box has the distances, angles and sections of a box', async (context) => {
  const { page } = await openShape(context, boxOf([0.1, 0.06, 0.04]), { eye: [0.12, -0.18, 0.16] });
  await pick(page, [-0.045, -0.03, 0.01], [0.045, -0.03, 0.01]);
  await choose(page, 'angle');
  await pick(page, [-0.04, 0.02, 0.02], [-0.04, -0.02, 0.02], [0.04, -0.02, 0.02]);
  await choose(page, 'section');
  await page.locator('[data-plane=x]').click();
  await pick(page, [0.01, -0.03, 0.005]);
  await page.locator('[data-plane=points]').click();
  await pick(page, [0.03, -0.03, 0.01], [0.05, -0.01, 0.01], [-0.03, -0.03, 0.01]);
  const [distance, angle, across, flat] = await look(page, 'measures');
  assertWithin1Percent(distance.values[0].value, 0.09, 'distance');
  assertWithin1Percent(angle.values[0].value, Math.PI / 2, 'angle');
  assertWithin1Percent(across.values[0].value, 0.2, 'outline across x');
  assertWithin1Percent(across.values[1].value, 0.0024, 'area across x');
  assertWithin1Percent(flat.values[0].value, 0.32, 'outline through three points');
  assertWithin1Percent(flat.values[1].value, 0.006, 'area through three points');
  assert.match(await page.locator('#measure-list').innerText(), /90\.\d.* mm/);
  assert.match(await page.locator('#measure-source').innerText(), /not known/);
  await keepScreenshot(page, 'measure_box');
  const download = page.waitForEvent('download');
  await page.locator('#measure-list button').first().click();
  const svg = readFileSync(await (await download).path(), 'utf8');
  assert.match(svg, /^<svg [^>]*mm/);
  assert.deepEqual(page.problems, []);
});

test('a ball and a tube have their diameters, with an uncertainty by voxels and coverage', async (context) => {
  const ball = await openShape(context, sphereOf(0.05), { eye: [0.02, -0.01, 0.2], voxel: 0.002 });
  await choose(ball.page, 'section');
  await ball.page.locator('[data-plane=z]').click();
  await pick(ball.page, [0.04, 0, 0.03]);
  await choose(ball.page, 'diameter');
  await pick(ball.page, ...around(0.04, [0, 2.1, 4.2], 0.03));
  const [section, diameter] = await look(ball.page, 'measures');
  assertWithin1Percent(section.values[0].value, 2 * Math.PI * 0.04, 'outline');
  assertWithin1Percent(section.values[1].value, Math.PI * 0.04 ** 2, 'area');
  assertWithin1Percent(diameter.values[0].value, 0.08, 'circle of latitude');
  assert.equal(diameter.from, 'voxels');
  await keepScreenshot(ball.page, 'measure_ball');

  const tube = await openShape(context, tubeOf(0.02, 0.03, 0.04), { eye: [0.01, -0.06, 0.14], voxel: 0.002 });
  await choose(tube.page, 'diameter');
  await pick(tube.page, ...around(0.02, [0.6, 1.5, 2.5], 0.012));
  const [hole] = await look(tube.page, 'measures');
  assertWithin1Percent(hole.values[0].value, 0.04, 'hole');
  assert.equal(hole.words[0], 'hole');
  const sigma = 0.002 * Math.hypot(0.85 / Math.sqrt(10), 0.05);
  assertWithin1Percent(hole.values[0].sigma, 2 * sigma, 'all round and well seen');
  await keepScreenshot(tube.page, 'measure_tube');
});

test('the finished mesh of a file is measured over all its chunks, with the uncertainty that it states', async () => {
  const shape = sphereOf(0.05, 160);  // 101,760 triangles: several chunks
  const path = join(temporaryFolder(), 'ball.ply');
  writeFileSync(path, plyOf(shape, { uncertainty: 0.0002 }));
  const program = await startProgram('view', path, '--port', '0', '--set', 'export.up=z');
  const page = await openPage(program.url);
  await beginMeasuring(page, [0.02, -0.2, 0.1], shape.triangles.length);
  assert.ok(await look(page, 'chunks') > 1);
  await choose(page, 'section');
  await page.locator('[data-plane=x]').click();
  await pick(page, [0.02, -0.04, Math.sqrt(0.05 ** 2 - 0.02 ** 2 - 0.04 ** 2)]);
  const [section] = await look(page, 'measures');
  assert.deepEqual(section.words, ['1 closed']);
  assertWithin1Percent(section.values[1].value, Math.PI * (0.05 ** 2 - 0.02 ** 2), 'area');
  assert.equal(section.from, 'stated');
  assert.match(await page.locator('#measure-source').innerText(), /the file states/);
  assert.deepEqual(page.problems, []);
  assert.equal(await program.stop(), 0);
});

test('dragging turns the view, taps pick, and keys do without a mouse', async (context) => {
  const { page } = await openShape(context, boxOf([0.1, 0.06, 0.04]), { eye: [0, 0, 0.25] });
  const [x, y] = await placeOf(page, [0, 0, 0.02]);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 60, y, { steps: 4 });
  await page.mouse.up();
  assert.match(await page.locator('#measure-step').innerText(), /Pick a point/);
  await page.evaluate(() => window.scanknit.look([0, 0, 0.25], [0, 0, 0]));
  await page.locator('#view').focus();
  await page.keyboard.press('Enter');
  assert.match(await page.locator('#measure-step').innerText(), /second point/);
  await page.keyboard.press('Escape');
  assert.match(await page.locator('#measure-step').innerText(), /Pick a point/);
  await page.keyboard.press('Enter');
  await page.evaluate(() => window.scanknit.look([0.03, 0, 0.25], [0.03, 0, 0]));
  await page.keyboard.press('Enter');
  assertWithin1Percent((await look(page, 'measures'))[0].values[0].value, 0.03, 'distance by keys');
  await page.keyboard.press('Backspace');
  assert.deepEqual(await look(page, 'measures'), []);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#measure').isVisible(), false);
  assert.equal(await page.locator('#measure-open').getAttribute('aria-expanded'), 'false');
});

test('a pick beside the mesh says so, undo and clear take back, and the unit can be chosen', async (context) => {
  const { page } = await openShape(context, boxOf([0.1, 0.06, 0.04]), { eye: [0, 0, 0.25] });
  await pick(page, [0.12, 0.07, 0.02]);
  assert.match(await page.locator('#measure-step').innerText(), /no surface/);
  await pick(page, [-0.04, 0, 0.02], [0.04, 0, 0.02], [0, -0.02, 0.02], [0, 0.02, 0.02], [0, 0, 0.02]);
  assert.equal((await look(page, 'measures')).length, 2);
  await page.locator('#measure-undo').click();
  assert.equal((await look(page, 'measures')).length, 2, 'the single point first');
  await page.locator('#measure-undo').click();
  assert.equal((await look(page, 'measures')).length, 1);
  await page.locator('#measure-unit').selectOption('in');
  assert.match(await page.locator('#measure-list').innerText(), /3\.1\d* ± [\d.]+ in/);
  await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
  await page.locator('#measure-csv').click();
  await page.waitForFunction(() => document.getElementById('note').textContent === 'Copied.');
  const copied = await page.evaluate(() => navigator.clipboard.readText());
  assert.match(copied, /^number,measure,value.*\r?\n1,Distance,3\.1\d*,[\d.]+,in,unknown,/);
  await page.locator('#measure-clear').click();
  assert.deepEqual(await look(page, 'measures'), []);
  assert.equal(await page.locator('#measure-csv').isDisabled(), true);
});

test('on a running scan the measures are called a preview, and a reset removes them', async (context) => {
  const options = { eye: [0, 0, 0.25], mode: 'run', voxel: 0.002, coverage: 0 };
  const { page, program } = await openShape(context, boxOf([0.1, 0.06, 0.04]), options);
  await pick(page, [-0.04, 0, 0.02], [0.04, 0, 0.02]);
  assert.match(await page.locator('#measure-source').innerText(), /Preview.*voxels of 2\.0 mm/);
  const [{ values: [distance] }] = await look(page, 'measures');
  assertWithin1Percent(distance.sigma, Math.SQRT2 * Math.hypot(0.002 * Math.hypot(0.85, 0.05)), 'seen once, from both ends');
  program.sendText({ type: 'trail', points: [] });
  await page.waitForFunction(() => window.scanknit.measures.length === 0);
});

test('on a phone the tool fits, its buttons can be hit, and a tap picks', async (context) => {
  for (const viewport of [{ width: 390, height: 844 }, { width: 320, height: 640 }, { width: 844, height: 390 }]) {
    const { page } = await openShape(context, boxOf([0.1, 0.06, 0.04]), { eye: [0, 0, 0.25], size: { ...kPhone, viewport } });
    await choose(page, 'section');
    assert.deepEqual(await smallTargets(page), []);
    assert.equal(await isWiderThanScreen(page), false);
    await choose(page, 'distance');
    for (const p of [[-0.03, 0, 0.02], [0.03, 0, 0.02]]) { await page.touchscreen.tap(...await placeOf(page, p)); }
    const [distance] = await look(page, 'measures');
    assertWithin1Percent(distance.values[0].value, 0.06, 'distance by taps');
    const stage = await page.locator('#view').boundingBox();
    assert.ok(stage.height > 100 && stage.width > 200, `there is room for the mesh: ${stage.width} x ${stage.height}`);
    await keepScreenshot(page, `measure_phone_${viewport.width}`);
    assert.deepEqual(page.problems, []);
  }
});

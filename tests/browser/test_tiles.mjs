// A mesh in tiles: coarse from afar, fine from near, and the same picture as the whole mesh.

import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { kDesk, keepScreenshot, look, openPage, untilTriangles, useBrowser } from './browser.mjs';
import { scanknit, startProgram, synthesise, temporaryFolder } from './program.mjs';

const kBudgetBytes = 160 * 2 ** 20;
const kFirstPictureMs = 2000;

useBrowser();
const folder = temporaryFolder();
const recording = synthesise(join(folder, 'room'), 'room', { frames: 60, width: 320, height: 240 });
const out = join(folder, 'out');
scanknit('run', recording, '-o', out, '--poses', 'recording', '--set', 'fusion.voxel_size=14mm', '--set', 'export.formats=[ply,tiles]',
  '--set', 'export.world_up=-y', '--quiet');
const { root, asset } = JSON.parse(readFileSync(join(out, 'model.tiles', 'tileset.json'), 'utf8'));
const triangles = asset.extras.triangles;
const depth = (tile) => 1 + Math.max(0, ...(tile.children ?? []).map(depth));

const untilSettled = (page) => page.waitForFunction(() => window.scanknit.tiles?.isSettled);

/// The page with nothing more to come.
async function openTiles(options) {
  const program = await startProgram('view', out, '--port', '0');
  const page = await openPage(program.url, options);
  await untilSettled(page);
  return { page, program };
}

const lookAt = (page, eye, target) => page.evaluate(([e, t]) => window.scanknit.look(e, t), [eye, target]);

/// Settled there: the picture asks for tiles, they come, and ask for the next picture.
async function settleAt(page, eye, target) {
  await lookAt(page, eye, target);
  await page.waitForTimeout(300);
  await untilSettled(page);
  return look(page, 'tiles');
}

test('the room has several levels of tiles', () => {
  assert.ok(depth(root) >= 2, `${depth(root)}`);
  assert.ok(readdirSync(join(out, 'model.tiles')).length > 4);
});

test('the output folder of a run shows its tiles, within two seconds, and says how many triangles there are', async () => {
  const { page, program } = await openTiles();
  assert.equal((await look(page, 'hello')).tiles, '/files/tileset.json');
  assert.equal((await look(page, 'state')).triangles, triangles);
  assert.ok(await look(page, 'firstMeshMs') < kFirstPictureMs, `${await look(page, 'firstMeshMs')} ms`);
  assert.equal(await page.locator('#measure-open').isVisible(), false);
  assert.deepEqual(page.problems, []);
  await keepScreenshot(page, 'tiles');
  assert.equal(await program.stop(), 0);
});

test('from afar few triangles are drawn, from near all that are there', async () => {
  const { page } = await openTiles();
  const [x, y, z, a, , , , b] = root.boundingVolume.box;
  const reach = 2 * Math.max(a, b);
  const far = await settleAt(page, [x + 40 * reach, y, z + 20 * reach], [x, y, z]);
  assert.equal(far.tiles, 1);
  assert.ok(far.triangles < triangles / 2, `${far.triangles} of ${triangles}`);
  const near = await settleAt(page, [x + 0.1, y, z], [x + 0.4, y, z]);
  assert.ok(near.tiles > 1);
  assert.equal(near.problems, 0);
  assert.ok(near.bytes <= kBudgetBytes);
  assert.deepEqual(page.problems, []);
});

/// Red, green, blue, alpha of the whole canvas.
const pixels = (page) => page.evaluate(() => {
  window.scanknit.pixel(0, 0);
  const canvas = document.getElementById('view');
  const gl = canvas.getContext('webgl2');
  const bytes = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
  gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  return [...bytes];
});

test('what is seen has no crack: nowhere the background shines through that the whole mesh covers', async () => {
  const whole = await startProgram('view', join(out, 'model.ply'), '--port', '0');
  const wholePage = await openPage(whole.url, { size: kDesk });
  await untilTriangles(wholePage, triangles);
  const { page } = await openTiles({ size: kDesk });
  await wholePage.evaluate(() => {  // the same size as the tiles' canvas
    document.getElementById('files-open').hidden = true;
    document.getElementById('measure-open').hidden = true;
  });
  await wholePage.waitForFunction((height) => document.getElementById('view').clientHeight === height,
    await page.evaluate(() => document.getElementById('view').clientHeight));
  const [x, y, z, a, , , , b] = root.boundingVolume.box;
  for (const turn of [0, 2.6]) {
    const eye = [x + 0.4 * a * Math.cos(turn), y + 0.4 * b * Math.sin(turn), z];
    const target = [x - a * Math.cos(turn), y - b * Math.sin(turn), z];
    await settleAt(page, eye, target);
    // The mesh of the PLY is in the recording's world, -y up: x, -z, y are the tiles' x, y, z after the quarter turn of `up_rotation`.
    const inWorld = ([p, q, r]) => [p, -r, q];
    await lookAt(wholePage, inWorld(eye), inWorld(target));
    const [tiled, full] = [await pixels(page), await pixels(wholePage)];
    let covered = 0, open = 0, other = 0;
    for (let i = 0; i < full.length; i += 4) {
      if (full[i + 3] === 0) { continue; }
      ++covered;
      if (tiled[i + 3] === 0) { ++open; } else if (Math.abs(tiled[i] - full[i]) + Math.abs(tiled[i + 1] - full[i + 1]) > 90) { ++other; }
    }
    await keepScreenshot(page, `tiles_${turn}`);
    await keepScreenshot(wholePage, `whole_${turn}`);
    assert.ok(covered > 100_000, `turn ${turn}: ${covered}`);
    assert.ok(open < 0.001 * covered, `turn ${turn}: ${open} of ${covered} pixels are open`);
    assert.ok(other < 0.05 * covered, `turn ${turn}: ${other} of ${covered} pixels differ`);
  }
});

test('tiles on the Earth are shown as those that are nowhere', async () => {
  const placed = join(folder, 'placed.tiles');
  scanknit('run', recording, '-o', placed, '--poses', 'recording', '--set', 'fusion.voxel_size=2cm',
    '--set', 'export.georeference.longitude=13.4', '--set', 'export.georeference.latitude=52.5', '--quiet');
  const program = await startProgram('view', placed, '--port', '0');
  const page = await openPage(program.url);
  await untilSettled(page);
  const { root: own } = JSON.parse(readFileSync(join(placed, 'tileset.json'), 'utf8'));
  const [x, y, z] = own.boundingVolume.box;
  const near = await settleAt(page, [x, y, z], [x + 1, y, z]);
  assert.ok(near.triangles > 0);
  assert.deepEqual(await page.evaluate(() => window.scanknit.pixel(640, 400)[3]), 255);
  assert.deepEqual(page.problems, []);
});

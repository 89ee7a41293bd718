// The real program and the real page: a recording is replayed while somebody looks on and presses buttons.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { test } from 'node:test';
import {
  banner, colourAt, command, isWiderThanScreen, keepScreenshot, kPhone, look, openPage, smallTargets, untilBanner, untilPhase,
  untilTriangles, useBrowser,
} from './browser.mjs';
import { kBlue, kGreen, kRed, scanknit, startProgram, synthesise, temporaryFolder, writeColouredBox } from './program.mjs';

const validator = createRequire(import.meta.url)('gltf-validator');

/// Of 255: fusing rounds a colour to bytes with each frame. (What the page adds is nothing: test_page.mjs.)
const kFusedColourError = 2;

const kTurntableFrames = 240;

useBrowser();
const folder = temporaryFolder();
const box = synthesise(join(folder, 'box'), writeColouredBox(join(folder, 'box.ply')), { frames: 180 });
const turntable = synthesise(join(folder, 'turntable'), 'turntable', { frames: kTurntableFrames });
const kScan = ['--preset', 'object', '--set', 'fusion.voxel_size=4mm', '--view', '--port', '0'];
/// A frame for each step(): however slow the machine is, the scan is where the test thinks.
const kStepped = [...kScan, '--pace', 'stepped'];

/// Commands are looked at, and the mesh is sent as far as its share of the time allows, between two frames.
async function stepUntil(program, outcome) {
  const timer = setInterval(() => program.step(1), 200);
  await outcome.finally(() => clearInterval(timer));
}

test('the page loads under its policy, the mesh grows, and its pixels are the colours of the thing', async () => {
  const program = await startProgram('run', box, '-o', join(folder, 'box_out'), ...kStepped);
  const page = await openPage(program.url);
  const policy = page.answer.headers()['content-security-policy'];
  assert.match(policy, /default-src 'none'/);
  assert.doesNotMatch(policy, /unsafe/);
  await stepUntil(program, untilTriangles(page, 1));
  await stepUntil(program, page.waitForFunction(() => window.scanknit.depthPictures > 0));
  assert.ok((await look(page, 'firstMeshMs')) > 0);
  assert.equal((await look(page, 'hello')).is_orbit, true);
  const before = await look(page, 'triangles');

  program.step(1000);  // to the end
  await untilPhase(page, 'finished');
  const { triangles } = await look(page, 'state');
  await page.waitForFunction((n) => window.scanknit.triangles === n, triangles);
  assert.ok(triangles > before, `it grew from ${before} to ${triangles}`);
  const revisions = Object.values(await look(page, 'revisions'));
  assert.ok(Math.max(...revisions) > 1, 'chunks came again when they had changed');
  const sides = await look(page, 'sectorsSeen');
  assert.ok(sides > 18 && await page.locator('#ring').isVisible(), `the scanner walked round it: ${sides} sides`);
  assert.deepEqual(await banner(page), { tone: 'done', head: 'Finished', advice: '' });

  await page.evaluate(() => { window.scanknit.shading = 'unlit'; });
  const [low, high] = await look(page, 'bounds');
  const size = high.map((x, axis) => x - low[axis]);
  assert.ok(size.every((x) => x > 0.15 && x < 0.25), `a box of 20 cm: ${size}`);
  for (const side of [-1, 1]) {
    const [x, y, z] = low.map((_, axis) => (low[axis] + high[axis]) / 2);
    const face = z + (side * size[2]) / 2;
    await page.evaluate(([eye, target]) => window.scanknit.look(eye, target), [[x, y, face + 0.5 * side], [x, y, face]]);
    for (const [shift, colour] of [[-0.075, kRed], [0, kGreen], [0.075, kBlue]]) {
      const seen = await colourAt(page, [x + shift, y, face]);
      const error = Math.max(...seen.map((byte, i) => Math.abs(byte - colour[i])));
      assert.ok(error <= kFusedColourError, `${seen}, not ${colour}, at ${x + shift} of the face at z = ${face}`);
    }
  }
  assert.deepEqual(page.problems, []);
  assert.equal(await program.stop(), 0);
});

test('with a phone in hand: pause, crop, export and download, reset, start and finish', async () => {
  const out = join(folder, 'turntable_out');
  const program = await startProgram('run', turntable, '-o', out, ...kStepped);
  const page = await openPage(program.url, { size: kPhone });
  await untilBanner(page, 'Waiting');
  program.step(60);
  await stepUntil(program, untilTriangles(page, 500));
  await keepScreenshot(page, 'scanning_phone');
  await command(page, 'pause').click();
  await stepUntil(program, untilBanner(page, 'Paused'));
  assert.deepEqual(await smallTargets(page), []);
  assert.equal(await isWiderThanScreen(page), false);

  await command(page, 'export').click();
  await page.locator('#file-list a[download$=".glb"]').waitFor();
  await keepScreenshot(page, 'exported_phone');
  const [download] = await Promise.all([page.waitForEvent('download'), page.locator('#file-list a[download$=".glb"]').click()]);
  const glb = readFileSync(await download.path());
  await checkGlb(glb, await look(page, 'triangles'));
  assert.deepEqual(glb, readFileSync(join(out, 'model.glb')));
  await page.locator('#files-close').click();

  await command(page, 'crop').click();
  await page.getByLabel('X from').press('ArrowRight');
  await page.locator('#crop-apply').click();
  await page.locator('#crop').waitFor({ state: 'hidden' });
  await command(page, 'crop').click();
  await page.locator('#crop-clear').click();
  await page.locator('#crop').waitFor({ state: 'hidden' });

  await command(page, 'reset').click();
  await page.locator('#ask-yes').click();
  await page.waitForFunction(() => window.scanknit.triangles === 0 && window.scanknit.trailPoints <= 1);
  await command(page, 'start').click();
  await stepUntil(program, untilBanner(page, 'Scanning'));
  program.step(60);
  await stepUntil(program, untilTriangles(page, 500));
  await command(page, 'finish').click();
  await page.locator('#ask-yes').click();
  await stepUntil(program, untilBanner(page, 'Finished'));
  assert.ok((await look(page, 'state')).frame < kTurntableFrames, 'before its end');
  await untilTriangles(page, 500);
  assert.deepEqual(page.problems, []);
  assert.equal(await program.stop(), 0);
});

/// Its own checks pass, and it is the mesh that the page shows, but for what cleaning took away.
async function checkGlb(bytes, shownTriangles) {
  const report = await validator.validateBytes(new Uint8Array(bytes), { maxIssues: 20, writeTimestamp: false });
  assert.equal(report.issues.numErrors + report.issues.numWarnings, 0, JSON.stringify(report.issues.messages));
  const { totalTriangleCount: triangles } = report.info;
  assert.ok(triangles > shownTriangles / 2 && triangles < 2 * shownTriangles, `${triangles} triangles exported, ${shownTriangles} shown`);
}

test('a replay at the pace of the scanner is shown to its end', async () => {
  const program = await startProgram('run', turntable, '-o', join(folder, 'realtime_out'), ...kScan, '--pace', 'realtime');
  const page = await openPage(program.url);
  await untilPhase(page, 'finished');
  const { frame, fused, dropped, triangles } = await look(page, 'state');
  assert.equal(frame, kTurntableFrames);
  assert.equal(fused + dropped, frame, 'what came too late is counted');
  await page.waitForFunction((n) => window.scanknit.triangles === n, triangles);
  await keepScreenshot(page, 'finished_desk');
  assert.deepEqual(page.problems, []);
  assert.equal(await program.stop(), 0);
});

test('a program that is gone is told, and nothing can be pressed', async () => {
  const program = await startProgram('run', turntable, '-o', join(folder, 'ended_out'), ...kStepped);
  const page = await openPage(program.url);
  await stepUntil(program, untilTriangles(page, 100));
  program.kill();
  await untilBanner(page, 'Connection lost');
  assert.equal(await command(page, 'pause').isDisabled(), true);
});

test('a scan that is ended at the keyboard is told as that', async () => {
  const program = await startProgram('run', turntable, '-o', join(folder, 'interrupted_out'), ...kStepped);
  const page = await openPage(program.url);
  program.step(60);
  await stepUntil(program, untilTriangles(page, 500));
  assert.equal(await program.stop(), 130);
  await untilBanner(page, 'Finished');
  assert.match((await banner(page)).advice, /^Interrupted: .*written/);
});

test('`view` shows a finished mesh without buttons', async () => {
  const out = join(folder, 'box_shown');
  scanknit('run', box, '-o', out, '--set', 'fusion.voxel_size=4mm', '--quiet');
  const program = await startProgram('view', out, '--port', '0');
  const page = await openPage(program.url);
  await untilPhase(page, 'finished');
  const { triangles } = await look(page, 'state');
  await page.waitForFunction((n) => window.scanknit.triangles === n, triangles);
  assert.equal((await banner(page)).head, 'model.glb');
  assert.equal(await page.locator('#actions').isVisible(), false);
  await page.locator('#files-open').click();
  assert.deepEqual(await page.locator('#file-list b').allTextContents(), ['model.glb']);
  await keepScreenshot(page, 'view_desk');
  assert.deepEqual(page.problems, []);
  assert.equal(await program.stop(), 0);
});

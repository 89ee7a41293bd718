// A hand before the lens: the banner says so while it is there, and says that all is well again afterwards.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { banner, keepScreenshot, kPhone, openPage, untilBanner, useBrowser } from './browser.mjs';
import { coverFrames, startProgram, synthesise, temporaryFolder } from './program.mjs';

useBrowser();
const folder = temporaryFolder();

const kBefore = 30, kCovered = 6;  // frames

test('where poses are given, the banner changes as well', async () => {
  const recording = synthesise(join(folder, 'posed'), 'desk', { frames: 60 });
  coverFrames(recording, kBefore, kBefore + kCovered);
  const program = await startProgram('run', recording, '-o', join(folder, 'posed_out'), '--set', 'fusion.voxel_size=8mm', '--view', '--port', '0', '--pace', 'stepped');
  const page = await openPage(program.url);
  await untilBanner(page, 'Waiting');
  program.step(kBefore);
  await untilBanner(page, 'Scanning');
  program.step(kCovered);
  await untilBanner(page, 'No usable frame: nothing seen');
  assert.deepEqual(await banner(page), { tone: 'bad', head: 'No usable frame: nothing seen', advice: 'Uncover the lens, or move closer' });
  program.step(1);
  await untilBanner(page, 'Scanning');
  assert.deepEqual(page.problems, []);
  await program.stop();
});

test('the banner changes when frames are covered, and back', async () => {
  const recording = synthesise(join(folder, 'desk'), 'desk', { frames: 300 });
  coverFrames(recording, kBefore, kBefore + kCovered);
  const program = await startProgram('run', recording, '-o', join(folder, 'out'), '--poses', 'track', '--set', 'fusion.voxel_size=8mm',
    '--view', '--port', '0', '--pace', 'stepped');
  const page = await openPage(program.url, { size: kPhone });
  await untilBanner(page, 'Waiting');
  program.step(kBefore);
  await untilBanner(page, 'Tracking well');
  program.step(kCovered);
  await untilBanner(page, 'Lost');
  assert.deepEqual(await banner(page), { tone: 'bad', head: 'Lost: nothing seen', advice: 'Uncover the lens, or move closer' });
  await keepScreenshot(page, 'covered_phone');
  program.step(30);
  await page.waitForFunction(() => document.getElementById('banner').dataset.tone === 'good');
  await untilBanner(page, 'Tracking well');
  assert.deepEqual(page.problems, []);
  await program.stop();
});

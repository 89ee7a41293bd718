// A hand before the lens: the banner says so while it is there, and says that all is well again afterwards.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { banner, keepScreenshot, kPhone, openPage, untilBanner, untilPhase, useBrowser } from './browser.mjs';
import { coverFrames, startProgram, synthesise, temporaryFolder } from './program.mjs';

useBrowser();
const folder = temporaryFolder();

test('the banner changes when frames are covered, and back', async () => {
  const recording = synthesise(join(folder, 'desk'), 'desk', { frames: 300 });
  const program = await startProgram('run', recording, '-o', join(folder, 'out'), '--poses', 'track', '--set', 'fusion.voxel_size=8mm',
    '--view', '--port', '0', '--pace', 'realtime');
  coverFrames(recording, 150, 300);  // while the program is still far from them
  const page = await openPage(program.url, { size: kPhone });
  await untilBanner(page, 'Tracking well');
  await untilBanner(page, 'Lost');
  const words = await banner(page);
  assert.equal(words.tone, 'bad');
  assert.notEqual(words.advice, '', `what to do: ${JSON.stringify(words)}`);
  await keepScreenshot(page, 'covered_phone');
  await untilPhase(page, 'finished');
  assert.deepEqual(page.problems, []);
  await program.stop();
});

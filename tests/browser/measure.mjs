// node measure.mjs RECORDING [OPTION OF run ...]: what the live view of a replay costs and gives. SCANKNIT_PROGRAM is the
// program; SCANKNIT_SCREENSHOTS a folder for pictures at two thirds of the way.

import { join } from 'node:path';
import { test } from 'node:test';
import { keepScreenshot, kDesk, kPhone, look, openPage, untilPhase, useBrowser } from './browser.mjs';
import { startProgram, temporaryFolder } from './program.mjs';

process.env.SCANKNIT_CHROMIUM ??= '/usr/bin/chromium';
useBrowser();
const folder = temporaryFolder();
const [recording, ...options] = process.argv.slice(2);

test('measure', { timeout: 600_000 }, async () => {
  const program = await startProgram('run', recording, '-o', join(folder, 'out'), ...options, '--view', '--port', '0');
  const begun = performance.now();
  const page = await openPage(program.url, { size: kDesk, isTest: false });
  const phone = process.env.SCANKNIT_SCREENSHOTS ? await openPage(program.url, { size: kPhone, isTest: false }) : null;
  await page.waitForFunction(() => window.scanknit.state?.frame > 0.66 * window.scanknit.state.frames_total || window.scanknit.state?.phase === 'finished');
  await keepScreenshot(page, 'live_view_desk');
  if (phone) { await keepScreenshot(phone, 'live_view_phone'); }
  await untilPhase(page, 'finished');
  const seconds = (performance.now() - begun) / 1000;
  const { bytes, chunks, pictures } = await look(page, 'received');
  const state = await look(page, 'state');
  console.log(`first mesh ${((await look(page, 'firstMeshMs')) / 1000).toFixed(2)} s after the page was asked for; `
    + `${(chunks / seconds).toFixed(0)} chunks, ${(pictures / seconds).toFixed(1)} pictures and ${(bytes / seconds / 1e6).toFixed(2)} MB a second `
    + `for ${seconds.toFixed(1)} s; ${(100 * state.view_share).toFixed(1)} % of the time went to the view; `
    + `${state.fused} of ${state.frame} frames fused, ${state.dropped} dropped; ${state.triangles} triangles`);
  await program.stop();
});

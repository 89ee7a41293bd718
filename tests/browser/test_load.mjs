// Whoever looks on, and however badly: the mesh is the same, byte by byte.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { look, openPage, untilPhase, useBrowser } from './browser.mjs';
import { LiveClient } from './live_client.mjs';
import { meshDigests, scanknit, startProgram, synthesise, temporaryFolder } from './program.mjs';

useBrowser();
const folder = temporaryFolder();
const recording = synthesise(join(folder, 'turntable'), 'turntable', { frames: 300 });
const kSettings = ['--preset', 'object', '--set', 'fusion.voxel_size=3mm'];
const alone = join(folder, 'alone');
scanknit('run', recording, '-o', alone, ...kSettings, '--quiet');

/// A scan with the view, its mesh compared with that of a scan without.
async function scanWith(name, lookOn) {
  const out = join(folder, name);
  const program = await startProgram('run', recording, '-o', out, ...kSettings, '--view', '--port', '0');
  await lookOn(program);
  await program.stop();
  const { 'model.glb': glb, 'model.ply': ply } = meshDigests(out);  // a view adds an STL for the page to offer
  assert.deepEqual({ 'model.glb': glb, 'model.ply': ply }, meshDigests(alone));
}

const isOver = ({ state }) => state?.phase === 'finished';
const hasAll = ({ state, triangleCount }) => triangleCount === state.triangles;

test('a client that takes nothing changes nothing in the scan, and gets no more than eight messages', async () => {
  await scanWith('slow', async ({ url }) => {
    const slow = new LiveClient(url, { gives: false });
    await slow.until(isOver);
    assert.equal(slow.binary, 8);
  });
});

test('clients that are torn off in the middle change nothing in the scan', async () => {
  await scanWith('torn', async ({ url }) => {
    for (let i = 0; i < 10; ++i) {
      const torn = new LiveClient(url);
      await torn.until(({ binary, state }) => binary > 0 || isOver({ state }));
      torn.socket.terminate();
    }
    const stays = new LiveClient(url);
    await stays.until((client) => isOver(client) && hasAll(client));
  });
});

test('20 clients at once, a page among them: all have the whole mesh in the end, and none went back', async () => {
  await scanWith('many', async ({ url }) => {
    const clients = Array.from({ length: 19 }, () => new LiveClient(url));
    const page = await openPage(url);
    await Promise.all(clients.map((client) => client.until((one) => isOver(one) && hasAll(one))));
    assert.deepEqual(clients.map(({ wentBack }) => wentBack), Array(19).fill(0));
    await untilPhase(page, 'finished');
    const { triangles, view_share: share } = await look(page, 'state');
    await page.waitForFunction((n) => window.scanknit.triangles === n, triangles);
    assert.ok(share >= 0 && share <= 1, `${share}`);
    assert.deepEqual(page.problems, []);
  });
});

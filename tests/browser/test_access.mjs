// Who may look on: the token, the origin and the host are asked for, and nothing but the page and its files is given.

import assert from 'node:assert/strict';
import { request } from 'node:http';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { look, openPage, untilTriangles, useBrowser } from './browser.mjs';
import { knock } from './live_client.mjs';
import { MockProgram } from './mock_program.mjs';
import { startProgram, temporaryFolder, writeColouredBox } from './program.mjs';

useBrowser();
const folder = temporaryFolder();
const mesh = writeColouredBox(join(folder, 'box.ply'));

/// The status of a GET.
function get(port, path, headers = {}) {
  return new Promise((resolve, reject) => {
    request({ host: '127.0.0.1', port, path, headers }, (response) => {
      response.resume();
      resolve(response.statusCode);
    }).on('error', reject).end();
  });
}

let program, token, here;
before(async () => {
  program = await startProgram('view', mesh, '--listen', '0.0.0.0', '--port', '0');
  token = new URL(program.url).searchParams.get('token');
  here = `127.0.0.1:${program.port}`;
});
const live = (query = '') => `ws://${here}/api/v1/live${query}`;

test('beyond this computer the link carries a token of 128 bits', () => {
  assert.match(token, /^[0-9a-f]{32}$/);
});

test('without the token, or with a wrong one, nothing of the scan is told', async () => {
  const wrong = token.replace(/.$/, (digit) => (digit === '0' ? '1' : '0'));
  for (const query of ['', '?token=', `?token=${wrong}`, `?token=${token}0`, `?tokens=${token}`]) {
    for (const path of ['/', '/api/v1/state', '/files/box.ply']) { assert.equal(await get(program.port, path + query), 401, path + query); }
    assert.equal(await knock(live(query), { origin: `http://${here}` }), 401, query);
  }
  assert.equal(await get(program.port, `/?token=${token}`), 200);
  assert.equal(await get(program.port, `/files/box.ply?token=${token}`), 200);
  assert.equal(await knock(live(`?token=${token}`), { origin: `http://${here}` }), 'open');
});

test('another origin is refused, with the token too', async () => {
  for (const origin of ['http://evil.example', `http://127.0.0.1:${program.port + 1}`, `https://${here}`, 'null', undefined]) {
    assert.equal(await knock(live(`?token=${token}`), { origin }), 403, String(origin));
  }
});

test('another host name is refused: a page elsewhere cannot make its name ours', async () => {
  assert.equal(await get(program.port, `/?token=${token}`, { host: `evil.example:${program.port}` }), 403);
  assert.equal(await get(program.port, `/?token=${token}`, { host: here }), 200);
});

test('no other file is given', async () => {
  for (const path of ['/files/', '/files/../box.ply', '/files/%2e%2e%2fbox.ply', '/files/%2fetc%2fpasswd', '/../../etc/passwd', '/src/main.js', '/index.html']) {
    assert.equal(await get(program.port, `${path}?token=${token}`), 404, path);
  }
});

test('the page opened by its link works, and takes the token out of the address', async () => {
  const page = await openPage(`http://${here}/?token=${token}`);
  await untilTriangles(page, 100);
  assert.equal(page.url().includes(token), false);
  await page.reload();  // the cookie is enough now
  await untilTriangles(page, 100);
  assert.deepEqual(page.problems, []);
});

test('a wrong link is told in words', async () => {
  const page = await openPage(`http://${here}/?token=${token}`);
  await untilTriangles(page, 100);
  const answer = await page.context().browser().newContext().then((context) => context.newPage()).then((other) => other.goto(`http://${here}/?token=wrong`));
  assert.equal(answer.status(), 401);
  assert.match(await answer.text(), /link/);
  await page.context().clearCookies();
  await page.evaluate(() => window.scanknit.reconnect());
  await page.waitForFunction(() => document.getElementById('banner-head').textContent.includes('no longer valid'));
  assert.equal(await look(page, 'link'), 'refused');
});

test('a page from elsewhere, in the same browser, cannot look on', async (context) => {
  const other = await new MockProgram(folder).listen();
  context.after(() => other.close());
  const page = await (await openPage(`http://${here}/?token=${token}`)).context().newPage();  // it has the cookie
  await page.goto(`${other.url}api/v1/state`);
  const outcome = await page.evaluate((url) => new Promise((resolve) => {
    const socket = new WebSocket(url, 'scanknit.v1');
    socket.onopen = () => resolve('open');
    socket.onerror = () => resolve('refused');
  }), live(`?token=${token}`));
  assert.equal(outcome, 'refused');
});

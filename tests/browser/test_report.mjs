// report.html from disk, on a phone and on a desk, light and dark.

import assert from 'node:assert/strict';
import { readFileSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { isWiderThanScreen, kDesk, kPhone, keepScreenshot, openFile, useBrowser } from './browser.mjs';
import { scanknit, synthesise, temporaryFolder } from './program.mjs';

useBrowser();

const kHostile = '<script>document.title="run"';
const folder = temporaryFolder();
const recording = synthesise(join(folder, kHostile), 'turntable', { frames: 24 });
const out = join(folder, 'out');
scanknit('run', recording, '-o', out, '--set', 'fusion.voxel_size=4mm', '--poses', 'refine', '--quiet');

const open = (size, colorScheme) => openFile(pathToFileURL(join(out, 'report.html')).href, { ...size, colorScheme });

for (const [name, size] of [['phone', kPhone], ['desk', kDesk]]) {
  test(`on a ${name} it is readable without scrolling sideways`, async () => {
    const page = await open(size, 'light');
    await page.locator('summary').last().click();
    assert.equal(await isWiderThanScreen(page), false);
    assert.deepEqual(page.problems, []);
    const smallest = await page.evaluate(() => Math.min(...[...document.querySelectorAll('p, td, th, dd, dt, figcaption, li')]
      .map((element) => parseFloat(getComputedStyle(element).fontSize))));
    assert.ok(smallest >= 12, `${smallest} pixels`);
    await keepScreenshot(page, `report_${name}`, { fullPage: true });
  });
}

test('all its pictures are within it and are drawn', async () => {
  const page = await open(kDesk, 'light');
  const pictures = await page.evaluate(() => [...document.images].map((image) => ({ width: image.naturalWidth, here: image.src.startsWith('data:') })));
  assert.equal(pictures.length, 3, 'views, error, coverage');
  assert.ok(pictures.every(({ width, here }) => width > 600 && here), JSON.stringify(pictures));
  assert.ok(statSync(join(out, 'report.html')).size < 2_000_000);
});

test('it says what report.json says, and a hostile name is text', async () => {
  const page = await open(kDesk, 'light');
  const report = JSON.parse(readFileSync(join(out, 'report.json'), 'utf8'));
  const words = await page.locator('body').innerText();
  assert.ok(words.includes(report.mesh.triangles.toLocaleString('en')), 'triangles');
  assert.ok(words.includes(`${report.frames.fused} of ${report.frames.read}`), 'frames');
  assert.ok(words.includes(kHostile), 'the input');
  assert.equal(await page.title(), 'ScanKnit report');
  assert.equal(await page.evaluate(() => document.scripts.length), 0);
});

test('in the dark it is dark, with light words', async () => {
  const page = await open(kDesk, 'dark');
  const brightness = (name) => page.evaluate((property) => {
    const [r, g, b] = getComputedStyle(document.body)[property].match(/\d+/g).map(Number);
    return (r + g + b) / 3;
  }, name);
  assert.ok(await brightness('backgroundColor') < 60);
  assert.ok(await brightness('color') > 180);
  await keepScreenshot(page, 'report_dark');
});

test('`scanknit report` draws the same page again, elsewhere too', () => {
  const first = readFileSync(join(out, 'report.html'));
  scanknit('report', out);
  assert.deepEqual(readFileSync(join(out, 'report.html')), first);
});

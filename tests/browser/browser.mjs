// Headless Chromium, and what a person sees in it.

import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { after, before } from 'node:test';
import { chromium } from 'playwright-core';

export const kDesk = { viewport: { width: 1280, height: 800 } };
export const kPhone = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true };
const kPatienceMs = 60_000;

let browser;

/// In a test file: one browser for all its tests.
export function useBrowser() {
  before(async () => {
    browser = await chromium.launch({ executablePath: process.env.SCANKNIT_CHROMIUM, headless: true, args: ['--no-sandbox'] });
  });
  after(() => browser.close());
}

/// The page at `url`, opened for tests unless it is to look as people see it, and `problems`: what the console and the policy complained about.
export async function openPage(url, { size = kDesk, isTest = true } = {}) {
  const context = await browser.newContext(size);
  const page = await context.newPage();
  page.setDefaultTimeout(kPatienceMs);
  page.problems = [];
  page.on('console', (message) => message.type() === 'error' && page.problems.push(message.text()));
  page.on('pageerror', (error) => page.problems.push(error.message));
  await page.addInitScript(() => {
    document.addEventListener('securitypolicyviolation', (event) => console.error(`policy: ${event.violatedDirective} ${event.blockedURI}`));
    window.heads = [];  // every head line that the banner ever had
    document.addEventListener('DOMContentLoaded', () => {
      const head = document.getElementById('banner-head');
      new MutationObserver(() => window.heads.push(head.textContent)).observe(head, { childList: true, characterData: true, subtree: true });
    });
  });
  const address = new URL(url);
  if (isTest) { address.searchParams.set('test', ''); }
  page.answer = await page.goto(address.href);
  await page.waitForFunction(() => window.scanknit !== undefined);
  return page;
}

/// A page without scripts, as it lies on disk.
export async function openFile(url, options) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  page.setDefaultTimeout(kPatienceMs);
  page.problems = [];
  page.on('console', (message) => message.type() === 'error' && page.problems.push(message.text()));
  page.on('pageerror', (error) => page.problems.push(error.message));
  await page.goto(url);
  return page;
}

export const look = (page, field) => page.evaluate((name) => window.scanknit[name], field);
export const banner = (page) => page.evaluate(() => ({
  tone: document.getElementById('banner').dataset.tone,
  head: document.getElementById('banner-head').textContent,
  advice: document.getElementById('banner-advice').textContent,
}));
export const untilBanner = (page, head) => page.waitForFunction(
  (words) => document.getElementById('banner-head').textContent.startsWith(words), head);
export const untilTriangles = (page, least) => page.waitForFunction((n) => window.scanknit.triangles >= n, least);
export const untilPhase = (page, phase) => page.waitForFunction((name) => window.scanknit.state?.phase === name, phase);
export const command = (page, name) => page.locator(`[data-command="${name}"]`);

/// Red, green, blue where a point of the scan's world is seen.
export const colourAt = (page, p) => page.evaluate((point) => window.scanknit.pixel(...window.scanknit.place(point)).slice(0, 3), p);

/// Buttons, links and sliders that a finger could not hit: smaller than 44 pixels.
export const smallTargets = (page) => page.evaluate(() => [...document.querySelectorAll('button, a, input')]
  .filter((element) => element.checkVisibility())
  .map((element) => ({ name: element.id || element.textContent.trim(), box: element.getBoundingClientRect() }))
  .filter(({ box }) => box.width < 44 || box.height < 44)
  .map(({ name, box }) => `${name}: ${box.width} x ${box.height}`));

export const isWiderThanScreen = (page) => page.evaluate(() => document.documentElement.scrollWidth > window.innerWidth);

/// Kept where SCANKNIT_SCREENSHOTS says, to be looked at.
export async function keepScreenshot(page, name, options = {}) {
  const folder = process.env.SCANKNIT_SCREENSHOTS;
  if (!folder) { return; }
  mkdirSync(folder, { recursive: true });
  await page.screenshot({ ...options, path: join(folder, `${name}.png`) });
}

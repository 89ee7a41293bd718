// node run.mjs TEST_FILE: runs it, or says SKIPPED and ends with 77 when something that it needs is not installed.

import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const chromium = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find((path) => existsSync(path));

function whatIsMissing() {
  for (const name of ['playwright-core', 'ws', 'gltf-validator']) {
    if (!existsSync(join(here, 'node_modules', name))) { return `${name} is not installed (npm ci --prefix tests/browser)`; }
  }
  if (!chromium && !process.env.SCANKNIT_CHROMIUM) { return 'no chromium'; }
  const { stderr } = spawnSync(process.env.SCANKNIT_PROGRAM, ['view', join(here, 'absent.glb')], { encoding: 'utf8' });
  return stderr.includes('without the live view') ? 'the program was built without the page (npm ci --prefix view/page)' : '';
}

const missing = whatIsMissing();
if (missing) {
  console.log(`SKIPPED: ${missing}`);
  process.exit(77);
}
process.env.SCANKNIT_CHROMIUM ??= chromium;
await import(pathToFileURL(resolve(process.argv[2])).href);

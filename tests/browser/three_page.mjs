// A page of three.js, and the files that it loads: what programs other than ours make of our GLB files.

import { createReadStream, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import { dirname, join, normalize } from 'node:path';
import { after } from 'node:test';
import { fileURLToPath } from 'node:url';
import { openFile } from './browser.mjs';

const kThree = join(dirname(fileURLToPath(import.meta.url)), '../../view/page/node_modules/three');

const pageOf = (script) => `<!doctype html><link rel="icon" href="data:,"><style>body { margin: 0 }</style>
<script type="importmap">{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

/// The scene of a GLB file, and the last mesh in it.
async function loadGlb(url) {
  const { scene } = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).loadAsync(url);
  let mesh;
  scene.traverse((node) => { mesh = node.isMesh ? node : mesh; });
  return { scene, mesh };
}
${script}
document.title = 'ready';
</script>`;

/// Ends the test file when three.js is not installed.
export function useThree() {
  if (existsSync(kThree)) { return; }
  console.log('SKIPPED: three.js is not installed (npm ci --prefix view/page)');
  process.exit(77);
}

/// Serves a page that runs `script`, which has THREE and loadGlb(), and beside it the files of `folder`, until the tests
/// end. Answers with a function that opens it, given the browser's options, once the script has run.
export async function serveThreePage(folder, script) {
  const server = createServer((request, response) => {
    const path = normalize(new URL(request.url, 'http://localhost').pathname);
    if (path === '/') {
      response.writeHead(200, { 'content-type': 'text/html' });
      response.end(pageOf(script));
      return;
    }
    const file = path.startsWith('/three/') ? join(kThree, path.slice(7)) : join(folder, path);
    if (!existsSync(file)) {
      response.writeHead(404).end();
      return;
    }
    response.writeHead(200, { 'content-type': file.endsWith('.js') ? 'text/javascript' : 'application/octet-stream' });
    createReadStream(file).pipe(response);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  after(() => server.close());
  return async (options) => {
    const page = await openFile(`http://127.0.0.1:${server.address().port}/`, options);
    await page.waitForFunction(() => document.title === 'ready');
    return page;
  };
}

// Smaller GLB files in three.js: the same mesh and exactly the same colours as the plain file.

import assert from 'node:assert/strict';
import { statSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { kDesk, useBrowser } from './browser.mjs';
import { scanknit, synthesise, temporaryFolder } from './program.mjs';
import { serveThreePage, useThree } from './three_page.mjs';

const kScript = `
/// Counts, box, colours as sRGB bytes, and the pixels of a picture without light.
window.load = async (url) => {
  const { scene, mesh } = await loadGlb(url);
  const { attributes, index } = mesh.geometry;
  const colours = new Map();
  const srgb = (linear) => Math.round(255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055));
  for (let i = 0; i < attributes.color.count; ++i) {
    const colour = [attributes.color.getX(i), attributes.color.getY(i), attributes.color.getZ(i)].map(srgb).join(' ');
    colours.set(colour, (colours.get(colour) ?? 0) + 1);
  }
  scene.updateMatrixWorld(true);
  const box = new THREE.Box3().setFromObject(scene, true);
  mesh.material = new THREE.MeshBasicMaterial({ vertexColors: true });
  const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
  renderer.setSize(256, 256);
  const middle = box.getCenter(new THREE.Vector3()), reach = box.getSize(new THREE.Vector3()).length() / 2;
  const camera = new THREE.OrthographicCamera(-reach, reach, reach, -reach, 0, 4 * reach);
  camera.position.copy(middle).add(new THREE.Vector3(0, 0, 2 * reach));
  camera.lookAt(middle);
  renderer.render(scene, camera);
  const gl = renderer.getContext(), pixels = new Uint8Array(4 * 256 * 256);
  gl.readPixels(0, 0, 256, 256, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return { vertices: attributes.position.count, corners: index.count, colours: [...colours].sort(),
           box: [...box.min.toArray(), ...box.max.toArray()], pixels: [...pixels] };
};`;

useThree();
useBrowser();

const folder = temporaryFolder();
const recording = synthesise(join(folder, 'recording'), 'turntable', { frames: 16 });
const kVariants = { plain: [], quantized: ['--quantize'], compressed: ['--compress'], both: ['--quantize', '--compress'] };
for (const [name, options] of Object.entries(kVariants)) {
  scanknit('run', recording, '-o', join(folder, `${name}.glb`), '--set', 'fusion.voxel_size=4mm', '--set', 'export.material=unlit', '--quiet', ...options);
}

const openPage = await serveThreePage(folder, kScript);

let plain;
async function load(name) {
  const page = await openPage(kDesk);
  const loaded = await page.evaluate((url) => window.load(url), `/${name}.glb`);
  assert.deepEqual(page.problems, []);
  return loaded;
}

/// Pixels that differ by more than one step of a byte.
const different = (a, b) => {
  let count = 0;
  for (let i = 0; i < a.length; i += 4) { count += [0, 1, 2].some((k) => Math.abs(a[i + k] - b[i + k]) > 1) ? 1 : 0; }
  return count;
};

test('the plain file is drawn in colours', async () => {
  plain = await load('plain');
  assert.ok(plain.vertices > 1000 && plain.colours.length > 50);
  assert.ok(plain.pixels.filter((value, i) => i % 4 === 1 && value > 0).length > 2000, 'something is seen');
});

for (const name of ['quantized', 'compressed', 'both']) {
  test(`${name}: the same mesh in exactly the same colours`, async () => {
    const loaded = await load(name);
    assert.equal(loaded.vertices, plain.vertices);
    assert.equal(loaded.corners, plain.corners);
    assert.deepEqual(loaded.colours, plain.colours);
    const step = name === 'compressed' ? 0 : 0.3 / 65535;  // the object is 25 cm high
    loaded.box.forEach((value, i) => assert.ok(Math.abs(value - plain.box[i]) <= step + 1e-7, `${loaded.box} ${plain.box}`));
    // Where triangles meet, the last bit decides; elsewhere all is as it was.
    assert.ok(different(loaded.pixels, plain.pixels) < 256 * 256 / 200, `${different(loaded.pixels, plain.pixels)} pixels differ`);
    assert.ok(statSync(join(folder, `${name}.glb`)).size < 0.8 * statSync(join(folder, 'plain.glb')).size);
  });
}

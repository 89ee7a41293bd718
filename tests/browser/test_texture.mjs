// A textured GLB in three.js, seen from where the recording's camera stood: it looks as the camera's pictures do, much
// more than a mesh with colours at its vertices.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { keepScreenshot, useBrowser } from './browser.mjs';
import { scanknit, synthesise, temporaryFolder } from './program.mjs';
import { serveThreePage, useThree } from './three_page.mjs';

const kWidth = 640, kHeight = 480;
const kScript = `
const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
renderer.setSize(${kWidth}, ${kHeight});
renderer.setClearColor(0x000000);
document.body.append(renderer.domElement);

async function pictureOf(url) {
  const image = new Image();
  image.src = url;
  await image.decode();
  const canvas = document.createElement('canvas');
  canvas.width = image.width;
  canvas.height = image.height;
  const context = canvas.getContext('2d');
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, image.width, image.height).data;
}

/// Draws the file from the camera's place; how its pixels differ from the camera's picture where both show something.
window.compare = async ({ model, picture, pose, fy }) => {
  const { scene, mesh } = await loadGlb(model);
  const isUnlit = mesh.material.isMeshBasicMaterial === true;
  const camera = new THREE.PerspectiveCamera(2 * Math.atan(${kHeight} / 2 / fy) * 180 / Math.PI, ${kWidth / kHeight}, 0.01, 10);
  // Both the recording's world and its camera look along +z with y down; glTF and three.js have y up.
  const flip = new THREE.Matrix4().makeScale(1, -1, -1);
  camera.matrixAutoUpdate = false;
  camera.matrix.multiplyMatrices(flip, new THREE.Matrix4().set(...pose).multiply(flip));
  camera.updateMatrixWorld(true);
  renderer.render(scene, camera);
  const gl = renderer.getContext(), pixels = new Uint8Array(4 * ${kWidth * kHeight});
  gl.readPixels(0, 0, ${kWidth}, ${kHeight}, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const truth = await pictureOf(picture);
  let sum = 0, count = 0;
  for (let y = 0; y < ${kHeight}; ++y) {
    for (let x = 0; x < ${kWidth}; ++x) {
      const a = 4 * ((${kHeight} - 1 - y) * ${kWidth} + x), b = 4 * (y * ${kWidth} + x);
      const isSeen = (bytes, i) => bytes[i] + bytes[i + 1] + bytes[i + 2] > 0;
      if (!isSeen(pixels, a) || !isSeen(truth, b)) { continue; }
      for (let k = 0; k < 3; ++k) { sum += (pixels[a + k] - truth[b + k]) ** 2; }
      ++count;
    }
  }
  return { isUnlit, count, rms: Math.sqrt(sum / (3 * count)), hasVertexColours: mesh.geometry.attributes.color !== undefined };
};`;

useThree();
useBrowser();

const folder = temporaryFolder();
const recording = synthesise(join(folder, 'recording'), 'turntable', { frames: 24, width: kWidth, height: kHeight });
const kVariants = {
  plain: [], textured: ['--texture'], packed: ['--texture', '--quantize', '--compress'], jpeg: ['--set', 'export.texture=jpeg'],
};
for (const [name, options] of Object.entries(kVariants)) {
  scanknit('run', recording, '-o', join(folder, `${name}.glb`), '--set', 'fusion.voxel_size=4mm', '--set', 'export.material=unlit', '--quiet', ...options);
}

const openPage = await serveThreePage(folder, kScript);

/// trajectory.log: for each frame a line of numbers, and four of the matrix.
const poses = readFileSync(join(recording, 'trajectory.log'), 'utf8').trim().split('\n');
const kFrame = 5;
const pose = poses.slice(5 * kFrame + 1, 5 * kFrame + 5).flatMap((row) => row.trim().split(/\s+/).map(Number));
const fy = JSON.parse(readFileSync(join(recording, 'camera_intrinsic.json'), 'utf8')).intrinsic_matrix[4];

async function compare(name) {
  const page = await openPage({ viewport: { width: kWidth, height: kHeight } });
  const result = await page.evaluate((wish) => window.compare(wish),
    { model: `/${name}.glb`, picture: `/recording/color/${String(kFrame).padStart(6, '0')}.png`, pose, fy });
  await keepScreenshot(page, `texture_${name}`);
  assert.deepEqual(page.problems, []);
  console.log(`${name}: ${result.rms.toFixed(2)} of 255 over ${result.count} pixels`);
  return result;
}

let plain, textured;
test('a plain file has colours at its vertices', async () => {
  plain = await compare('plain');
  assert.ok(plain.hasVertexColours && plain.count > 10_000, JSON.stringify(plain));
});

test('a textured file looks as the camera saw it', async () => {
  textured = await compare('textured');
  assert.ok(textured.isUnlit && !textured.hasVertexColours);
  assert.ok(Math.abs(textured.count - plain.count) < 0.01 * plain.count, 'the same silhouette');
  assert.ok(textured.rms < 0.8 * plain.rms, `${textured.rms} against ${plain.rms}`);
});

for (const name of ['packed', 'jpeg']) {
  test(`${name}: nearly so`, async () => {
    const other = await compare(name);
    assert.ok(other.rms < textured.rms + 1.5, `${other.rms} against ${textured.rms}`);
  });
}

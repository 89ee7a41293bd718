// The arithmetic of measuring on the page (docs/measuring.md), without a browser: against known shapes, and against `scanknit measure`.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { measure } from '../../view/page/src/measure/measures.js';
import { asCsv, asText, inWords } from '../../view/page/src/measure/measure_text.js';
import { cutPatches, sectionSvg } from '../../view/page/src/measure/section.js';
import { angleOf, circleThrough, diameterOf, distanceOf, planeThrough } from '../../view/page/src/measure/shapes.js';
import { entryOf, firstHit, patchOf as patchOfChunk, sigmaAt } from '../../view/page/src/measure/surface.js';
import { pointSigma, propagated, surfaceSigma } from '../../view/page/src/measure/uncertainty.js';
import { eigen, solve } from '../../view/page/src/measure/vectors.js';
import { boxOf, chunkOf, patchOf, plyOf, sphereOf, tubeOf } from './known_shapes.mjs';
import { chunkBody } from './mock_program.mjs';
import { temporaryFolder } from './program.mjs';

const kPercent = 0.01;  // how near the page's measures are to be

function assertNear(value, expected, tolerance, what) {
  assert.ok(Math.abs(value - expected) <= tolerance, `${what}: ${value}, expected ${expected} within ${tolerance}`);
}
const assertWithin1Percent = (value, expected, what) => assertNear(value, expected, kPercent * Math.abs(expected), what);

/// As the page's MeshSurface, of shapes without boxes.
const surfaceOf = (patches, voxelSizeM = 0) => ({ atPlane: () => patches, nearBall: () => patches, sizeM: 10, voxelSizeM });

/// A pick where a ray from `from` towards `to` meets the shape.
function pickOf(shape, from, to, { surfaceM = 0, pixelM = 0, source = 'stated' } = {}) {
  const arm = to.map((x, axis) => x - from[axis]);
  const hit = firstHit(patchOf(shape), { origin: from, direction: arm.map((x) => x / Math.hypot(...arm)) }, false);
  assert.ok(hit, `the ray from ${from} meets the shape`);
  return { p: hit.p, normal: hit.normal, surfaceM, pixelM, stepM: 0, from: source };
}

test('distances and angles of a box are those of its sides', () => {
  assertNear(distanceOf([[0, 0, 0], [0.1, 0.06, 0.04]]), Math.hypot(0.1, 0.06, 0.04), 1e-12, 'diagonal');
  assertNear(angleOf([[1, 0, 0], [0, 0, 0], [0, 2, 0]]), Math.PI / 2, 1e-12, 'right angle');
  assertNear(angleOf([[1, 0, 0], [0, 0, 0], [-3, 0, 0]]), Math.PI, 1e-12, 'straight');
  assertNear(angleOf([[1, 0, 0], [0, 0, 0], [2, 1e-9, 0]]), 5e-10, 1e-15, 'nearly none');
});

test('three points have one circle, and none on a line', () => {
  const centre = [0.3, -0.2, 0.1], radius = 0.04;
  const at = (turn) => [centre[0] + radius * Math.cos(turn), centre[1], centre[2] + radius * Math.sin(turn)];
  const circle = circleThrough([at(0.2), at(1.9), at(4)]);
  assertNear(circle.radius, radius, 1e-12, 'radius');
  circle.centre.forEach((x, axis) => assertNear(x, centre[axis], 1e-12, 'centre'));
  assertNear(Math.abs(circle.normal[1]), 1, 1e-12, 'normal');
  assert.equal(circleThrough([[0, 0, 0], [1, 1, 1], [3, 3, 3]]), null);
  assert.equal(planeThrough([[0, 0, 0], [0, 0, 0], [1, 0, 0]]), null);
});

test('a matrix of 3 x 3 is solved, and its own vectors are found', () => {
  const A = [[2, -1, 0.5], [-1, 3, 0.2], [0.5, 0.2, 1]];
  const x = solve(A, [1, -2, 0.7]);
  A.forEach((row, i) => assertNear(row.reduce((sum, a, k) => sum + a * x[k], 0), [1, -2, 0.7][i], 1e-12, 'A x'));
  assert.equal(solve([[1, 2, 3], [2, 4, 6], [0, 0, 1]], [1, 1, 1]), null);
  const { values, vectors } = eigen(A);
  const product = (row, v) => row.reduce((sum, a, n) => sum + a * v[n], 0);
  vectors.forEach((v, i) => A.forEach((row, k) => assertNear(product(row, v), values[i] * v[k], 1e-12, 'A v')));
  assert.ok(values[0] <= values[1] && values[1] <= values[2]);
});

test('uncertainties add as the formulas of the derivatives say', () => {
  assertNear(propagated(distanceOf, [[0, 0, 0], [1, 0, 0]], [3e-4, 4e-4]), 5e-4, 1e-9, 'distance');
  const angle = [[1, 0, 0], [0, 0, 0], [0, 0.5, 0]];
  const byHand = Math.hypot(1e-3 / 1, 2e-3 / 0.5, (3e-3 * Math.hypot(1, 0.5)) / (1 * 0.5));
  assertNear(propagated(angleOf, angle, [1e-3, 3e-3, 2e-3]), byHand, 1e-5, 'angle');
  const third = (i) => [Math.cos((2 * Math.PI * i) / 3), Math.sin((2 * Math.PI * i) / 3), 0];
  // Points at thirds of a circle move its radius by a third of what each moves outwards.
  assertNear(propagated(diameterOf, [third(0), third(1), third(2)], [1e-3, 1e-3, 1e-3]), (2 / Math.sqrt(3)) * 1e-3, 1e-6, 'diameter');
  assert.equal(propagated(diameterOf, [[0, 0, 0], [1e-3, 0, 0], [2e-3, 0, 0]], [0, 0, 0]), Infinity, 'no circle');
});

test('a point is as uncertain as its vertices say, else as its voxels and views', () => {
  assert.deepEqual(surfaceSigma({ statedM: 2e-4, voxelSizeM: 1e-3 }), { sigmaM: 2e-4, from: 'stated' });
  assert.deepEqual(surfaceSigma({}), { sigmaM: 0, from: 'unknown' });
  const [once, well] = [0, 1].map((coverage) => surfaceSigma({ voxelSizeM: 2e-3, coverage }));
  assert.equal(well.from, 'voxels');
  assertNear(once.sigmaM, 2e-3 * Math.hypot(0.85, 0.05), 1e-12, 'seen once');
  assertNear(well.sigmaM, 2e-3 * Math.hypot(0.85 / Math.sqrt(10), 0.05), 1e-12, 'well seen');
  assertNear(pointSigma({ surfaceM: 3e-4, stepM: 0, pixelM: 4e-4 * Math.sqrt(12) }), 5e-4, 1e-12, 'with a pixel');
});

test('95 % of distances on a noisy box lie within the uncertainty that is stated', () => {
  let seed = 1;
  const uniform = () => (seed = (seed * 16807) % 2147483647) / 2147483647;  // Park and Miller 1988
  const normal = () => Math.sqrt(-2 * Math.log(uniform())) * Math.cos(2 * Math.PI * uniform());
  const sigma = 3e-4, truth = [[0, 0, 0], [0.08, 0.03, 0], [0.02, 0.07, 0.05]];
  const count = 4000;
  for (const [name, f] of Object.entries({ distanceOf, angleOf, diameterOf })) {
    let within = 0;
    for (let i = 0; i < count; ++i) {
      const points = truth.map((p) => p.map((x) => x + sigma * normal()));
      within += Math.abs(f(points) - f(truth)) <= 2 * propagated(f, points, [sigma, sigma, sigma]);
    }
    assertNear(within / count, 0.9545, 0.015, name);
  }
});

test('sections of a box and a sphere have the lengths and areas of their outlines', () => {
  const box = patchOf(boxOf([0.1, 0.06, 0.04]));
  const cut = cutPatches([box], { normal: [1, 0, 0], offset: 0.011 });
  assert.deepEqual([cut.closed, cut.open], [1, 0]);
  assertNear(cut.lengthM, 0.2, 1e-12, 'outline');
  assertNear(cut.areaM2, 0.06 * 0.04, 1e-12, 'area');
  const sphere = patchOf(sphereOf(0.05));
  for (const [normal, offset] of [[[0, 0, 1], 0], [[0, 0, 1], 0.02], [[0.6, 0, 0.8], -0.03]]) {
    const round = cutPatches([sphere], { normal, offset });
    const radius = Math.sqrt(0.05 ** 2 - offset ** 2);
    assert.equal(round.closed, 1);
    assertWithin1Percent(round.lengthM, 2 * Math.PI * radius, 'outline');
    assertWithin1Percent(round.areaM2, Math.PI * radius ** 2, 'area');
  }
});

test('a plane through vertices and edges still makes closed outlines, and holes take their area away', () => {
  const box = patchOf(boxOf([0.08, 0.08, 0.08], 8));
  const cut = cutPatches([box], { normal: [0, 0, 1], offset: 0.01 });  // along a row of vertices
  assert.deepEqual([cut.closed, cut.open], [1, 0]);
  assertNear(cut.areaM2, 0.0064, 1e-12, 'area');
  const tube = cutPatches([patchOf(tubeOf(0.02, 0.03, 0.05))], { normal: [0, 0, 1], offset: 0.001 });
  assert.equal(tube.closed, 2);
  assertWithin1Percent(tube.areaM2, Math.PI * (0.03 ** 2 - 0.02 ** 2), 'area of the ring');
  assert.ok(tube.outlines[0].areaM2 > 0 && tube.outlines[1].areaM2 < 0);
});

test('an outline goes on from one patch to the next, and an open surface has an open one without an area', () => {
  const shape = sphereOf(0.05, 32);
  const half = Math.floor(shape.triangles.length / 2);
  const parts = [shape.triangles.slice(0, half), shape.triangles.slice(half)].map((triangles) => patchOf({ ...shape, triangles }));
  const plane = { normal: [1, 0, 0], offset: 0.003 };
  assert.deepEqual(pickNumbers(cutPatches(parts, plane)), pickNumbers(cutPatches([patchOf(shape)], plane)));
  const open = cutPatches(parts.slice(0, 1), plane);
  assert.deepEqual([open.closed, open.open, open.areaM2], [0, 1, null]);
});
const pickNumbers = ({ closed, open, lengthM, areaM2 }) => [closed, open, lengthM.toFixed(12), areaM2.toFixed(12)];

test('a section is uncertain by its surface and by the plane', () => {
  const shape = sphereOf(0.05);
  const sigma = 2e-4, z = 0.03, radius = 0.04;
  const pick = { p: [0.04, 0, z], normal: [0.8, 0, 0.6], surfaceM: sigma, from: 'stated', stepM: 0, pixelM: 0 };
  const { values } = measure('section', [pick], surfaceOf([patchOf(shape, sigma)]), 'z');
  // The circle's length changes with the height by 2 pi z / radius, its area by 2 pi z.
  assertNear(values[0].sigma, sigma * 2 * Math.PI * Math.hypot(1, z / radius), 0.02 * sigma * 2 * Math.PI, 'outline');
  assertNear(values[1].sigma, sigma * 2 * Math.PI * Math.hypot(radius, z), 0.02 * sigma * 2 * Math.PI * radius, 'area');
});

test('a diameter is that of the wall, also where the points lie at several heights', () => {
  const tube = tubeOf(0.02, 0.03, 0.08);
  const surface = surfaceOf([patchOf(tube)]);
  const around = [0.3, 2.2, 4.4];
  const inside = around.map((turn, i) => pickOf(tube, [0, 0, 0.01 * i], [Math.cos(turn), Math.sin(turn), 0.01 * i]));
  const hole = measure('diameter', inside, surface);
  assertWithin1Percent(hole.values[0].value, 0.04, 'hole');
  assert.equal(hole.words[0], 'hole');
  const far = around.map((turn, i) => pickOf(tube, [Math.cos(turn), Math.sin(turn), 0.012 * i - 0.02], [0, 0, 0.012 * i - 0.02]));
  const rod = measure('diameter', far, surface);
  assertWithin1Percent(rod.values[0].value, 0.06, 'rod');
  assert.equal(rod.words[0], 'rod');
  assert.ok(rod.wall.arc > 6.2, `all round: ${rod.wall.arc}`);
});

test('points on a sphere and on a rim have a diameter, and points of a plate that of their circle', () => {
  const ball = sphereOf(0.05);
  const picks = [0.3, 2.2, 4.4].map((turn) => pickOf(ball, [Math.cos(turn), Math.sin(turn), 0.0005], [0, 0, 0.0005]));
  assertWithin1Percent(measure('diameter', picks, surfaceOf([patchOf(ball)])).values[0].value, 0.1, 'sphere');
  const slanted = [0.3, 2.2, 4.4].map((turn) => pickOf(ball, [Math.cos(turn), Math.sin(turn), 0.015], [0, 0, 0.015]));
  const latitude = measure('diameter', slanted, surfaceOf([patchOf(ball)]));
  assertWithin1Percent(latitude.values[0].value, 2 * Math.sqrt(0.05 ** 2 - 0.015 ** 2), 'circle of latitude');
  assert.deepEqual(latitude.words, ['through the points'], 'its wall has no one diameter');
  const tube = tubeOf(0.02, 0.03, 0.08);
  const rim = [0.3, 2.2, 4.4].map((turn) => pickOf(tube, [0.0299 * Math.cos(turn), 0.0299 * Math.sin(turn), 1],
    [0.0299 * Math.cos(turn), 0.0299 * Math.sin(turn), 0]));
  assertWithin1Percent(measure('diameter', rim, surfaceOf([patchOf(tube)])).values[0].value, 0.06, 'rim');
  const plate = boxOf([0.1, 0.1, 0.01]);
  const drawn = [0.3, 2.2, 4.4].map((turn) => pickOf(plate, [0.03 * Math.cos(turn), 0.03 * Math.sin(turn), 1],
    [0.03 * Math.cos(turn), 0.03 * Math.sin(turn), 0]));
  const circle = measure('diameter', drawn, surfaceOf([patchOf(plate)]));
  assertWithin1Percent(circle.values[0].value, 0.06, 'drawn on a plate');
  assert.deepEqual(circle.words, ['through the points']);
});

test('a wall that goes round less leaves its diameter less certain', () => {
  const sigma = 1e-4;
  const tube = tubeOf(0.02, 0.03, 0.08);
  const part = { ...tube, triangles: tube.triangles.filter((corners) => corners.every((v) => tube.points[v][0] > 0.012)) };
  const picksAt = (turns) => turns.map((turn) => pickOf(part, [Math.cos(turn), Math.sin(turn), 0], [0, 0, 0], { surfaceM: sigma }));
  const sigmaOf = (shape, picks) => measure('diameter', picks, surfaceOf([patchOf(shape, sigma)])).values[0].sigma;
  const near = picksAt([-0.9, 0, 0.9]);
  const [whole, third] = [sigmaOf(tube, near), sigmaOf(part, near)];
  assertNear(whole, 2 * sigma, 0.1 * sigma, 'all round: twice the surface\'s');
  assert.ok(third > 2 * whole, `a third of the way round: ${third}`);
});

test('what cannot be measured is said', () => {
  const at = (x) => ({ p: [x, 0, 0], normal: [0, 0, 1], surfaceM: 0, from: 'unknown', stepM: 0, pixelM: 0 });
  const surface = surfaceOf([patchOf(sphereOf(0.05, 16))]);
  assert.match(measure('section', [at(0), at(1), at(2)], surface).problem, /on a line/);
  assert.match(measure('diameter', [at(0), at(1), at(2)], surface).problem, /on a line/);
  assert.match(measure('angle', [at(0), at(0), at(2)], surface).problem, /another place/);
  assert.match(measure('section', [at(1)], surface, 'x').problem, /does not meet/);
});

test('a chunk of the protocol is a patch, with the uncertainty of its vertices', () => {
  const shape = boxOf([0.1, 0.06, 0.04], 2);
  const body = chunkBody(...chunkOf(shape, 128));
  const view = new DataView(body.buffer);
  const [count, scale] = [view.getUint32(0, true), view.getFloat32(28, true)];
  const bytes = body.subarray(32, 32 + 16 * count);
  const origin = [16, 20, 24].map((at) => view.getFloat32(at, true));
  const chunk = { bytes, indices: new Uint16Array(shape.triangles.flat()), origin, scale };
  const patch = patchOfChunk({ ...chunk, voxelSizeM: 2e-3 });
  shape.points.flat().forEach((x, i) => assertNear(patch.positions[i], x, scale, 'position'));
  const ray = { origin: [0.01, 0.005, 1], direction: [0, 0, -1] };
  const hit = firstHit(patch, ray, false);
  assertNear(hit.p[2], 0.02, scale, 'upper side');
  assert.equal(sigmaAt(patch, hit, 2e-3).from, 'voxels');
  for (let v = 0; v < count; ++v) { new DataView(bytes.buffer, bytes.byteOffset).setUint16(16 * v + 6, 250, true); }
  const stated = sigmaAt(patchOfChunk({ ...chunk, voxelSizeM: 2e-3 }), hit, 2e-3);
  assert.equal(stated.from, 'stated');
  assertNear(stated.sigmaM, 250e-6, 1e-12, 'micrometres');
  assert.equal(firstHit(patch, { origin: [0.01, 0.005, 0], direction: [0, 0, 1] }, false), null, 'the back of a side');
  assertNear(firstHit(patch, { origin: [0.01, 0.005, 0], direction: [0, 0, 1] }, true).p[2], 0.02, scale, 'or of both');
  assert.equal(entryOf(ray, { min: [-1, -1, -1], max: [1, 1, 0.5] }), 0.5);
  assert.equal(entryOf(ray, { min: [0.5, -1, -1], max: [1, 1, 0.5] }), Infinity);
});

test('values have as many digits as their uncertainty leaves', () => {
  const length = (value, sigma) => ({ value, sigma, dimension: 'length' });
  assert.equal(inWords(length(0.1234567, 1.2e-4), 'mm'), '123.46 ± 0.24 mm');
  assert.equal(inWords(length(0.1234567, 1.2e-4), 'in'), '4.8605 ± 0.0094 in');
  assert.equal(inWords(length(2.5, 0.02), 'mm'), '2500 ± 40 mm');
  assert.equal(inWords({ value: Math.PI / 2, sigma: 0.01, dimension: 'angle' }, 'mm'), '90.0 ± 1.1°');
  assert.equal(inWords({ value: 0.0024, sigma: 1e-6, dimension: 'area' }, 'cm'), '24.000 ± 0.020 cm²');
  assert.equal(inWords(length(0.1234567, 0), 'mm'), '123.46 mm ± ?');
  assert.equal(inWords(length(0.1234567, Infinity), 'mm'), '123.46 mm ± ?');
});

test('measures are copied as text and as CSV', () => {
  const picks = [[0, 0, 0], [0.1, 0, 0]].map((p) => ({ p, normal: [0, 0, 1], surfaceM: 1e-4, from: 'voxels', stepM: 0, pixelM: 0 }));
  const one = measure('distance', picks, surfaceOf([]));
  const options = { unit: 'mm', mesh: 'a "cup", small.glb (preview)' };
  assert.equal(asText([one], options), 'a "cup", small.glb (preview)\n1 Distance 100.00 ± 0.28 mm\n');
  assert.deepEqual(asCsv([one], options).split('\r\n'), [
    'number,measure,value,uncertainty,unit,uncertainty_from,points,mesh',
    '1,Distance,100.00,0.28,mm,voxels,0 0 0; 100 0 0,"a ""cup"", small.glb (preview)"', '',
  ]);
});

test('the drawing of a section is in millimetres, true to size', () => {
  const cut = cutPatches([patchOf(boxOf([0.1, 0.06, 0.04], 1))], { normal: [1, 0, 0], offset: 0.01 });
  const svg = sectionSvg(cut, 'a < b');
  const numbers = /d="M([^"Z]+)Z"/.exec(svg)[1].split(/[ L]/).map(Number);
  const spread = (axis) => Math.max(...numbers.filter((_, i) => i % 2 === axis)) - Math.min(...numbers.filter((_, i) => i % 2 === axis));
  assertNear(spread(0), 60, 1e-4, 'y to the right');
  assertNear(spread(1), 40, 1e-4, 'z up');
  assert.ok(svg.includes('a &lt; b'));
});

test('the page and `scanknit measure` agree', () => {
  const folder = temporaryFolder();
  const measured = (name, shape, ...options) => {
    const path = join(folder, name);
    writeFileSync(path, plyOf(shape));
    const command = ['measure', path, '--json', ...options];
    const { status, stdout, stderr } = spawnSync(process.env.SCANKNIT_PROGRAM, command, { encoding: 'utf8' });
    assert.equal(status, 0, stderr);
    return JSON.parse(stdout);
  };
  const shapes = { 'box.ply': boxOf([0.1, 0.06, 0.04]), 'sphere.ply': sphereOf(0.05), 'tube.ply': tubeOf(0.02, 0.03, 0.08) };
  for (const [name, shape] of Object.entries(shapes)) {
    const [theirs] = measured(name, shape, '--section', '0,0,0.004,0.28,0,0.96').sections;
    const ours = cutPatches([patchOf(shape)], { normal: [0.28, 0, 0.96], offset: 0.004 * 0.96 });
    assertNear(ours.lengthM, theirs.length_m, 1e-5 * theirs.length_m, `${name}: outline`);
    assertNear(ours.areaM2, theirs.area_m2, 1e-5 * theirs.area_m2, `${name}: area`);
  }
  const around = [0.3, 2.2, 4.4].map((turn) => [Math.cos(turn), Math.sin(turn), 0]);
  const thick = tubeOf(0.02, 0.05, 0.08), thin = tubeOf(0.02, 0.03, 0.08);
  const hole = measure('diameter', around.map((p) => pickOf(thick, [0, 0, 0], p)), surfaceOf([patchOf(thick)]));
  const rod = measure('diameter', around.map((p) => pickOf(thin, p, [0, 0, 0])), surfaceOf([patchOf(thin)]));
  for (const [name, shape, at, radius, ours] of [['hole', thick, '0.02,0,0', '0.02', hole], ['rod', thin, '0.03,0,0', '0.03', rod]]) {
    const { circle } = measured(`${name}.ply`, shape, '--circle-at', at, '--radius', radius);
    assert.equal(circle.is_hole, ours.wall.isHole, name);
    assertNear(ours.values[0].value, circle.diameter_m, 1e-3 * circle.diameter_m, name);
  }
});

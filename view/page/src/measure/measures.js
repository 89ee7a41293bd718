// The four measures: what they need, what they say, and how uncertain that is.

import { cutPatches } from './section.js';
import { fitRoundWall } from './round_wall.js';
import { angleOf, circleThrough, diameterOf, distanceOf, planeThrough, pointsOnCircle } from './shapes.js';
import { fittedSigma, outlineSigma, pointSigma, propagated } from './uncertainty.js';
import { dot, times } from './vectors.js';

/// How many points each takes; a section along an axis takes one.
export const kPoints = { distance: 2, angle: 3, section: 3, diameter: 3 };
export const pointsFor = (kind, plane) => (kind === 'section' && plane !== 'points' ? 1 : kPoints[kind]);

const kAxes = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

/// `picks`: {p, normal, surfaceM, from, stepM, pixelM}. `surface`: {atPlane(plane), nearBall(centre, radius)} gives the patches there,
/// `sizeM` and `voxelSizeM`. Gives {kind, picks, values: [{name, value, sigma, dimension}], lines: [[point, ...], ...], from, words}, with
/// `section` for one; or {problem}: why there is nothing to measure. Values in metres, square metres or radians.
export function measure(kind, picks, surface, plane = 'points') {
  const points = picks.map(({ p }) => p);
  const sigmas = picks.map(pointSigma);
  const from = ['unknown', 'voxels', 'stated'].find((source) => picks.some((pick) => pick.from === source));
  const done = { distance, angle, section, diameter }[kind]({ picks, points, sigmas, surface, plane });
  return done.problem ? done : { kind, picks, from, words: [], ...done };
}

function distance({ points, sigmas }) {
  const value = distanceOf(points);
  return { values: [{ name: 'Distance', value, sigma: propagated(distanceOf, points, sigmas), dimension: 'length' }], lines: [points] };
}

function angle({ points, sigmas }) {
  const isCorner = distanceOf(points) > 0 && distanceOf(points.slice(1)) > 0;
  if (!isCorner) { return { problem: 'The corner must be another place than the other two.' }; }
  const sigma = propagated(angleOf, points, sigmas);
  return { values: [{ name: 'Angle', value: angleOf(points), sigma, dimension: 'angle' }], lines: [points] };
}

function section({ points, sigmas, surface, plane }) {
  const axis = kAxes[plane];
  const planeOf = (places) => (axis ? { normal: axis, offset: dot(axis, places[0]) } : upward(planeThrough(places)));
  const first = planeOf(points);
  if (!first) { return { problem: 'These points are on a line: no plane goes through them alone.' }; }
  const known = new Map();
  const cut = (places) => {
    const key = String(places);
    if (!known.has(key)) {
      const moved = planeOf(places);
      known.set(key, moved && cutPatches(surface.atPlane(moved), moved));
    }
    return known.get(key);
  };
  const found = cut(points);
  if (found.outlines.length === 0) { return { problem: 'The plane does not meet the mesh.' }; }
  const own = outlineSigma(found);
  const byPlane = (name) => propagated((places) => cut(places)?.[name] ?? NaN, points, sigmas, [first.normal]);
  const sigmaOf = (name, ownSigma) => Math.hypot(ownSigma, byPlane(name));
  const values = [{ name: 'Outline', value: found.lengthM, sigma: sigmaOf('lengthM', own.lengthM), dimension: 'length' }];
  if (found.areaM2 !== null) {
    values.push({ name: 'Area', value: found.areaM2, sigma: sigmaOf('areaM2', own.areaM2), dimension: 'area' });
  }
  const words = [found.closed > 0 ? `${found.closed} closed` : '', found.open > 0 ? `${found.open} open` : ''].filter(Boolean);
  const lines = found.outlines.map(({ points: outline, isClosed }) => (isClosed ? [...outline, outline[0]] : outline));
  return { values, lines, words, section: { ...found, plane: first } };
}

/// The same plane from the side of its larger component, so that its drawing does not depend on the order of the points.
function upward(plane) {
  if (!plane) { return null; }
  const most = plane.normal.reduce((best, x) => (Math.abs(x) > Math.abs(best) ? x : best), 0);
  return most < 0 ? { normal: times(-1, plane.normal), offset: -plane.offset } : plane;
}

function diameter({ picks, points, sigmas, surface }) {
  const through = circleThrough(points);
  if (!through) { return { problem: 'These points are on a line: no circle goes through them.' }; }
  const own = { name: 'Through the points', value: 2 * through.radius, sigma: propagated(diameterOf, points, sigmas), dimension: 'length' };
  const wall = fitRoundWall(picks, surface.nearBall, surface.sizeM);
  if (!wall) { return { values: [{ ...own, name: 'Diameter' }], lines: [pointsOnCircle(through)], words: ['through the points'] }; }
  const { sigmaM, rmsM, share } = wall;
  const places = wall.areaM2 / (2 * Math.max(surface.voxelSizeM, wall.sideM)) ** 2;
  const surfaceM = pointSigma({ surfaceM: sigmaM, stepM: picks[0].stepM, pixelM: 0 });
  const fit = {
    name: 'Diameter', value: 2 * wall.radius, dimension: 'length', sigma: 2 * fittedSigma({ share, rmsM, places, sigmaM: surfaceM }),
  };
  const words = [wall.isHole ? 'hole' : 'rod', `wall of ${Math.round((wall.arc * 180) / Math.PI)}°`];
  return { values: [fit, own], lines: [pointsOnCircle(wall)], words, rmsM, wall };
}

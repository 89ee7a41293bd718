// The round wall of a hole or rod that three picked points lie on: its circle by least squares, as `scanknit measure --circle-at` fits it.

import { circleThrough } from './shapes.js';
import { add, cross, dot, eigen, frameAcross, norm, solve, subtract, times, unit } from './vectors.js';

const kAcrossAxis = 0.34;   // sine of 20 degrees: a wall's normals are square to the axis
const kTowardsAxis = 0.94;  // cosine of 20 degrees: and point to it or away
const kMostSlope = 0.1;     // a wall that runs together, of a cone or up a ball, has no one diameter
const kMostOff = [0.08, 0.05, 0.04];  // of the radius, in successive rounds
const kPieceShare = 1 / 8;  // a piece's largest side, of the radius
const kBesidePoints = 0.1;  // how far the wall goes beyond the points along the axis, of the radius
const kMostPieces = 20_000;  // triangles that are cut into pieces
const kMostFitted = 6000;
const kLeastPieces = 12;
const kLeastArc = Math.PI / 3;
const kArcParts = 72;
const kRounds = 20;
const kConverged = 1e-9;  // a step, of the radius

/// {centre, normal, radius, isHole, rmsM, arc, areaM2, sideM, share, sigmaM}, or null where there is no such wall, or it is a slanted one,
/// or goes round by less than 60 degrees. `picks`: three of {p, normal}. `patchesNear(centre, radius)`: the mesh there. `share` is for
/// fittedSigma(). Circles of more than `mostRadius` are not looked for.
export function fitRoundWall(picks, patchesNear, mostRadius = Infinity) {
  const through = circleThrough(picks.map(({ p }) => p));
  if (!through) { return null; }
  const starts = axesOf(picks, through).map((axis) => cylinderThrough(picks, axis)).filter((start) => start?.radius <= mostRadius);
  let best = null;
  for (const start of starts) {
    const reach = 1.1 * start.radius;
    const centre = add(flatCentre(start), times((start.low + start.high) / 2, start.axis));
    const size = Math.hypot(reach, (start.high - start.low) / 2);
    const pieces = piecesOf(patchesNear, start, { centre, radius: size });
    const areaM2 = area(wallOf(start, pieces, kMostOff[0]));
    if (areaM2 > (best?.areaM2 ?? 0)) { best = { start, pieces, areaM2 }; }
  }
  return best && fitted(best.start, best.pieces, picks);
}

/// Where the axis may point: square to the normals at the points (these are on the wall), or to the points' plane (they are on its rim).
function axesOf(picks, { normal }) {
  const { vectors, values } = eigen(scatter(picks.map((pick) => ({ ...pick, area: 1 }))));
  return values[1] > 0.05 ? [vectors[0], normal] : [normal];
}

function scatter(pieces) {
  const sum = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
  for (const { normal, area: weight } of pieces) {
    for (let i = 0; i < 3; ++i) { sum[i] = add(sum[i], times(weight * normal[i], normal)); }
  }
  return sum;
}

/// A cylinder: axis, frame across it, centre in that frame, radius, and how far the wall counts along the axis.
function cylinderThrough(picks, axis) {
  const frame = frameAcross(axis);
  const points = picks.map(({ p }) => [dot(frame.right, p), dot(frame.up, p), 0]);
  const circle = circleThrough(points);
  if (!circle) { return null; }
  return withEnds({ axis, ...frame, centre: circle.centre.slice(0, 2), radius: circle.radius }, picks);
}

function withEnds(cylinder, picks) {
  const along = picks.map(({ p }) => dot(cylinder.axis, p));
  const beside = kBesidePoints * cylinder.radius;
  return { ...cylinder, low: Math.min(...along) - beside, high: Math.max(...along) + beside };
}

const flatCentre = ({ right, up, centre }) => add(times(centre[0], right), times(centre[1], up));

/// The triangles about the cylinder's wall, cut into small pieces; of a fine mesh every n-th, with the area of n. They lie within the ball.
function piecesOf(patchesNear, cylinder, { centre, radius }) {
  const isNear = (positions, i, j, k) => centre.every((x, axis) => {
    const [a, b, c] = [positions[3 * i + axis], positions[3 * j + axis], positions[3 * k + axis]];
    return Math.min(a, b, c) <= x + radius && Math.max(a, b, c) >= x - radius;
  });
  let count = 0;
  for (const { positions, indices } of patchesNear(centre, radius)) {
    for (let t = 0; t < indices.length; t += 3) { count += isNear(positions, indices[t], indices[t + 1], indices[t + 2]); }
  }
  const every = Math.floor(count / kMostPieces) + 1;
  const pieces = [];
  let number = 0;
  for (const { positions, indices, sigmas } of patchesNear(centre, radius)) {
    const at = (v) => [positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]];
    for (let t = 0; t < indices.length; t += 3) {
      const corners = [indices[t], indices[t + 1], indices[t + 2]];
      if (!isNear(positions, ...corners) || number++ % every !== 0) { continue; }
      const [a, b, c] = corners.map(at);
      const normal = unit(cross(subtract(b, a), subtract(c, a)));
      const sigma = sigmas ? (sigmas[corners[0]] + sigmas[corners[1]] + sigmas[corners[2]]) / 3 : 0;
      if (normal) { cutInto(pieces, [[a, b, c]], { normal, sigma, every }, cylinder); }
    }
  }
  const step = Math.floor(pieces.length / kMostFitted) + 1;
  return pieces.filter((_, i) => i % step === 0).map((piece) => ({ ...piece, area: step * piece.area }));
}

function cutInto(pieces, waiting, { normal, sigma, every }, cylinder) {
  const { axis, radius, low, high } = cylinder;
  while (waiting.length > 0 && pieces.length < 4 * kMostPieces) {
    const [a, b, c] = waiting.pop();
    const middle = times(1 / 3, add(a, add(b, c)));
    const sides = [norm(subtract(b, a)), norm(subtract(c, b)), norm(subtract(a, c))];
    const longest = Math.max(...sides);
    const along = dot(axis, middle);
    if (along < low - longest || along > high + longest) { continue; }
    if (Math.abs(awayOf(cylinder, { p: middle }).distance - radius) > 2 * kMostOff[0] * radius + longest) { continue; }
    if (longest <= kPieceShare * radius) {
      pieces.push({ p: middle, normal, sigma, area: (every * norm(cross(subtract(b, a), subtract(c, a)))) / 2, side: longest });
      continue;
    }
    const [p, q, r] = [[a, b, c], [b, c, a], [c, a, b]][sides.indexOf(longest)];  // p q is the longest side
    const half = times(0.5, add(p, q));
    waiting.push([p, half, r], [half, q, r]);
  }
}

/// The pieces on the wall. Which way they face decides between hole and rod.
function wallOf(cylinder, pieces, mostOff) {
  const { axis, right, up, centre, radius, low, high } = cylinder;
  const sides = [[], []];  // rod, hole
  for (const piece of pieces) {
    const along = dot(axis, piece.p);
    if (along < low || along > high || Math.abs(dot(piece.normal, axis)) > kAcrossAxis) { continue; }
    const away = [dot(right, piece.p) - centre[0], dot(up, piece.p) - centre[1]];
    const distance = Math.hypot(...away);
    if (Math.abs(distance - radius) > mostOff * radius || distance === 0) { continue; }
    const outwards = (dot(right, piece.normal) * away[0] + dot(up, piece.normal) * away[1]) / distance;
    if (Math.abs(outwards) >= kTowardsAxis) { sides[outwards < 0 ? 1 : 0].push(piece); }
  }
  return area(sides[1]) > area(sides[0]) ? Object.assign(sides[1], { isHole: true }) : Object.assign(sides[0], { isHole: false });
}

const area = (pieces) => pieces.reduce((sum, piece) => sum + piece.area, 0);

function fitted(start, pieces, picks) {
  let cylinder = start;
  let wall = [];
  for (const mostOff of kMostOff) {
    wall = wallOf(cylinder, pieces, mostOff);
    if (wall.length < kLeastPieces) { return null; }
    cylinder = refined(cylinder, wall, picks);
    if (!cylinder) { return null; }
  }
  const arc = arcOf(cylinder, wall);
  if (arc < kLeastArc) { return null; }
  const areaM2 = area(wall);
  const mean = (value) => wall.reduce((sum, piece) => sum + (piece.area / areaM2) * value(piece), 0);
  const normal = cylinder.axis;
  if (Math.abs(mean((piece) => dot(piece.normal, normal))) > kMostSlope) { return null; }
  return {
    centre: add(flatCentre(cylinder), times(mean(({ p }) => dot(normal, p)), normal)), normal, radius: cylinder.radius,
    isHole: wall.isHole, arc, areaM2, rmsM: Math.sqrt(mean((piece) => (awayOf(cylinder, piece).distance - cylinder.radius) ** 2)),
    sideM: mean(({ side }) => side), share: cylinder.share, sigmaM: Math.sqrt(mean(({ sigma }) => sigma ** 2)),
  };
}

function awayOf({ right, up, centre }, { p }) {
  const [x, y] = [dot(right, p) - centre[0], dot(up, p) - centre[1]];
  return { x, y, distance: Math.hypot(x, y) };
}

/// The axis to which the wall's normals are square, and the circle of least squares about it (Gauss-Newton).
function refined(before, wall, picks) {
  let [axis] = eigen(scatter(wall)).vectors;
  if (dot(axis, before.axis) < 0) { axis = times(-1, axis); }
  const weight = area(wall);
  const along = wall.reduce((sum, { p, area: part }) => sum + (part / weight) * dot(before.axis, p), 0);
  const onAxis = add(flatCentre(before), times(along, before.axis));
  const frame = frameAcross(axis);
  const flat = wall.map(({ p, area: part }) => ({ x: dot(frame.right, p), y: dot(frame.up, p), share: part / weight }));
  let [cx, cy, radius] = [dot(frame.right, onAxis), dot(frame.up, onAxis), before.radius];
  let A = null;
  for (let round = 0; round < kRounds; ++round) {
    let xx = 0, xy = 0, yy = 0, x1 = 0, y1 = 0;  // sums of share times the products of J = -(x, y, 1), (x, y) a unit vector
    const b = [0, 0, 0];
    for (const { x, y, share } of flat) {
      const distance = Math.hypot(x - cx, y - cy);
      const [ux, uy] = [(x - cx) / distance, (y - cy) / distance];
      xx += share * ux * ux;
      xy += share * ux * uy;
      yy += share * uy * uy;
      x1 += share * ux;
      y1 += share * uy;
      const off = share * (distance - radius);
      b[0] += off * ux;
      b[1] += off * uy;
      b[2] += off;
    }
    A = [[xx, xy, x1], [xy, yy, y1], [x1, y1, 1]];
    const step = solve(A, b);
    if (!step || step.some((value) => !Number.isFinite(value))) { return null; }
    [cx, cy, radius] = [cx + step[0], cy + step[1], radius + step[2]];
    if (Math.hypot(...step) < kConverged * radius) { break; }
  }
  const cylinder = { axis, ...frame, centre: [cx, cy], radius };
  const share = solve(A, [0, 0, 1])?.[2];  // of the radius in the inverse of the normal matrix
  return cylinder.radius > 0 && share > 0 ? withEnds({ ...cylinder, share }, picks) : null;
}

/// How much of the way round has a piece.
function arcOf(cylinder, wall) {
  const seen = new Set(wall.map((piece) => {
    const { x, y } = awayOf(cylinder, piece);
    return Math.min(Math.floor((Math.atan2(y, x) / (2 * Math.PI) + 0.5) * kArcParts), kArcParts - 1);
  }));
  return (2 * Math.PI * seen.size) / kArcParts;
}

// The outline of a mesh in a plane, exact on the triangles. Metres.
//
// A patch is part of a mesh: {positions: Float64Array x y z x y z ..., indices, sigmas: Float32Array or null}. Patches meet where their
// vertices have the same coordinates.

import { cross, dot, norm, unit } from './vectors.js';

const kUpright = 1e-9;

/// The axes of the drawing: seen against the normal, z is up, or y where the normal is z (as `scanknit measure --section` draws).
export function drawingAxes(normal) {
  const across = cross([0, 0, 1], normal);
  const right = norm(across) > kUpright ? unit(across) : [normal[2] > 0 ? 1 : -1, 0, 0];
  return { right, up: cross(normal, right) };
}

/// {outlines: [{points, isClosed, lengthM, areaM2}], lengthM, areaM2, closed, open, sigmaM}, the longest outline first. `areaM2` of an
/// outline: positive round matter, negative round a hole; in all: null when an outline is open. `sigmaM`: root mean square of the
/// vertices' sigmas along it. A vertex on the plane counts as above it.
export function cutPatches(patches, { normal, offset }) {
  const segments = [];
  let weight = 0, squares = 0;
  for (const patch of patches) {
    for (const segment of segmentsOf(patch, normal, offset)) {
      segments.push(segment);
      const length = Math.hypot(...segment.end.map((x, i) => x - segment.start[i]));
      weight += length;
      squares += length * segment.sigma ** 2;
    }
  }
  const axes = drawingAxes(normal);
  const outlines = chained(segments).map((chain) => outlineOf(chain, axes)).sort((a, b) => b.lengthM - a.lengthM);
  const closed = outlines.filter(({ isClosed }) => isClosed).length;
  const sum = (name) => outlines.reduce((total, outline) => total + outline[name], 0);
  return {
    outlines, lengthM: sum('lengthM'), areaM2: closed === outlines.length && closed > 0 ? sum('areaM2') : null, closed,
    open: outlines.length - closed, sigmaM: weight > 0 ? Math.sqrt(squares / weight) : 0,
  };
}

/// Directed so that, seen against the normal, matter is to the left.
function* segmentsOf({ positions, indices, sigmas }, normal, offset) {
  const heights = new Float64Array(positions.length / 3);
  for (let v = 0; v < heights.length; ++v) {
    heights[v] = normal[0] * positions[3 * v] + normal[1] * positions[3 * v + 1] + normal[2] * positions[3 * v + 2] - offset;
  }
  for (let t = 0; t < indices.length; t += 3) {
    const isAbove = heights[indices[t]] >= 0;
    if (isAbove === heights[indices[t + 1]] >= 0 && isAbove === heights[indices[t + 2]] >= 0) { continue; }
    const corners = [indices[t], indices[t + 1], indices[t + 2]];
    const above = corners.map((v) => heights[v] >= 0);
    const segment = { sigma: sigmas ? (sigmas[corners[0]] + sigmas[corners[1]] + sigmas[corners[2]]) / 3 : 0 };
    for (let i = 0; i < 3; ++i) {
      const j = (i + 1) % 3;
      if (above[i] === above[j]) { continue; }
      const crossing = crossingOf(positions, heights, corners[i], corners[j]);
      if (above[i]) {
        [segment.start, segment.startKey] = crossing;
      } else {
        [segment.end, segment.endKey] = crossing;
      }
    }
    yield segment;
  }
}

/// [point, name of the edge]: the same from either side of an edge, and in either patch.
function crossingOf(positions, heights, v, w) {
  const at = (i) => [positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]];
  let [a, b, ha, hb] = [at(v), at(w), heights[v], heights[w]];
  if (comesAfter(a, b)) { [a, b, ha, hb] = [b, a, hb, ha]; }
  const share = ha / (ha - hb);
  return [a.map((x, axis) => x + share * (b[axis] - x)), `${a} ${b}`];
}

function comesAfter(a, b) {
  const axis = a.findIndex((x, i) => x !== b[i]);
  return axis >= 0 && a[axis] > b[axis];
}

/// Lists of successive segments; those of closed outlines end where they begin.
function chained(segments) {
  const leaving = new Map();   // edge -> its segments that begin there
  const arriving = new Map();  // edge -> how many end there
  for (const segment of segments) {
    if (!leaving.has(segment.startKey)) { leaving.set(segment.startKey, []); }
    leaving.get(segment.startKey).push(segment);
    arriving.set(segment.endKey, (arriving.get(segment.endKey) ?? 0) + 1);
  }
  const chains = [];
  const follow = (first) => {
    const chain = [];
    for (let next = first; next; next = leaving.get(next.endKey)?.pop()) { chain.push(next); }
    chains.push(chain);
  };
  for (const [edge, list] of leaving) {  // open ones begin where nothing arrives
    for (let spare = list.length - (arriving.get(edge) ?? 0); spare > 0; --spare) { follow(list.pop()); }
  }
  for (const list of leaving.values()) {
    while (list.length > 0) { follow(list.pop()); }
  }
  return chains;
}

function outlineOf(chain, { right, up }) {
  const isClosed = chain[0].startKey === chain.at(-1).endKey;
  const points = chain.map(({ start }) => start);
  if (!isClosed) { points.push(chain.at(-1).end); }
  const flat = points.map((p) => [dot(right, p), dot(up, p)]);
  let lengthM = 0, doubleArea = 0;
  for (let i = 0; i < flat.length - (isClosed ? 0 : 1); ++i) {
    const [a, b] = [flat[i], flat[(i + 1) % flat.length]];
    lengthM += Math.hypot(b[0] - a[0], b[1] - a[1]);
    doubleArea += (a[0] - flat[0][0]) * (b[1] - flat[0][1]) - (b[0] - flat[0][0]) * (a[1] - flat[0][1]);
  }
  return { points, flat, isClosed, lengthM, areaM2: isClosed ? doubleArea / 2 : 0 };
}

const kMargin = 0.06;  // of the drawing's larger side
const kMmPerM = 1000;

/// A drawing in millimetres, true to size. `caption`: a line of text below it.
export function sectionSvg({ outlines }, caption) {
  const all = outlines.flatMap(({ flat }) => flat);
  const [low, high] = [Math.min, Math.max].map((pick) => [0, 1].map((axis) => all.reduce((best, p) => pick(best, p[axis]), all[0][axis])));
  const size = [0, 1].map((axis) => kMmPerM * (high[axis] - low[axis]));
  const margin = kMargin * Math.max(...size), text = margin / 2;
  const width = Math.max(size[0], 0.55 * text * caption.length) + 2 * margin, height = size[1] + 3 * margin;
  const number = (x) => String(Number(x.toFixed(5)));
  const place = ([x, y]) => `${number(kMmPerM * (x - low[0]) + margin)} ${number(kMmPerM * (high[1] - y) + margin)}`;
  const path = ({ flat, isClosed }) => `M${flat.map(place).join('L')}${isClosed ? 'Z' : ''}`;
  const paths = (isClosed) => outlines.filter((outline) => outline.isClosed === isClosed).map(path).join('\n');
  const escaped = caption.replace(/[&<>]/g, (sign) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;' })[sign]);
  const [w, h, line, left, bottom, letters] = [width, height, text / 15, margin, height - text, text].map(number);
  return [
    `<svg xmlns="http://www.w3.org/2000/svg" width="${w}mm" height="${h}mm" viewBox="0 0 ${w} ${h}">`,
    `<path fill="#ddd" fill-rule="evenodd" stroke="#000" stroke-width="${line}" d="${paths(true)}"/>`,
    `<path fill="none" stroke="#c00" stroke-width="${line}" d="${paths(false)}"/>`,
    `<text x="${left}" y="${bottom}" font-family="sans-serif" font-size="${letters}" fill="#024">${escaped}</text>`,
    '</svg>', '',
  ].join('\n');
}

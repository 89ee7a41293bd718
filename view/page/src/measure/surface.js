// The mesh of the page as geometry: what a ray meets, and the parts near a place. In the scan's world, metres.

import { add, cross, dot, norm, subtract, times, unit } from './vectors.js';
import { surfaceSigma } from './uncertainty.js';

/// A patch (section.js) of a chunk's bytes, 16 a vertex (docs/live_view.md), with `vertexAt(v)`: {statedM, coverage}.
export function patchOf({ bytes, indices, origin, scale, voxelSizeM }) {
  const words = new Uint16Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 2);
  const count = bytes.byteLength / 16;
  const positions = new Float64Array(3 * count);
  const sigmas = new Float32Array(count);
  const vertexAt = (v) => ({ statedM: 1e-6 * words[8 * v + 3], coverage: bytes[16 * v + 11] / 255 });
  for (let v = 0; v < count; ++v) {
    for (let axis = 0; axis < 3; ++axis) { positions[3 * v + axis] = origin[axis] + scale * words[8 * v + axis]; }
    sigmas[v] = surfaceSigma({ ...vertexAt(v), voxelSizeM }).sigmaM;
  }
  return { positions, indices, sigmas, vertexAt, stepM: scale };
}

/// Where a ray first meets the patch: {t, p, normal, at: [[vertex, share], ...]}, or null. `direction` is a unit vector; `normal` is that of
/// the triangle. Backs of triangles count if `isTwoSided`. Moeller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".
export function firstHit({ positions, indices }, { origin, direction }, isTwoSided) {
  const at = (v) => [positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]];
  let best = null;
  for (let t = 0; t < indices.length; t += 3) {
    const [i, j, k] = [indices[t], indices[t + 1], indices[t + 2]];
    const a = at(i), b = at(j), c = at(k);
    const ab = subtract(b, a), ac = subtract(c, a);
    const across = cross(direction, ac);
    const det = dot(ab, across);
    if (!(isTwoSided ? det !== 0 : det > 0)) { continue; }
    const from = subtract(origin, a);
    const u = dot(from, across) / det;
    if (!(u >= 0 && u <= 1)) { continue; }
    const turned = cross(from, ab);
    const v = dot(direction, turned) / det;
    if (!(v >= 0 && u + v <= 1)) { continue; }
    const far = dot(ac, turned) / det;
    if (far > 0 && far < (best?.t ?? Infinity)) {
      best = { t: far, normal: unit(cross(ab, ac)), at: [[i, 1 - u - v], [j, u], [k, v]] };
    }
  }
  return best && best.normal && { ...best, p: add(origin, times(best.t, direction)) };
}

/// What is known of the surface where a ray met it: {sigmaM, from}, as surfaceSigma() says. Stated only if all three corners are.
export function sigmaAt(patch, { at }, voxelSizeM) {
  const corners = at.map(([v, share]) => ({ ...patch.vertexAt(v), share }));
  const mean = (value) => corners.reduce((sum, corner) => sum + corner.share * value(corner), 0);
  const isStated = corners.every(({ statedM }) => statedM > 0);
  return surfaceSigma({ statedM: isStated ? mean(({ statedM }) => statedM) : 0, voxelSizeM, coverage: mean(({ coverage }) => coverage) });
}

/// The distance at which a ray enters a box {min, max} (arrays), 0 from inside; Infinity if it misses.
export function entryOf({ origin, direction }, { min, max }) {
  let near = 0, far = Infinity;
  for (let axis = 0; axis < 3; ++axis) {
    const ends = [min[axis], max[axis]].map((side) => (side - origin[axis]) / direction[axis]);
    if (ends.some(Number.isNaN)) { continue; }  // along a side, on it
    near = Math.max(near, Math.min(...ends));
    far = Math.min(far, Math.max(...ends));
  }
  return near <= far ? near : Infinity;
}

export const boxMeetsPlane = ({ min, max }, { normal, offset }) => {
  const middle = min.map((low, axis) => (low + max[axis]) / 2 * normal[axis]).reduce((a, b) => a + b);
  const reach = min.map((low, axis) => ((max[axis] - low) / 2) * Math.abs(normal[axis])).reduce((a, b) => a + b);
  return Math.abs(middle - offset) <= reach * (1 + 1e-9) + 1e-12;
};

export const boxMeetsBall = ({ min, max }, centre, radius) =>
  norm(centre.map((x, axis) => Math.max(min[axis] - x, 0, x - max[axis]))) <= radius;

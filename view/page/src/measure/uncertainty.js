// How uncertain what is measured on the page is; docs/measuring.md#in-the-browser has the formulas in words.

/// What the page states is so many standard deviations: 95 % of a normal distribution.
export const kStated = 2;

// Without uncertainties of the vertices: a rule of thumb with what the page knows (docs/measuring.md).
const kViewsAlike = 1.7;      // neighbouring views err alike
const kVoxelShare = 0.05;     // of the voxel: what no number of views removes
const kViewNoiseVoxels = 0.5;  // one view's noise: voxels are chosen so
const kWellSeen = 10;         // views: a vertex with coverage 1 has had as many, or more

const kUniform = 1 / Math.sqrt(12);  // standard deviation of what lies anywhere in a step of 1

/// One standard deviation of the surface's place, metres. `statedM`: the scan's own at that place, 0 where unknown; `coverage` 0 to 1.
/// {sigmaM, from}: 'stated', 'voxels', or 'unknown', where sigmaM is 0.
export function surfaceSigma({ statedM = 0, voxelSizeM = 0, coverage = 1 }) {
  if (statedM > 0) { return { sigmaM: statedM, from: 'stated' }; }
  if (!(voxelSizeM > 0)) { return { sigmaM: 0, from: 'unknown' }; }
  const views = Math.max(kWellSeen * coverage * coverage, 1);
  return { sigmaM: voxelSizeM * Math.hypot((kViewsAlike * kViewNoiseVoxels) / Math.sqrt(views), kVoxelShare), from: 'voxels' };
}

/// One standard deviation of a picked point, in any direction: the surface's, the step to which the page's mesh is rounded, and the width
/// of a pixel there, within which nobody can point.
export const pointSigma = ({ surfaceM, stepM, pixelM }) => Math.hypot(surfaceM, kUniform * stepM, kUniform * pixelM);

/// One standard deviation of f(points), by moving each point by its sigma along `directions`, independent of each other: half of what that
/// changes to both sides, added in squares (JCGM 100:2008, 5.1.3, note 2). Infinity where f is not defined.
export function propagated(f, points, sigmas, directions = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]) {
  let variance = 0;
  points.forEach((point, i) => {
    for (const direction of directions) {
      const at = (sign) => f(points.map((other, k) => (k === i ? point.map((x, axis) => x + sign * sigmas[i] * direction[axis]) : other)));
      variance += ((at(1) - at(-1)) / 2) ** 2;
    }
  });
  return Number.isNaN(variance) ? Infinity : Math.sqrt(variance);
}

/// One standard deviation of a section's area and of the length of its outlines, if the whole surface is off by sigmaM to one side: the
/// area changes by the length of the outline, the length by a full turn for each closed outline (Steiner), and by two ends for each open
/// one.
export const outlineSigma = ({ lengthM, closed, open, sigmaM }) => ({
  areaM2: sigmaM * lengthM,
  lengthM: sigmaM * Math.hypot(2 * Math.PI * closed, Math.SQRT2 * open),
});

/// One standard deviation of a fitted circle's radius. `share`: of the variance of one place that is left, by how far the wall goes round;
/// rmsM: of the wall's distances, which average out over `places`; sigmaM: of the surface, which does not.
export const fittedSigma = ({ share, rmsM, places, sigmaM }) => Math.sqrt(share * (sigmaM ** 2 + rmsM ** 2 / Math.max(places, 1)));

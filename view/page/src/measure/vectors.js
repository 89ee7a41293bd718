// Vectors of three numbers, and matrices of 3 x 3 as rows.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const times = (factor, a) => [factor * a[0], factor * a[1], factor * a[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const norm = (a) => Math.hypot(a[0], a[1], a[2]);

/// Of length 1; null when `a` has no direction.
export function unit(a) {
  const length = norm(a);
  return length > 0 ? times(1 / length, a) : null;
}

/// Two unit vectors: with `axis`, itself one, they make a right-handed frame.
export function frameAcross(axis) {
  const least = [0, 1, 2].reduce((best, i) => (Math.abs(axis[i]) < Math.abs(axis[best]) ? i : best), 0);
  const helper = [0, 0, 0];
  helper[least] = 1;
  const right = unit(cross(helper, axis));
  return { right, up: cross(axis, right) };
}

/// x with A x = b; null when A is singular.
export function solve(A, b) {
  const det = dot(A[0], cross(A[1], A[2]));
  const size = norm(A[0]) * norm(A[1]) * norm(A[2]);
  if (!(Math.abs(det) > 1e-12 * size)) { return null; }
  // Columns of the inverse are cross products of the rows over the determinant.
  const [c0, c1, c2] = [cross(A[1], A[2]), cross(A[2], A[0]), cross(A[0], A[1])];
  return [0, 1, 2].map((i) => (c0[i] * b[0] + c1[i] * b[1] + c2[i] * b[2]) / det);
}

/// {values, vectors} of a symmetric matrix, the smallest value first: Jacobi's rotations.
export function eigen(symmetric) {
  const A = symmetric.map((row) => [...row]);
  const V = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];  // its columns become the vectors
  for (let sweep = 0; sweep < 30; ++sweep) {
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) {
      if (A[p][q] === 0) { continue; }
      const theta = (A[q][q] - A[p][p]) / (2 * A[p][q]);
      const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(1, theta));
      const c = 1 / Math.hypot(1, t), s = t * c;
      const rotate = (x, y) => [c * x - s * y, s * x + c * y];
      for (let k = 0; k < 3; ++k) { [A[k][p], A[k][q]] = rotate(A[k][p], A[k][q]); }
      for (let k = 0; k < 3; ++k) { [A[p][k], A[q][k]] = rotate(A[p][k], A[q][k]); }
      for (let k = 0; k < 3; ++k) { [V[k][p], V[k][q]] = rotate(V[k][p], V[k][q]); }
    }
  }
  const order = [0, 1, 2].sort((i, j) => A[i][i] - A[j][j]);
  return { values: order.map((i) => A[i][i]), vectors: order.map((i) => V.map((row) => row[i])) };
}

// What follows from two or three points alone. Points in metres, angles in radians.

import { add, cross, dot, frameAcross, norm, subtract, times, unit } from './vectors.js';

export const distanceOf = ([a, b]) => norm(subtract(b, a));

/// The angle at the middle point, 0 to pi.
export function angleOf([a, b, c]) {
  const [u, v] = [subtract(a, b), subtract(c, b)];
  return Math.atan2(norm(cross(u, v)), dot(u, v));
}

/// {centre, normal, radius}; null when the points are on a line.
export function circleThrough([a, b, c]) {
  const [u, v] = [subtract(b, a), subtract(c, a)];
  const across = cross(u, v);
  const square = dot(across, across);
  if (!(square > 1e-18 * dot(u, u) * dot(v, v))) { return null; }
  // Its centre from a: (|v|^2 u x v x u + |u|^2 v x u x v) / 2 |u x v|^2.
  const arm = times(1 / (2 * square), add(times(dot(v, v), cross(across, u)), times(dot(u, u), cross(v, across))));
  return { centre: add(a, arm), normal: unit(across), radius: norm(arm) };
}

export const diameterOf = (points) => 2 * (circleThrough(points)?.radius ?? NaN);

/// {normal, offset}: the points p with normal . p = offset; null when the three points are on a line.
export function planeThrough(points) {
  const circle = circleThrough(points);
  return circle && { normal: circle.normal, offset: dot(circle.normal, points[0]) };
}

/// Points of a circle, the first again at the end.
export function pointsOnCircle({ centre, normal, radius }, count = 96) {
  const { right, up } = frameAcross(normal);
  return Array.from({ length: count + 1 }, (_, i) => {
    const turn = (2 * Math.PI * (i % count)) / count;
    return add(centre, add(times(radius * Math.cos(turn), right), times(radius * Math.sin(turn), up)));
  });
}

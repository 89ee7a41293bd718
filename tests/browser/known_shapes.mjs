// Meshes with known measures: {points, triangles}, metres.

/// A closed box round the origin, each side in steps x steps squares.
export function boxOf([x, y, z], steps = 8) {
  const points = [], triangles = [], numbers = new Map();
  const sizes = [x, y, z];
  const vertex = (grid) => {
    const key = grid.join();
    if (!numbers.has(key)) {
      numbers.set(key, points.length);
      points.push(grid.map((g, axis) => (g / steps - 0.5) * sizes[axis]));
    }
    return numbers.get(key);
  };
  for (let axis = 0; axis < 3; ++axis) {
    for (const end of [0, steps]) {
      for (let i = 0; i < steps * steps; ++i) {
        const quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([du, dv]) => {
          const grid = [0, 0, 0];
          grid[axis] = end;
          grid[(axis + 1) % 3] = (i % steps) + du;
          grid[(axis + 2) % 3] = Math.floor(i / steps) + dv;
          return vertex(grid);
        });
        if (end === 0) { quad.reverse(); }
        triangles.push([quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]);
      }
    }
  }
  return { points, triangles };
}

/// A sphere round the origin.
export function sphereOf(radius, rows = 64) {
  const columns = 2 * rows;
  const points = [[0, 0, radius]];
  for (let row = 1; row < rows; ++row) {
    for (let column = 0; column < columns; ++column) {
      const [down, round] = [(Math.PI * row) / rows, (2 * Math.PI * column) / columns];
      points.push([radius * Math.sin(down) * Math.cos(round), radius * Math.sin(down) * Math.sin(round), radius * Math.cos(down)]);
    }
  }
  points.push([0, 0, -radius]);
  const at = (row, column) => (row === 0 ? 0 : row === rows ? points.length - 1 : 1 + (row - 1) * columns + (column % columns));
  const triangles = [];
  for (let row = 0; row < rows; ++row) {
    for (let column = 0; column < columns; ++column) {
      const [a, b, c, d] = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
      if (row < rows - 1) { triangles.push([a, b, c]); }
      if (row > 0) { triangles.push([a, c, d]); }
    }
  }
  return { points, triangles };
}

/// A closed ring about z: a tube from `inner` to `outer`, of that height, in flat facets.
export function tubeOf(inner, outer, height, facets = 128) {
  const points = [], triangles = [];
  for (const [radius, z] of [[inner, 0], [outer, 0], [outer, height], [inner, height]]) {
    for (let i = 0; i < facets; ++i) {
      const turn = (2 * Math.PI * i) / facets;
      points.push([radius * Math.cos(turn), radius * Math.sin(turn), z - height / 2]);
    }
  }
  for (let side = 0; side < 4; ++side) {
    for (let i = 0; i < facets; ++i) {
      const [a, b] = [side * facets + i, side * facets + ((i + 1) % facets)];
      const [c, d] = [((side + 1) % 4) * facets + ((i + 1) % facets), ((side + 1) % 4) * facets + i];
      triangles.push([a, b, c], [a, c, d]);
    }
  }
  return { points, triangles };
}

/// As ASCII PLY; `uncertainty`: metres, of every vertex.
export function plyOf({ points, triangles }, { uncertainty = null } = {}) {
  const header = ['ply', 'format ascii 1.0', `element vertex ${points.length}`, ...['x', 'y', 'z'].map((name) => `property float ${name}`),
    ...(uncertainty === null ? [] : ['property float uncertainty']), `element face ${triangles.length}`,
    'property list uchar int vertex_indices', 'end_header'];
  const vertices = points.map((p) => [...p, ...(uncertainty === null ? [] : [uncertainty])].join(' '));
  return [...header, ...vertices, ...triangles.map((corners) => `3 ${corners.join(' ')}`), ''].join('\n');
}

/// As a patch of view/page/src/measure/section.js.
export const patchOf = ({ points, triangles }, sigma = 0) => ({
  positions: new Float64Array(points.flat()), indices: new Uint32Array(triangles.flat()), sigmas: new Float32Array(points.length).fill(sigma),
});

/// As vertices and indices for mock_program.mjs' chunkBody().
export const chunkOf = ({ points, triangles }, coverage = 255) => [
  points.map((p) => ({ p, colour: [150, 160, 170], normal: [0, 0, 0], coverage })), triangles.flat(),
];

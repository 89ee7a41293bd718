// The made-up scan of mock_program.mjs: a vase, cut into chunks, and a scanner that walks round it.

const kRows = 150, kColumns = 220;
const kChunkM = 0.05;
const kDepthJpeg = [
  '/9j/4AAQSkZJRgABAQAAAQABAAD/4gHYSUNDX1BST0ZJTEUAAQEAAAHIAAAAAAQwAABtbnRyUkdCIFhZWiAH4AABAAEAAAAAAABhY3NwAAAAAAAAAAAAAAAA',
  'AAAAAAAAAAAAAAAAAAAAAQAA9tYAAQAAAADTLQAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAlkZXNjAAAA8AAA',
  'ACRyWFlaAAABFAAAABRnWFlaAAABKAAAABRiWFlaAAABPAAAABR3dHB0AAABUAAAABRyVFJDAAABZAAAAChnVFJDAAABZAAAAChiVFJDAAABZAAAAChjcHJ0',
  'AAABjAAAADxtbHVjAAAAAAAAAAEAAAAMZW5VUwAAAAgAAAAcAHMAUgBHAEJYWVogAAAAAAAAb6IAADj1AAADkFhZWiAAAAAAAABimQAAt4UAABjaWFlaIAAA',
  'AAAAACSgAAAPhAAAts9YWVogAAAAAAAA9tYAAQAAAADTLXBhcmEAAAAAAAQAAAACZmYAAPKnAAANWQAAE9AAAApbAAAAAAAAAABtbHVjAAAAAAAAAAEAAAAM',
  'ZW5VUwAAACAAAAAcAEcAbwBvAGcAbABlACAASQBuAGMALgAgADIAMAAxADb/2wBDAA0JCgsKCA0LCgsODg0PEyAVExISEyccHhcgLikxMC4pLSwzOko+MzZG',
  'NywtQFdBRkxOUlNSMj5aYVpQYEpRUk//2wBDAQ4ODhMREyYVFSZPNS01T09PT09PT09PT09PT09PT09PT09PT09PT09PT09PT09PT09PT09PT09PT09PT09P',
  'T0//wAARCAB4AKADASIAAhEBAxEB/8QAGgABAQADAQEAAAAAAAAAAAAAAAIDBAYFAf/EACkQAAICAgAFAwMFAAAAAAAAAAARAQIDBAUSITFBUWFxBoHwEyJC',
  'obH/xAAaAQEAAwEBAQAAAAAAAAAAAAAAAgUGAwEE/8QAJBEAAgIBAwUAAwEAAAAAAAAAAAECEQMEBRITITFBUWGR0SL/2gAMAwEAAhEDEQA/AONQRSCLE+ey',
  'UEUggLJQRSCAslBFIICyUEUggLJQRSCAslBFIICyUEUggLJQRSCAslBFIICykEWgjwjZCCLQQFkIItBAWQgi0ZtXWybOWKY4+Z9CMpKKtkopydLya6M1dPYt',
  '2xW+/Q6DV4bjwVjlq7ebT3NuNb2K7JuCTqCLTHttq5v9HKW09inWcVvt1MKOxnW9jU2uG489Z5qq3i0dxj3BN/7QybbSuD/ZzCCNna1smtl5MkfE+phRYxkp',
  'K0Vck4un5IQRaCJEbIQRaCAshBFoICykEUgiJGyUEUggLJQRSCAsUx2yXrSkO1pUQdVoaNNXBFIh272n1k836f1YvmvsWjpT9tfn8/06OlCo3DO3Lprwi727',
  'Aow6r8siuP2LihmrQuKFXZYORrchFsfsbk0ItQWeqR5G/o02sE0mFbvWfSTlb47Y72peFasqYO7vQ5z6g1YpmpsVjpf9tvn8/wALTb87Uum/DK7ccClDqryv',
  'J4qCKQRblJZKCKQQFkoIpBAWUgikEeEbJQRSCAslBFIICzquDYf0+HYoXW0c0/c9SlTX1q8uGlfSsQbmODMZZcpuX01MVwgo/EXShkih9pU2K0OLZCUjWmhj',
  'tQ3bUNe9QmIyNO9Ty+M4f1OHZenWsc0fY9jJBp7NYthvX1rMHbFLjNS+E5LnBx+o4dBFII05lrJQRSCAslBFIICy0EUgiJGyUEUggLJQRSCAs7PDLrWY8wbe',
  'M87QyRk1MVo81g3sdjMTVNo1l8opm5jk2Kz0NOljNFzk0cZIzWmEa+SSpuYb2CQijFkNTNKraZ8QbF7GjvZIx6mW0+KydYK2kdr4xbOQQRSCNOZOyUEUggLJ',
  'QRSCAspBFII8I2SgikEBZKCKQQFnt8Ez82tOKe+Of6n8k9eljldLPOtsRf8AjPS3wdFjyRMRMSUmtxccl+maTb8yy4VH2u38N6tzJFzTrcqLnxUfW4m1NzHa',
  '5hm5NrigolXseRxvNy60Yo73n+oN/JkiImZk53dzzs7E3/jHSvwfbosXLJfpHybjmWLC4+32/pqoIpBF2ZuyUEUggLJQRSCAspBFIIiRslBFIICyUEUggLJR',
  'v6W5NIjHknp4k0kEQyY45I8ZHbT6ieCfOJ0FM8GSM0ep4OPPfHC7wZ4248uCrno5xfbuaLDuODIu7p/k9ecsepjvniDzJ249zBkz3yQu0CGknJ91Qy7jgxrs',
  '7f4M+7uTeJx456eZNBFIItMeOOOPGJndRqJ5585EoIpBEzjZKCKQQFkoIpBAWWggDwiEEAAEEAAEEAAEEAAEEAAEEAAEEAAEEAAEEAAf/9k=',
].join('');

export const depthJpeg = () => new Uint8Array(Buffer.from(kDepthJpeg, 'base64'));

/// The world is that of a camera: y down. The vase stands on y = 0, metres.
function vasePoint(row, column) {
  const t = row / (kRows - 1);
  const angle = (2 * Math.PI * column) / kColumns;
  const ripple = 1 + 0.05 * Math.sin(9 * angle + 5 * t) * Math.sin(Math.PI * t);
  const radius = (0.035 + 0.042 * Math.sin(2.7 * t + 0.35) ** 2 + 0.012 * t ** 6) * ripple;
  return [radius * Math.cos(angle), -0.22 * t, radius * Math.sin(angle)];
}

function vaseVertex(row, column) {
  const p = vasePoint(row, column);
  const along = subtract(vasePoint(Math.min(row + 1, kRows - 1), column), vasePoint(Math.max(row - 1, 0), column));
  const round = subtract(vasePoint(row, column + 1), vasePoint(row, column - 1));
  const stripe = 0.5 + 0.5 * Math.sin(0.19 * row + 2 * Math.sin(0.17 * column));
  const glaze = row > 112 ? [226, 222, 205] : [Math.round(40 + 150 * stripe), Math.round(110 + 60 * stripe), Math.round(150 - 60 * stripe)];
  return { p, normal: unit(cross(round, along)), colour: glaze, coverage: Math.round(255 * (0.5 + 0.5 * Math.cos((2 * Math.PI * column) / kColumns))) };
}

const subtract = (a, b) => a.map((x, i) => x - b[i]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));

/// T_world_camera, column after column, of a scanner that looks at the vase from that side.
export function orbitPose(azimuth) {
  const eye = [0.45 * Math.cos(azimuth), -0.3, 0.45 * Math.sin(azimuth)];
  const ahead = unit(subtract([0, -0.11, 0], eye));
  const right = unit(cross([0, 1, 0], ahead));
  return [...right, 0, ...cross(ahead, right), 0, ...ahead, 0, ...eye, 1];
}

/// {revealed(share): chunks that are new up to that share of the vase, triangles(share)}.
export function chunksOfVase(body) {
  const cells = new Map();
  for (let column = 0; column < kColumns; ++column) {
    for (let row = 0; row + 1 < kRows; ++row) { addQuad(cells, row, column); }
  }
  const chunks = [...cells.values()].map((cell, number) => ({ number, at: cell.at, count: cell.indices.length / 3, body: body(cell.vertices, cell.indices) }));
  let last = -1;
  return {
    revealed(share) {
      const fresh = chunks.filter(({ at }) => at <= share && at > last);
      last = share;
      return fresh;
    },
    triangles: (share) => chunks.filter(({ at }) => at <= share).reduce((sum, { count }) => sum + count, 0),
  };
}

function addQuad(cells, row, column) {
  const corners = [[row, column], [row, column + 1], [row + 1, column + 1], [row + 1, column]];
  const key = vasePoint(row, column).map((x) => Math.floor(x / kChunkM)).join();
  if (!cells.has(key)) { cells.set(key, { at: column / kColumns, vertices: [], indices: [], known: new Map() }); }
  const cell = cells.get(key);
  const [a, b, c, d] = corners.map(([r, k]) => {
    const name = r * kColumns + (k % kColumns);
    if (!cell.known.has(name)) {
      cell.known.set(name, cell.vertices.length);
      cell.vertices.push(vaseVertex(r, k));
    }
    return cell.known.get(name);
  });
  cell.indices.push(a, b, c, a, c, d);
}

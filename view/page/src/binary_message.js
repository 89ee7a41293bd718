// Reads the binary messages of docs/live_view.md. Vertices and indices are views of the message, not copies.

export const kMeshChunk = 1;
export const kChunkGone = 2;
export const kDepthPicture = 3;

const kMagic = 0x314d4b53;  // "SKM1", little endian
const kHeaderBytes = 16;
const kChunkHeaderBytes = 32;
const kVertexBytes = 16;

/// {kind, chunk, revision} and, by kind, {vertexBits, indices, hasColours, origin, scale} or {jpeg}. Throws when malformed.
export function readBinaryMessage(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < kHeaderBytes || view.getUint32(0, true) !== kMagic) { throw new Error('not a message of this protocol'); }
  const message = { kind: view.getUint32(4, true), chunk: view.getUint32(8, true), revision: view.getUint32(12, true) };
  if (message.kind === kMeshChunk) { return Object.assign(message, readChunk(buffer, view)); }
  if (message.kind === kDepthPicture) { message.jpeg = new Uint8Array(buffer, kHeaderBytes); }
  return message;
}

function readChunk(buffer, view) {
  const at = kHeaderBytes;
  const vertices = view.getUint32(at, true);
  const indexCount = view.getUint32(at + 4, true);
  const flags = view.getUint32(at + 8, true);
  const float = (offset) => view.getFloat32(at + offset, true);
  const vertexStart = kHeaderBytes + kChunkHeaderBytes;
  const indexStart = vertexStart + vertices * kVertexBytes;
  const IndexArray = flags & 2 ? Uint32Array : Uint16Array;
  return {
    // Four words for each vertex; the shader unpacks them.
    vertexBits: new Uint32Array(buffer, vertexStart, 4 * vertices),
    positions: new Uint16Array(buffer, vertexStart, 8 * vertices),
    indices: new IndexArray(buffer, indexStart, indexCount),
    hasColours: (flags & 1) !== 0,
    origin: [float(16), float(20), float(24)],
    scale: float(28),
  };
}

// The received mesh: one geometry for each chunk number, replaced and disposed, and the extent of all of them.

import { Box3, BufferAttribute, BufferGeometry, Mesh, Sphere, Vector3 } from 'three';

export class ChunkStore {
  /// Meshes become children of `group`; `materials` has one for coloured chunks and one for the others. `gl` draws them.
  constructor(group, materials, gl) {
    Object.assign(this, { group, materials, gl });
    this.chunks = new Map();  // number -> {mesh, box, origin, scale, revision, triangles, vertices}
    this.triangles = 0;
    this.vertices = 0;
    this.beside = new Box3();  // what is drawn but is no chunk: tiles
    this.bounds = new Box3();
    this.areBoundsKnown = true;
  }

  set(message) {
    this.remove(message.chunk);
    if (message.indices.length === 0) { return; }
    const box = extent(message);
    const mesh = new Mesh(geometryOf(message, box, this.gl), message.hasColours ? this.materials.colour : this.materials.clay);
    mesh.matrixAutoUpdate = false;
    mesh.matrix.makeScale(message.scale, message.scale, message.scale).setPosition(...message.origin);
    const chunk = {
      mesh, box, origin: message.origin, scale: message.scale, revision: message.revision, triangles: message.indices.length / 3,
      vertices: message.vertexBits.length / 4,
    };
    this.chunks.set(message.chunk, chunk);
    this.group.add(mesh);
    this.triangles += chunk.triangles;
    this.vertices += chunk.vertices;
    if (this.areBoundsKnown) { this.bounds.union(box); }
  }

  remove(number) {
    const chunk = this.chunks.get(number);
    if (!chunk) { return; }
    this.chunks.delete(number);
    this.group.remove(chunk.mesh);
    chunk.mesh.geometry.dispose();
    this.triangles -= chunk.triangles;
    this.vertices -= chunk.vertices;
    this.areBoundsKnown = false;  // the removed chunk may have defined the bounds
  }

  /// {bytes, indices, origin, scale} of one of the chunks: 16 bytes a vertex, as the program sent them.
  read({ mesh: { geometry }, origin, scale }) {
    const words = this.arrayOf(geometry.attributes.vertexBits);
    return { bytes: new Uint8Array(words.buffer, words.byteOffset, words.byteLength), indices: this.arrayOf(geometry.index), origin, scale };
  }

  arrayOf(attribute) {
    if (attribute.array) { return attribute.array; }  // not drawn yet
    const { gl } = this;
    const { buffer, ArrayType, length } = attribute.uploaded;
    const array = new ArrayType(length);
    gl.bindBuffer(gl.COPY_READ_BUFFER, buffer);
    gl.getBufferSubData(gl.COPY_READ_BUFFER, 0, array);
    gl.bindBuffer(gl.COPY_READ_BUFFER, null);
    return array;
  }

  clear() {
    for (const number of [...this.chunks.keys()]) { this.remove(number); }
  }

  surround(box) {
    this.beside.copy(box);
    this.areBoundsKnown = false;
  }

  /// The bounds of all vertices, in the world, metres; empty when there are none.
  extent() {
    if (!this.areBoundsKnown) {
      this.bounds.copy(this.beside);
      for (const { box } of this.chunks.values()) { this.bounds.union(box); }
      this.areBoundsKnown = true;
    }
    return this.bounds;
  }
}

function geometryOf({ vertexBits, indices, origin, scale }, box, gl) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('vertexBits', onceOnly(new BufferAttribute(vertexBits, 4), gl, gl.ARRAY_BUFFER_BINDING));
  geometry.setIndex(onceOnly(new BufferAttribute(indices, 1), gl, gl.ELEMENT_ARRAY_BUFFER_BINDING));
  // In the chunk's own coordinates, for culling.
  geometry.boundingBox = new Box3(...[box.min, box.max].map((p) => p.clone().sub(new Vector3(...origin)).divideScalar(scale)));
  geometry.boundingSphere = geometry.boundingBox.getBoundingSphere(new Sphere());
  return geometry;
}

/// Frees the main memory's copy once the graphics card has its own: a phone has room for one. The card's can be read: three.js calls back
/// while its buffer is bound.
function onceOnly(attribute, gl, binding) {
  return attribute.onUpload(function letGo() {
    this.uploaded = { buffer: gl.getParameter(binding), ArrayType: this.array.constructor, length: this.array.length };
    this.array = null;
  });
}

function extent({ positions, origin, scale }) {
  const low = [65535, 65535, 65535];
  const high = [0, 0, 0];
  for (let v = 0; v < positions.length; v += 8) {
    for (let axis = 0; axis < 3; ++axis) {
      const q = positions[v + axis];
      if (q < low[axis]) { low[axis] = q; }
      if (q > high[axis]) { high[axis] = q; }
    }
  }
  const corner = (q) => new Vector3(...origin.map((o, axis) => o + scale * q[axis]));
  return new Box3(corner(low), corner(high));
}

// The page's mesh as patches (surface.js), read from the store chunk by chunk: a chunk's box says whether it is needed.

import { boxMeetsBall, boxMeetsPlane, entryOf, firstHit, patchOf, sigmaAt } from './surface.js';

export class MeshSurface {
  /// hello(): the newest hello message.
  constructor(store, hello) {
    Object.assign(this, { store, hello });
    this.held = null;  // patches that were read during hold()
    this.atPlane = (plane) => this.patches((box) => boxMeetsPlane(box, plane));
    this.nearBall = (centre, radius) => this.patches((box) => boxMeetsBall(box, centre, radius));
  }

  get voxelSizeM() { return this.hello()?.voxel_size_m ?? 0; }
  get sizeM() {
    const { min, max } = this.store.extent();
    return max.distanceTo(min);
  }

  /// Reads no chunk twice while `work` runs.
  hold(work) {
    this.held = new Map();
    try {
      return work();
    } finally {
      this.held = null;
    }
  }

  /// Where the ray {origin, direction} meets the mesh first: a pick of measures.js without its pixelM; null where it does not.
  pick(ray, isTwoSided) {
    const chunks = [...this.store.chunks.values()].map((chunk) => ({ chunk, entry: entryOf(ray, arraysOf(chunk.box)) }))
      .filter(({ entry }) => entry < Infinity).sort((a, b) => a.entry - b.entry);
    let best = null, patch = null;
    for (const { chunk, entry } of chunks) {
      if (best && entry > best.t) { break; }
      const candidate = this.patch(chunk);
      const hit = firstHit(candidate, ray, isTwoSided);
      if (hit && hit.t < (best?.t ?? Infinity)) { [best, patch] = [hit, candidate]; }
    }
    if (!best) { return null; }
    const { sigmaM: surfaceM, from } = sigmaAt(patch, best, this.voxelSizeM);
    return { p: best.p, normal: best.normal, surfaceM, from, stepM: patch.stepM };
  }

  *patches(isNeeded) {
    for (const chunk of this.store.chunks.values()) {
      if (isNeeded(arraysOf(chunk.box))) { yield this.patch(chunk); }
    }
  }

  patch(chunk) {
    const known = this.held?.get(chunk);
    if (known) { return known; }
    const patch = patchOf({ ...this.store.read(chunk), voxelSizeM: this.voxelSizeM });
    this.held?.set(chunk, patch);
    return patch;
  }
}

const arraysOf = ({ min, max }) => ({ min: min.toArray(), max: max.toArray() });

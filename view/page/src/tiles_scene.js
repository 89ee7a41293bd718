// A mesh in tiles (3D Tiles): loads those that the picture needs, coarse ones first, within a budget.

import { Box3, Matrix4, Mesh, Object3D } from 'three';
import { TilesRenderer } from '3d-tiles-renderer/three';

/// Of the tiles' geometry; the page and the graphics card each have a copy of it.
export const kTilesBudgetBytes = 160 * 2 ** 20;
/// A tile is replaced by finer ones where its error covers more pixels than this.
const kErrorPx = 1;

export class TilesScene {
  /// `onNews`: called when the picture may change. Tiles are children of `viewer.world`.
  constructor({ viewer, materials, onNews }) {
    Object.assign(this, { viewer, materials, onNews });
    this.tiles = null;
    this.box = new Box3();
    this.problems = 0;        // tiles that did not come
  }

  open(url) {
    if (this.tiles) { return; }  // after a reconnection: what is loaded stays
    const tiles = new TilesRenderer(url);
    tiles.errorTarget = kErrorPx;
    tiles.lruCache.maxBytesSize = kTilesBudgetBytes;
    tiles.lruCache.minBytesSize = 0.75 * kTilesBudgetBytes;
    tiles.setCamera(this.viewer.camera);
    tiles.addEventListener('load-root-tileset', ({ tileset }) => this.place(tileset));
    tiles.addEventListener('load-model', ({ scene }) => this.dress(scene));
    tiles.addEventListener('load-error', () => { ++this.problems; });
    for (const news of ['needs-update', 'load-root-tileset', 'load-model', 'tile-visibility-change', 'tiles-load-end']) {
      tiles.addEventListener(news, this.onNews);
    }
    this.viewer.world.add(tiles.group);
    this.tiles = tiles;
  }

  /// Undoes the place on the Earth, where floats are too coarse, and takes the box.
  place({ root }) {
    if (root.transform) { new Matrix4().fromArray(root.transform).invert().decompose(...placeOf(this.tiles.group)); }
    const [x, y, z, a, , , , b, , , , c] = root.boundingVolume.box;
    this.box.min.set(x - a, y - b, z - c);
    this.box.max.set(x + a, y + b, z + c);
  }

  dress(scene) {
    scene.traverse((object) => {
      if (object instanceof Mesh) { object.material = object.geometry.attributes.color ? this.materials.tile : this.materials.clayTile; }
    });
  }

  /// To be called before each picture.
  prepare() {
    if (!this.tiles) { return; }
    this.tiles.setResolutionFromRenderer(this.viewer.camera, this.viewer.renderer);
    this.tiles.update();
  }

  /// {triangles, tiles, bytes, isSettled}: what is drawn, what is in memory, and whether nothing more is to come for this view.
  get numbers() {
    if (!this.tiles) { return null; }
    let triangles = 0;
    for (const tile of this.tiles.visibleTiles) {
      tile.engineData.scene.traverse((object) => { if (object instanceof Mesh) { triangles += object.geometry.index.count / 3; } });
    }
    const { stats, lruCache } = this.tiles;
    return {
      triangles, tiles: this.tiles.visibleTiles.size, bytes: lruCache.cachedBytes, problems: this.problems,
      isSettled: stats.queued + stats.downloading + stats.parsing === 0 && this.tiles.visibleTiles.size > 0,
    };
  }
}

const placeOf = (group = new Object3D()) => [group.position, group.quaternion, group.scale];

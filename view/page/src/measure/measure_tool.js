// The measuring tool: taps and keys pick points of the surface; when there are enough, their measure is taken.

import { Raycaster, Vector2 } from 'three';
import { note } from '../dialogs.js';
import { measure, pointsFor } from './measures.js';
import { MeasureMarks } from './measure_marks.js';
import { MeasurePanel } from './measure_panel.js';
import { MeshSurface } from './mesh_surface.js';

const kTapPx = { mouse: 5, pen: 8, touch: 12 };  // a pointer that moves farther turns the view
const kMostMs = 700;                             // and one that stays longer does not pick

export class MeasureTool {
  /// hello(): the newest hello message; onToggle(isOpen, hadFocus): called when the panel opens, or closes with the focus in it.
  constructor({ viewer, store, materials, panel, labels, hello, onToggle }) {
    Object.assign(this, { viewer, store, materials, hello, onToggle, element: panel });
    this.kind = 'distance';
    this.plane = 'points';
    this.measures = [];
    this.pending = [];  // picks of the next measure
    this.surface = new MeshSurface(store, hello);
    this.marks = new MeasureMarks(viewer, labels);
    this.panel = new MeasurePanel(panel, {
      mesh: () => `${hello()?.title ?? ''}${this.isPreview ? ' (preview)' : ''}`,
      on: {
        kind: (name) => this.begin({ kind: name }), plane: (name) => this.begin({ plane: name }),
        undo: () => this.undo(), clear: () => this.clear(), close: () => this.close(),
      },
    });
    this.catchTaps(viewer.renderer.domElement);
    document.addEventListener('keydown', (event) => this.key(event));
  }

  get isOpen() { return !this.element.hidden; }
  get isPreview() { return this.hello()?.mode !== 'file'; }

  open() {
    if (this.store.triangles === 0) { return false; }
    this.element.hidden = false;
    this.onToggle(true);
    this.show();
    return true;
  }

  /// The measures stay, and are there again when the tool is opened.
  close() {
    const hadFocus = this.element.contains(document.activeElement);
    this.element.hidden = true;
    this.pending = [];
    this.onToggle(false, hadFocus);
    this.show();
  }

  begin({ kind = this.kind, plane = this.plane }) {
    Object.assign(this, { kind, plane, pending: [] });
    this.show();
  }

  undo() {
    if (this.pending.length > 0) {
      this.pending.pop();
    } else {
      this.measures.pop();
    }
    this.show();
  }

  clear() {
    Object.assign(this, { measures: [], pending: [] });
    this.show();
  }

  /// The mesh has begun anew, in another world.
  forget() {
    if (this.measures.length > 0) { note('The mesh began anew: its measures are gone.'); }
    this.clear();
  }

  /// `fresh`: the measure that was just taken.
  show({ fresh = null } = {}) {
    this.marks.show(this.isOpen ? this.measures : [], this.pending);
    this.panel.show({
      kind: this.kind, measures: [...this.measures], picked: this.pending.length, fresh,
      isPreview: this.isPreview, voxelSizeM: this.surface.voxelSizeM,
    });
  }

  catchTaps(canvas) {
    let tap = null;   // {x, y, at, id} of the only finger or button that is down
    let down = 0;
    canvas.addEventListener('pointerdown', (event) => {
      tap = ++down === 1 && event.button === 0 ? { x: event.offsetX, y: event.offsetY, at: event.timeStamp, id: event.pointerId } : null;
    });
    canvas.addEventListener('pointermove', (event) => {
      if (tap && Math.hypot(event.offsetX - tap.x, event.offsetY - tap.y) > (kTapPx[event.pointerType] ?? kTapPx.mouse)) { tap = null; }
    });
    canvas.addEventListener('pointerup', (event) => {
      down = Math.max(down - 1, 0);
      if (tap && tap.id === event.pointerId && this.isOpen && event.timeStamp - tap.at < kMostMs) { this.pickAt(tap.x, tap.y); }
      tap = null;
    });
    canvas.addEventListener('pointercancel', () => {
      down = Math.max(down - 1, 0);
      tap = null;
    });
  }

  key(event) {
    if (!this.isOpen || document.querySelector('dialog[open]')) { return; }
    const canvas = this.viewer.renderer.domElement;
    const isOnCanvas = document.activeElement === canvas;
    if (event.key === 'Escape') {
      if (this.pending.length > 0) { this.begin({}); } else { this.close(); }
    } else if (event.key === 'z' && (event.ctrlKey || event.metaKey) || (isOnCanvas && event.key === 'Backspace')) {
      this.undo();
    } else if (isOnCanvas && (event.key === 'Enter' || event.key === ' ')) {
      this.pickAt(canvas.clientWidth / 2, canvas.clientHeight / 2);
    } else {
      return;
    }
    event.preventDefault();
  }

  /// x, y: CSS pixels from the canvas' upper left.
  pickAt(x, y) {
    const { camera, renderer, T_scan_shown: T } = this.viewer;
    const { clientWidth: width, clientHeight: height } = renderer.domElement;
    const caster = new Raycaster();
    camera.updateMatrixWorld();
    caster.setFromCamera(new Vector2((2 * x) / width - 1, 1 - (2 * y) / height), camera);
    const ray = caster.ray.applyMatrix4(T);
    const pick = this.surface.pick({ origin: ray.origin.toArray(), direction: ray.direction.toArray() }, this.materials.areBacksShown);
    if (!pick) {
      this.panel.say('There is no surface there. Pick a point of the mesh.');
      return;
    }
    const away = Math.hypot(...pick.p.map((value, axis) => value - ray.origin.getComponent(axis)));
    this.take({ ...pick, pixelM: (2 * away * Math.tan((camera.fov * Math.PI) / 360)) / height });
  }

  take(pick) {
    this.pending.push(pick);
    if (this.pending.length < pointsFor(this.kind, this.plane)) {
      this.show();
      return;
    }
    const picks = this.pending;
    this.pending = [];
    const result = this.surface.hold(() => measure(this.kind, picks, this.surface, this.plane));
    if (result.problem) {
      this.show();
      this.panel.say(result.problem);
      return;
    }
    this.measures.push(result);
    this.show({ fresh: result });
  }
}

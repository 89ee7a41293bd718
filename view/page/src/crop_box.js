// The crop box. Six sliders, and six handles in the picture, move the sides of a box along the scan's axes.

import {
  Box3, Box3Helper, BufferGeometry, Float32BufferAttribute, Group, Points, PointsMaterial, Raycaster, Vector2, Vector3,
} from 'three';
import { disc } from './disc.js';
import { length } from './quantities.js';

const kAxes = ['X', 'Y', 'Z'];
const kRoom = 0.08;     // how far sliders go beyond the mesh: share of its extent
const kSteps = 400;     // positions of a slider
const kReachPx = 26;    // a pointer within this distance takes a handle
const kHandlePx = [9, 20];  // size range; small in a small picture, which large handles would hide
const kHandleShare = 0.05;  // size as a share of the picture
const kDrafted = 0xffd166;
const kInForce = 0x94a3b8;

export class CropBox {
  /// onToggle(isOpen): called when the panel opens or closes.
  constructor({ viewer, materials, panel, rows, extent, onToggle }) {
    Object.assign(this, { viewer, materials, panel, extent, onToggle });
    this.inForce = null;   // Box3 from the program, or null
    this.draft = null;     // Box3 while the panel is open
    this.held = null;      // the side whose handle is being dragged
    this.range = new Box3();
    this.sides = kAxes.flatMap((name, axis) => ['min', 'max'].map((end) => ({ name, axis, end })));
    rows.append(...kAxes.map((name, axis) => this.row(name, axis)));
    this.group = new Group();
    this.group.visible = false;
    this.outline = new Box3Helper(new Box3(), kDrafted);
    this.handles = new Points(new BufferGeometry(),
      new PointsMaterial({
        color: kDrafted, map: disc(), size: 20, sizeAttenuation: false, depthTest: false, transparent: true,
      }));
    this.handles.frustumCulled = false;
    this.handles.geometry.setAttribute('position', new Float32BufferAttribute(new Float32Array(18), 3));
    this.group.add(this.outline, this.handles);
    viewer.world.add(this.group);
    viewer.beforeDraw.push(() => this.sizeHandles(viewer.renderer.domElement));
    this.catchHandles(viewer.renderer.domElement);
  }

  sizeHandles({ clientWidth: width, clientHeight: height }) {
    const [least, most] = kHandlePx;
    this.handles.material.size = Math.min(Math.max(kHandleShare * Math.min(width, height), least), most);
  }

  row(name, axis) {
    const row = document.createElement('div');
    row.className = 'crop-row';
    const label = document.createElement('span');
    label.textContent = name;
    row.append(label, ...['min', 'max'].map((end) => this.slider(name, axis, end)));
    return row;
  }

  slider(name, axis, end) {
    const label = document.createElement('label');
    const input = document.createElement('input');
    const value = document.createElement('output');
    Object.assign(input, { type: 'range', min: 0, max: kSteps, step: 1 });
    input.setAttribute('aria-label', `${name} ${end === 'min' ? 'from' : 'to'}`);
    input.addEventListener('input', () => {
      const low = this.range.min.getComponent(axis);
      const width = this.range.max.getComponent(axis) - low;
      this.moveSide(axis, end, low + (width * Number(input.value)) / kSteps);
    });
    label.append(input, value);
    Object.assign(this.sides.find((side) => side.axis === axis && side.end === end), { input, value });
    return label;
  }

  get isOpen() { return this.draft !== null; }

  open() {
    const mesh = this.extent();
    if (mesh.isEmpty()) { return false; }
    this.range = mesh.clone().expandByVector(mesh.getSize(new Vector3()).multiplyScalar(kRoom));
    if (this.inForce) { this.range.union(this.inForce); }
    this.draft = (this.inForce ?? this.range).clone();
    this.panel.hidden = false;
    this.onToggle(true);
    this.show();
    return true;
  }

  close() {
    this.draft = null;
    this.held = null;
    this.panel.hidden = true;
    this.onToggle(false);
    this.show();
  }

  setInForce(box) {
    this.inForce = box && new Box3(new Vector3(...box[0]), new Vector3(...box[1]));
    this.show();
  }

  /// A side never passes the opposite one.
  moveSide(axis, end, value) {
    const gap = (this.range.max.getComponent(axis) - this.range.min.getComponent(axis)) / kSteps;
    const isLow = end === 'min';
    const other = (isLow ? this.draft.max : this.draft.min).getComponent(axis);
    const inRange = Math.min(Math.max(value, this.range.min.getComponent(axis)), this.range.max.getComponent(axis));
    this.draft[end].setComponent(axis, isLow ? Math.min(inRange, other - gap) : Math.max(inRange, other + gap));
    this.show();
  }

  show() {
    const box = this.draft ?? this.inForce;
    this.materials.crop = this.draft ?? this.inForce;
    this.group.visible = box !== null;
    this.handles.visible = this.isOpen;
    if (box) {
      this.outline.box.copy(box);
      this.outline.material.color.setHex(this.isOpen ? kDrafted : kInForce);
    }
    if (this.isOpen) { this.showSides(); }
    this.viewer.redraw();
  }

  showSides() {
    const position = this.handles.geometry.attributes.position;
    this.sides.forEach(({ axis, end, input, value }, i) => {
      const at = this.draft[end].getComponent(axis);
      const low = this.range.min.getComponent(axis);
      input.value = Math.round((kSteps * (at - low)) / (this.range.max.getComponent(axis) - low));
      value.textContent = length(at);
      input.setAttribute('aria-valuetext', length(at));
      const centre = this.draft.getCenter(new Vector3()).setComponent(axis, at);
      position.setXYZ(i, ...centre);
    });
    position.needsUpdate = true;
  }

  catchHandles(canvas) {
    canvas.addEventListener('pointerdown', (event) => {
      this.held = this.isOpen ? this.sideAt(event, canvas) : null;
      if (!this.held) { return; }
      event.stopImmediatePropagation();
      canvas.setPointerCapture(event.pointerId);
    }, { capture: true });
    canvas.addEventListener('pointermove', (event) => {
      if (!this.held) { return; }
      event.stopImmediatePropagation();
      this.dragSide(this.held, event, canvas);
    }, { capture: true });
    for (const end of ['pointerup', 'pointercancel']) { canvas.addEventListener(end, () => { this.held = null; }, { capture: true }); }
  }

  sideAt(event, canvas) {
    const position = this.handles.geometry.attributes.position;
    let best = null;
    let bestPx = kReachPx;
    this.sides.forEach((side, i) => {
      const p = this.viewer.toShown(new Vector3().fromBufferAttribute(position, i)).project(this.viewer.camera);
      const px = Math.hypot(((p.x + 1) / 2) * canvas.clientWidth - event.offsetX, ((1 - p.y) / 2) * canvas.clientHeight - event.offsetY);
      if (p.z < 1 && px < bestPx) { [best, bestPx] = [side, px]; }
    });
    return best;
  }

  /// Moves the side to the point of its axis that is nearest to the ray under the pointer.
  dragSide({ axis, end }, event, canvas) {
    const pointer = new Vector2((2 * event.offsetX) / canvas.clientWidth - 1, 1 - (2 * event.offsetY) / canvas.clientHeight);
    const caster = new Raycaster();
    caster.setFromCamera(pointer, this.viewer.camera);
    const ray = caster.ray.applyMatrix4(this.viewer.T_scan_shown);
    const along = new Vector3().setComponent(axis, 1);
    const arm = ray.origin.clone().sub(this.draft.getCenter(new Vector3()).setComponent(axis, 0));
    const cosine = along.dot(ray.direction);
    const denominator = 1 - cosine * cosine;
    if (denominator < 1e-3) { return; }  // the view is along the axis: the point is undefined
    this.moveSide(axis, end, (along.dot(arm) - cosine * ray.direction.dot(arm)) / denominator);
  }
}

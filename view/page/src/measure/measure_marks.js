// What is measured, drawn into the picture: points, lines and numbers.

import { BufferGeometry, Float32BufferAttribute, Group, Points, PointsMaterial, Vector3 } from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { disc } from '../disc.js';

const kDone = 0xffd166;
const kPointPx = 13;

export class MeasureMarks {
  /// `labels`: an element over the canvas.
  constructor(viewer, labels) {
    Object.assign(this, { viewer, labels });
    this.group = new Group();
    viewer.world.add(this.group);
    const ink = { depthTest: false, transparent: true };  // also what is behind the surface is seen
    this.line = new LineMaterial({ color: kDone, linewidth: 3, ...ink });
    this.point = new PointsMaterial({ color: kDone, map: disc(), size: kPointPx, sizeAttenuation: false, ...ink });
    this.places = [];  // of the numbers
    viewer.beforeDraw.push(() => this.placeLabels());
  }

  /// `pending`: picks of a measure that is not complete yet.
  show(measures, pending) {
    for (const child of this.group.children) { child.geometry.dispose(); }
    this.group.clear();
    this.places = [];
    measures.forEach((one, i) => this.add(one.lines, one.picks, String(i + 1)));
    this.add(pending.length > 1 ? [pending.map(({ p }) => p)] : [], pending, '');
    this.labels.replaceChildren(...this.places.map(({ text }) => Object.assign(document.createElement('span'), { textContent: text })));
    this.viewer.redraw();
  }

  add(lines, picks, text) {
    if (picks.length === 0) { return; }
    const segments = lines.flatMap((line) => line.slice(1).flatMap((p, i) => [...line[i], ...p]));
    if (segments.length > 0) { this.group.add(drawn(new LineSegments2(new LineSegmentsGeometry().setPositions(segments), this.line))); }
    const geometry = new BufferGeometry().setAttribute('position', new Float32BufferAttribute(picks.flatMap(({ p }) => p), 3));
    this.group.add(drawn(new Points(geometry, this.point)));
    if (text === '') { return; }
    const middle = picks.reduce((sum, { p }) => sum.add(new Vector3(...p)), new Vector3()).divideScalar(picks.length);
    this.places.push({ text, p: middle });
  }

  placeLabels() {
    const { clientWidth: width, clientHeight: height } = this.viewer.renderer.domElement;
    this.places.forEach(({ p }, i) => {
      const seen = this.viewer.toShown(p).project(this.viewer.camera);
      const label = this.labels.children[i];
      label.hidden = seen.z > 1;
      label.style.transform = `translate(${(((seen.x + 1) / 2) * width).toFixed(1)}px, ${(((1 - seen.y) / 2) * height).toFixed(1)}px)`;
    });
  }
}

function drawn(object) {
  object.frustumCulled = false;
  object.renderOrder = 1;
  return object;
}

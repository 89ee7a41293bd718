// Draws the scanner as a small pyramid, and its past positions as a line.

import { Group, Matrix4, Vector3 } from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';

const kMostPoints = 2000;
const kFirstSpacingM = 0.002;
const kGood = 0x5eead4;
const kLost = 0xff6b6b;
const kTrail = 0x7dd3fc;

export class ScannerPath {
  constructor(group) {
    this.group = new Group();
    group.add(this.group);
    this.points = [];          // Vector3, in the scan's world
    this.T = null;             // Matrix4 T_world_camera, the newest
    this.isLost = false;
    this.half = [0.5, 0.4];
    this.spacingM = kFirstSpacingM;  // skips positions nearer than this to the last one
    this.isTrailDrawn = true;  // the line has all points
    this.trail = new Line2(new LineGeometry(), new LineMaterial({ color: kTrail, linewidth: 1.8, transparent: true, opacity: 0.5 }));
    this.trail.frustumCulled = false;
    this.trail.visible = false;
    this.pyramid = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ color: kGood, linewidth: 2.5 }));
    this.pyramid.frustumCulled = false;
    this.pyramid.matrixAutoUpdate = false;
    this.pyramid.visible = false;
    this.pyramidKey = '';
    this.group.add(this.trail, this.pyramid);
  }

  setTrail(points) {
    this.points = points.map((p) => new Vector3(...p));
    this.isTrailDrawn = false;
    if (points.length === 0) {
      this.spacingM = kFirstSpacingM;
      this.T = null;
      this.pyramid.visible = false;
    }
  }

  setPose({ T, half, is_lost: isLost }) {
    this.T = new Matrix4().fromArray(T);
    this.half = half;
    this.isLost = isLost;
    if (isLost) { return; }
    const p = new Vector3().setFromMatrixPosition(this.T);
    const last = this.points[this.points.length - 1];
    if (last && last.distanceTo(p) < this.spacingM) { return; }
    this.points.push(p);
    this.isTrailDrawn = false;
    if (this.points.length > kMostPoints) {
      this.points = this.points.filter((_, i) => i % 2 === 0);
      this.spacingM *= 2;
    }
  }

  get position() { return this.T && new Vector3().setFromMatrixPosition(this.T); }

  /// To be called before each picture. `sizeM`: the pyramid's length.
  prepare(sizeM) {
    if (!this.isTrailDrawn) { this.drawTrail(); }
    if (!this.T) { return; }
    const key = `${this.half} ${sizeM}`;
    if (key !== this.pyramidKey) {
      this.pyramidKey = key;
      this.pyramid.geometry.dispose();
      this.pyramid.geometry = new LineSegmentsGeometry().setPositions(pyramidLines(this.half, sizeM));
    }
    this.pyramid.material.color.setHex(this.isLost ? kLost : kGood);
    this.pyramid.matrix.copy(this.T);
    this.pyramid.visible = true;
  }

  drawTrail() {
    this.isTrailDrawn = true;
    this.trail.visible = this.points.length > 1;
    if (!this.trail.visible) { return; }
    this.trail.geometry.dispose();
    this.trail.geometry = new LineGeometry().setPositions(this.points.flatMap((p) => [p.x, p.y, p.z]));
  }
}

/// Camera axes: x right, y down, z forward; a roof on the picture's upper edge tells which way is up.
function pyramidLines([halfX, halfY], length) {
  const [x, y, z] = [halfX * length, halfY * length, length];
  const eye = [0, 0, 0];
  const corners = [[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]];
  const roof = [0, -1.45 * y, z];
  const lines = [];
  corners.forEach((corner, i) => lines.push(eye, corner, corner, corners[(i + 1) % 4]));
  lines.push([-0.4 * x, -y, z], roof, roof, [0.4 * x, -y, z]);
  return lines.flat();
}

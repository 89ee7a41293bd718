// The three.js scene. Draws only when something has changed. The scan's up direction is up on the screen.

import {
  Group, Matrix3, Matrix4, PerspectiveCamera, Quaternion, Scene, Sphere, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

const kFieldOfViewDeg = 45;
const kUp = new Vector3(0, 1, 0);
/// The first viewing direction, from the mesh to the viewer.
const kFirstSide = new Vector3(0.55, 0.45, 1).normalize();
const kKeyTurnRad = Math.PI / 24;
/// Least distance of the target in front of a followed scanner.
const kNearestFollowedM = 0.2;
const kFarthestFollowedM = 3;
/// Largest distance of a followed scanner's view: times the distance from which the mesh fills the picture.
const kFollowedRoom = 1.3;
/// Time between two pictures without user input. It is longer if drawing takes longer, to leave time for messages.
const kNewsGapMs = 80;

export class Viewer {
  /// isTest: pixels can be read back, no antialiasing, and views change at once. Throws without WebGL 2.
  constructor(canvas, { isTest }) {
    this.renderer = new WebGLRenderer({
      canvas, antialias: !isTest && devicePixelRatio < 2, alpha: true, preserveDrawingBuffer: isTest, powerPreference: 'low-power',
    });
    this.renderer.setPixelRatio(isTest ? 1 : Math.min(devicePixelRatio, 2));
    this.isQuick = isTest || matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.camera = new PerspectiveCamera(kFieldOfViewDeg, 1, 0.01, 100);
    this.camera.position.copy(kFirstSide);
    this.scene = new Scene();
    this.world = new Group();  // the scan's own axes
    this.scene.add(this.world);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = !this.isQuick;
    this.controls.dampingFactor = 0.12;
    this.controls.addEventListener('change', () => this.redraw());
    this.controls.addEventListener('start', () => this.touched());
    this.beforeDraw = [];      // functions called before each picture, with this viewer
    this.onTouched = () => {};
    this.drawn = 0;            // pictures drawn so far
    this.scheduled = 0;        // the animation frame that will draw; 0: none
    this.newsTimer = 0;
    this.drawnAt = 0;
    this.pictureMs = 0;        // duration of the last picture, until the browser was idle again
    this.goal = null;          // {eye, target} the view glides to
    canvas.addEventListener('keydown', (event) => this.key(event));
    new ResizeObserver(() => this.resize(canvas)).observe(canvas);
    this.resize(canvas);
  }

  /// `up`: unit, in the scan's world.
  set up(up) {
    this.world.quaternion.setFromUnitVectors(new Vector3(...up).normalize(), kUp);
    this.world.updateMatrixWorld();
    this.redraw();
  }

  get T_scan_shown() { return this.world.matrixWorld.clone().invert(); }
  get T_eye_scan() { return new Matrix4().multiplyMatrices(this.camera.matrixWorldInverse, this.world.matrixWorld); }
  get R_eye_scan() { return new Matrix3().setFromMatrix4(this.T_eye_scan); }
  toShown(p_scan) { return p_scan.clone().applyMatrix4(this.world.matrixWorld); }

  resize(canvas) {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (width === 0 || height === 0) { return; }
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.onResized?.();
    this.draw();  // at once, because a resized canvas is empty
  }

  redraw() {
    if (this.scheduled === 0) { this.scheduled = requestAnimationFrame(() => this.frame()); }
  }

  /// Draws soon: new data has arrived.
  redrawSoon() {
    if (this.scheduled !== 0 || this.newsTimer !== 0) { return; }
    const wait = Math.max(kNewsGapMs, this.pictureMs) - (performance.now() - this.drawnAt);
    this.newsTimer = setTimeout(() => {
      this.newsTimer = 0;
      this.redraw();
    }, Math.max(0, wait));
  }

  frame() {
    this.scheduled = 0;
    const begun = performance.now();
    if (this.goal) { this.glide(); }
    this.controls.update();  // requests the next picture itself while it is moving
    this.draw();
    requestAnimationFrame(() => {
      this.drawnAt = performance.now();
      this.pictureMs = this.drawnAt - begun;
    });
  }

  draw() {
    this.camera.updateMatrixWorld();
    for (const prepare of this.beforeDraw) { prepare(this); }
    this.renderer.render(this.scene, this.camera);
    ++this.drawn;
  }

  /// Moves the view to `eye` and `target`, in the axes of the display (up is +y), metres.
  moveTo(eye, target) {
    this.goal = { eye: eye.clone(), target: target.clone() };
    if (this.isQuick) {
      this.camera.position.copy(eye);
      this.controls.target.copy(target);
      this.goal = null;
    }
    this.redraw();
  }

  glide() {
    const { eye, target } = this.goal;
    this.camera.position.lerp(eye, 0.14);
    this.controls.target.lerp(target, 0.14);
    const left = this.camera.position.distanceTo(eye) + this.controls.target.distanceTo(target);
    if (left < 0.003 * eye.distanceTo(target)) { this.goal = null; } else { this.redraw(); }
  }

  touched() {
    this.goal = null;
    this.onTouched();
  }

  /// Shows a whole box of the scan, from the current viewing direction.
  fit(box, { from = null } = {}) {
    if (box.isEmpty()) { return; }
    const { center, radius } = box.getBoundingSphere(new Sphere());
    const target = this.toShown(center);
    const { eye, target: seen } = this.goal ?? { eye: this.camera.position, target: this.controls.target };
    const side = from ?? eye.clone().sub(seen).normalize();
    const distance = this.distanceTo(radius);
    this.setReach(radius, distance);
    this.moveTo(target.clone().addScaledVector(side, distance), target);
  }

  /// The distance from which a sphere fills the picture.
  distanceTo(radius) {
    const half = Math.tan((kFieldOfViewDeg * Math.PI) / 360) * Math.min(1, this.camera.aspect);
    return (1.08 * radius) / Math.sin(Math.atan(half));
  }

  /// Sets the near and far planes for a scene of that radius.
  setReach(radius, distance) {
    this.camera.near = Math.max(0.002 * radius, 1e-4);
    this.camera.far = 60 * radius + 4 * distance;
    this.camera.updateProjectionMatrix();
    this.controls.minDistance = 0.05 * radius;
    this.controls.maxDistance = 20 * radius;
  }

  /// The first viewing direction for a scanner at p_scan and a box: from the scanner's side, a little above.
  sideOf(p_scan, box) {
    const side = this.toShown(p_scan).sub(this.toShown(box.getCenter(new Vector3())));
    if (side.lengthSq() === 0) { return kFirstSide.clone(); }
    side.normalize();
    side.y = Math.max(side.y, 0.35);
    return side.normalize();
  }

  /// Looks from behind a scanner with the pose T_scan_scanner in its direction, at the distance of the box's centre. Moves nearer than the
  /// scanner if the box would be too small in the picture.
  followPose(T_scan_scanner, box) {
    const { center, radius } = box.getBoundingSphere(new Sphere());
    const toCentre = new Vector3().setFromMatrixPosition(T_scan_scanner).distanceTo(center);
    const distance = Math.min(Math.max(toCentre, kNearestFollowedM), kFarthestFollowedM);
    const shown = new Matrix4().multiplyMatrices(this.world.matrixWorld, T_scan_scanner);
    const right = new Vector3(), down = new Vector3(), ahead = new Vector3(), eye = new Vector3();
    shown.extractBasis(right, down, ahead);
    eye.setFromMatrixPosition(shown);
    const target = eye.clone().addScaledVector(ahead, distance);
    eye.addScaledVector(ahead, -0.7 * distance).addScaledVector(kUp, 0.3 * distance);
    const arm = eye.clone().sub(target);
    eye.copy(target).add(arm.setLength(Math.min(arm.length(), kFollowedRoom * this.distanceTo(radius))));
    this.setReach(distance, distance);
    this.moveTo(eye, target);
  }

  /// For tests: sets the view from `eye` to `target`, both in the scan's world.
  look(eye, target) {
    this.goal = null;
    this.onTouched();
    const [p, t] = [eye, target].map((point) => this.toShown(new Vector3(...point)));
    this.setReach(p.distanceTo(t), p.distanceTo(t));
    this.camera.position.copy(p);
    this.controls.target.copy(t);
    this.controls.update();
    this.draw();
  }

  key(event) {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const zoom = { '+': 0.9, '=': 0.9, '-': 1 / 0.9 }[event.key];
    if (event.key.toLowerCase() === 'f') { this.onFit?.(); }
    if (!turn && !zoom) { return; }
    event.preventDefault();
    this.touched();
    const arm = this.camera.position.clone().sub(this.controls.target);
    if (zoom) { arm.multiplyScalar(zoom); }
    if (turn) {
      arm.applyQuaternion(new Quaternion().setFromAxisAngle(kUp, -turn[0] * kKeyTurnRad));
      const across = new Vector3().crossVectors(kUp, arm).normalize();
      const tilted = arm.clone().applyQuaternion(new Quaternion().setFromAxisAngle(across, turn[1] * kKeyTurnRad));
      if (tilted.angleTo(kUp) > 0.1 && tilted.angleTo(kUp) < Math.PI - 0.1) { arm.copy(tilted); }
    }
    this.camera.position.copy(this.controls.target).add(arm);
    this.redraw();
  }
}

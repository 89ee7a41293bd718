// Moves the view until the user does: shows the whole growing mesh, or follows the scanner.

import { Vector3 } from 'three';

/// The view moves when the mesh exceeds the picture by this share of its extent.
const kSlack = 0.06;

export class ViewKeeper {
  constructor(viewer, store, path) {
    Object.assign(this, { viewer, store, path });
    this.isFitting = true;
    this.isFollowing = null;   // null: the user has not chosen yet
    this.fitted = null;        // the box to which the view was fitted last
    this.hasFitted = false;    // true after the first fit: then the viewing direction is kept
    this.followed = null;      // the pose to which the view was moved last
    this.onChange = () => {};
    viewer.onTouched = () => this.set({ isFitting: false, isFollowing: false });
    viewer.onFit = () => this.fit();
    viewer.onResized = () => { this.fitted = null; };
  }

  set({ isFitting = this.isFitting, isFollowing = this.isFollowing }) {
    Object.assign(this, { isFitting, isFollowing, followed: null });
    this.onChange();
    this.viewer.redraw();
  }

  fit() {
    this.fitted = null;
    this.set({ isFitting: true, isFollowing: false });
  }

  /// To be called before each picture.
  keep() {
    const box = this.store.extent();
    if (box.isEmpty()) {
      this.fitted = null;
      return;
    }
    if (this.isFollowing && this.path.T) { this.follow(box); } else if (this.isFitting) { this.fitIfNeeded(box); }
  }

  follow(box) {
    if (this.followed === this.path.T || this.path.isLost) { return; }
    this.followed = this.path.T;
    this.viewer.followPose(this.path.T, box);
  }

  fitIfNeeded(box) {
    if (this.fitted && isNear(this.fitted, box)) { return; }
    const from = this.hasFitted || !this.path.position ? null : this.viewer.sideOf(this.path.position, box);
    this.hasFitted = true;
    this.fitted = box.clone();
    this.viewer.fit(box, { from });
  }
}

function isNear(a, b) {
  const slack = kSlack * a.getSize(new Vector3()).length();
  return a.min.distanceTo(b.min) < slack && a.max.distanceTo(b.max) < slack;
}

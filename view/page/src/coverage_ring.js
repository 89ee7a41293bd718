// The sides from which the scanner has seen the object: 36 sectors of the azimuth round the mesh's centre, about up.

import { Vector3 } from 'three';

export const kSectors = 36;
const kSectorRad = (2 * Math.PI) / kSectors;
/// Two successive positions nearer than this also count the sectors between them.
const kPassingRad = Math.PI / 6;

export class CoverageRing {
  constructor() {
    this.seen = new Uint8Array(kSectors);
    this.scannerRad = null;  // azimuth of the newest position
    this.setFrame(new Vector3(), new Vector3(0, 1, 0));
  }

  /// Sectors are counted from a fixed direction across `up`, in the right-handed sense about it.
  setFrame(centre, up) {
    this.centre = centre.clone();
    const helper = Math.abs(up.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 0, 1);
    this.east = helper.clone().addScaledVector(up, -helper.dot(up)).normalize();
    this.north = new Vector3().crossVectors(up, this.east);
  }

  azimuth(p) {
    const arm = p.clone().sub(this.centre);
    return Math.atan2(arm.dot(this.north), arm.dot(this.east));
  }

  /// Counts again from all positions, because the centre moves while the mesh grows.
  count(points) {
    this.seen.fill(0);
    this.scannerRad = null;
    for (const p of points) {
      const to = this.azimuth(p);
      const step = this.scannerRad === null ? 0 : Math.atan2(Math.sin(to - this.scannerRad), Math.cos(to - this.scannerRad));
      const pieces = Math.abs(step) < kPassingRad ? Math.ceil(Math.abs(step) / kSectorRad) : 0;
      for (let i = 0; i <= pieces; ++i) { this.seen[sector(to - (pieces === 0 ? 0 : (step * i) / pieces))] = 1; }
      this.scannerRad = to;
    }
  }

  get seenCount() { return this.seen.reduce((sum, one) => sum + one, 0); }
}

function sector(azimuth) {
  return Math.floor(((azimuth / kSectorRad) % kSectors + kSectors) % kSectors) % kSectors;
}

const kSvg = 'http://www.w3.org/2000/svg';
const kOuter = 46, kInner = 33, kGapRad = 0.025;

/// Draws a ring into the SVG of index.html, as seen from above with the viewer at the bottom.
export class RingPicture {
  constructor(figure) {
    this.figure = figure;
    this.sectors = figure.querySelector('#ring-sectors');
    this.text = figure.querySelector('#ring-text');
    this.scanner = figure.querySelector('#ring-scanner');
    for (let i = 0; i < kSectors; ++i) {
      const path = document.createElementNS(kSvg, 'path');
      path.setAttribute('d', sectorPath(i * kSectorRad + kGapRad, (i + 1) * kSectorRad - kGapRad));
      this.sectors.append(path);
    }
    const dot = document.createElementNS(kSvg, 'path');
    dot.setAttribute('d', 'M27 0 L19 5.500 L19 -5.500 Z');
    this.scanner.append(dot);
  }

  /// viewerRad: the azimuth from which the person at the page looks.
  draw(ring, viewerRad) {
    [...this.sectors.children].forEach((path, i) => path.classList.toggle('seen', ring.seen[i] === 1));
    // SVG turns clockwise for positive angles: an azimuth a is drawn at -a, the viewer's at 90 degrees (below).
    const turn = (viewerRad * 180) / Math.PI + 90;
    this.sectors.setAttribute('transform', `rotate(${turn})`);
    this.scanner.setAttribute('transform', `rotate(${turn - ((ring.scannerRad ?? 0) * 180) / Math.PI})`);
    this.scanner.classList.toggle('absent', ring.scannerRad === null);
    const words = `${ring.seenCount} of ${kSectors} sides seen`;
    if (this.text.textContent !== words) { this.text.textContent = words; }
  }
}

function sectorPath(from, to) {
  const at = (radius, angle) => `${(radius * Math.cos(angle)).toFixed(3)} ${(-radius * Math.sin(angle)).toFixed(3)}`;
  return `M${at(kOuter, from)} A${kOuter} ${kOuter} 0 0 0 ${at(kOuter, to)} L${at(kInner, to)} `
    + `A${kInner} ${kInner} 0 0 1 ${at(kInner, from)} Z`;
}

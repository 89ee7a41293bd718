// Shows the newest state in numbers: frame rate, frames, losses, triangles.

import { Vector3 } from 'three';
import { count, extent, many } from './quantities.js';

const put = (id, text) => {
  const element = document.getElementById(id);
  if (element.textContent !== text) { element.textContent = text; }
};

/// `bounds`: of the mesh; null without WebGL. `isOpen` false: the connection is lost, so the frame rate is unknown.
export function showNumbers(state, hello, bounds, isOpen) {
  put('fps', isOpen && state.phase === 'scanning' ? `${state.fps.toFixed(state.fps < 9.95 ? 1 : 0)} /s` : '–');
  put('frames', state.frames_total > 0 ? `${count(state.frame)} / ${count(state.frames_total)}` : count(state.frame));
  const losses = state.lost + state.dropped;
  put('losses', count(losses));
  put('losses-by-kind', losses === 0 ? '' : `${count(state.lost)} lost, ${count(state.dropped)} dropped`);
  document.getElementById('losses').classList.toggle('some', losses > 0);
  const stream = streamLosses(state.losses);
  put('stream-losses', stream);
  document.getElementById('stream').hidden = stream === '';
  put('triangles', many(state.triangles) + (state.is_behind ? ' …' : ''));  // the mesh is not complete yet
  put('extent', !bounds || bounds.isEmpty() ? '–' : extent(bounds.getSize(new Vector3()).toArray()));
  put('volume', [hello?.voxel_size_m > 0 ? `${(1000 * hello.voxel_size_m).toFixed(1)} mm` : '', `${count(state.memory_mib)} MiB`]
    .filter(Boolean).join(', '));
  showProgress(state);
}

/// Texts for lost pictures, by where they were lost; docs/devices.md explains them.
const kWhere = {
  device: 'by the camera', transport: 'on the way', overflow: 'too large', queue: 'not taken in time', writer: 'not recorded',
};

function streamLosses(losses = {}) {
  return Object.entries(losses).filter(([, n]) => n > 0).map(([where, n]) => `${count(n)} ${kWhere[where] ?? where}`).join(', ');
}

function showProgress({ frame, frames_total: total, phase }) {
  const bar = document.getElementById('progress');
  bar.hidden = !(total > 0) || phase === 'finished' || phase === 'failed';
  if (bar.hidden) { return; }
  const percent = Math.min(100, (100 * frame) / total);
  bar.setAttribute('aria-valuenow', percent.toFixed(0));
  bar.firstElementChild.style.transform = `scaleX(${percent / 100})`;
}

// The list of files that can be downloaded.

import { bytes } from './quantities.js';

const kMeaning = {
  glb: 'for Blender, phones and the web', stl: 'for printing', ply: 'for MeshLab, CloudCompare', obj: 'for nearly everything',
  json: 'report', png: 'picture', txt: 'trajectory', vdb: 'volume', mcap: 'recording',
};

export class FilesPanel {
  constructor({ panel, list, open, close, count }) {
    this.panel = panel;
    this.list = list;
    this.openButton = open;
    this.count = count;
    this.files = [];
    this.showsNext = false;    // open the panel when the next list comes
    open.addEventListener('click', () => this.show(this.panel.hidden));
    close.addEventListener('click', () => {
      this.show(false);
      open.focus();
    });
  }

  show(isShown) {
    this.panel.hidden = !isShown || this.files.length === 0;
    this.openButton.setAttribute('aria-expanded', String(!this.panel.hidden));
  }

  set(files) {
    this.files = files;
    this.openButton.hidden = files.length === 0;
    this.count.textContent = files.length;
    this.list.replaceChildren(...files.map(item));
    if (files.length === 0 || this.showsNext) { this.show(this.showsNext); }
    if (files.length > 0) { this.showsNext = false; }
  }

  showNext() { this.showsNext = true; }

  /// Disables the downloads while the program cannot be reached.
  setReachable(isReachable) {
    this.openButton.disabled = !isReachable;
    if (!isReachable) { this.show(false); }
  }
}

function item({ name, bytes: size }) {
  const link = document.createElement('a');
  link.href = `files/${encodeURIComponent(name)}`;
  link.download = name;
  const title = document.createElement('b');
  title.textContent = name;
  const about = document.createElement('span');
  about.textContent = [bytes(size), kMeaning[name.split('.').pop().toLowerCase()]].filter(Boolean).join(' · ');
  link.append(title, about);
  const row = document.createElement('li');
  row.append(link);
  return row;
}

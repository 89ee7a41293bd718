// The panel of the measuring tool: kinds, what to pick next, the measures so far, and their way out of the page.

import { note } from '../dialogs.js';
import { connectRadios } from '../radios.js';
import { sectionSvg } from './section.js';
import { kStated } from './uncertainty.js';
import { asCsv, asText, details, inWords, kUnits, title } from './measure_text.js';

const kSteps = {
  distance: ['Pick a point of the surface.', 'Pick the second point.'],
  angle: ['Pick a point on the first side.', 'Pick the corner of the angle.', 'Pick a point on the other side.'],
  section: ['Pick a point of the plane.', 'Pick a second point of the plane.', 'Pick a third point of the plane.'],
  diameter: ['Pick a point of the round wall or rim.', 'Pick a second one, away from the first.', 'Pick a third one, away from both.'],
};
const kSources = {
  stated: () => 'from the uncertainty of each vertex that the file states.',
  voxels: (voxelSizeM) => `estimated from voxels of ${(1000 * voxelSizeM).toFixed(1)} mm and how well each place was seen.`,
  unknown: () => 'only from the pixels of this picture: how noisy the mesh is, is not known.',
};

export class MeasurePanel {
  /// on: {kind(name), plane(name), undo(), clear(), close()}; `mesh`(): what the mesh is, in words.
  constructor(panel, { on, mesh }) {
    Object.assign(this, { panel, mesh });
    const find = (name) => panel.querySelector(`#measure-${name}`);
    const [step, list, source, unitSelect, planes] = ['step', 'list', 'source', 'unit', 'planes'].map(find);
    Object.assign(this, { step, list, source, unitSelect, planes });
    this.buttons = ['undo', 'clear', 'text', 'csv'].map(find);
    this.measures = [];
    connectRadios([...panel.querySelectorAll('[data-kind]')], (button) => on.kind(button.dataset.kind));
    connectRadios([...panel.querySelectorAll('[data-plane]')], (button) => on.plane(button.dataset.plane));
    for (const name of ['undo', 'clear', 'close']) { find(name).addEventListener('click', on[name]); }
    this.unitSelect.append(...Object.keys(kUnits).map((unit) => new Option(unit, unit)));
    this.unitSelect.addEventListener('change', () => this.showList());
    find('text').addEventListener('click', () => copy(asText(this.measures, this.labels())));
    find('csv').addEventListener('click', () => copy(asCsv(this.measures, this.labels())));
  }

  get unit() { return this.unitSelect.value; }
  labels() { return { unit: this.unit, mesh: this.mesh() }; }

  /// `picked`: how many points of the next measure there are. `fresh`: the measure that was just taken, if any. `isPreview`: the mesh is
  /// not the final one.
  show({ kind, measures, picked, fresh, isPreview, voxelSizeM }) {
    this.planes.hidden = kind !== 'section';
    const result = fresh ? `${title(fresh)} ${inWords(fresh.values[0], this.unit)}. ` : '';
    this.say(result + kSteps[kind][picked]);
    const [undo, ...others] = this.buttons;
    undo.disabled = measures.length === 0 && picked === 0;
    for (const button of others) { button.disabled = measures.length === 0 && !(button.id === 'measure-clear' && picked > 0); }
    const from = ['unknown', 'voxels', 'stated'].find((name) => measures.some((one) => one.from === name));
    this.source.textContent = [
      isPreview ? 'Preview: this is the mesh of the scan, not the finished file.' : '',
      from ? `± is ${kStated} standard deviations, ${kSources[from](voxelSizeM)}` : '',
    ].filter(Boolean).join(' ');
    this.measures = measures;
    this.showList();
  }

  say(words) {
    if (this.step.textContent !== words) { this.step.textContent = words; }
  }

  showList() {
    this.list.replaceChildren(...this.measures.map((one) => this.item(one)));
    this.list.scrollTop = this.list.scrollHeight;
  }

  item(one) {
    const row = document.createElement('li');
    const put = (tag, text) => row.append(Object.assign(document.createElement(tag), { textContent: text }));
    put('b', title(one));
    put('output', inWords(one.values[0], this.unit));
    put('small', details(one, this.unit).join(' · '));
    if (one.section) {
      const button = Object.assign(document.createElement('button'), { type: 'button', textContent: 'SVG' });
      button.setAttribute('aria-label', 'Download the section as SVG');
      button.addEventListener('click', () => this.download(one));
      row.append(button);
    }
    return row;
  }

  download(one) {
    const caption = [this.mesh(), ...one.values.map((value) => `${value.name.toLowerCase()} ${inWords(value, this.unit)}`)].join(', ');
    const url = URL.createObjectURL(new Blob([sectionSvg(one.section, caption)], { type: 'image/svg+xml' }));
    const number = this.measures.indexOf(one) + 1;
    Object.assign(document.createElement('a'), { href: url, download: `section_${number}.svg` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }
}

/// Beyond this computer the page is not a secure context, and there is no navigator.clipboard.
async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    note('Copied.');
    return;
  } catch {
    // the old way, below
  }
  const area = Object.assign(document.createElement('textarea'), { value: text, readOnly: true, className: 'copied' });
  document.body.append(area);
  area.select();
  const isDone = document.execCommand('copy');
  area.remove();
  note(isDone ? 'Copied.' : 'This browser does not let the page copy.', { isBad: !isDone });
}

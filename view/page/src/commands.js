// The buttons that steer the scan. Shows only those that the program accepts, and only when they make sense.

import { ask, note } from './dialogs.js';

const kWhen = {
  start: ['paused'],
  pause: ['waiting', 'scanning'],
  reset: ['scanning', 'paused'],
  crop: ['scanning', 'paused'],
  export: ['scanning', 'paused'],
  finish: ['waiting', 'scanning', 'paused'],
};
/// The commands that need a scanned frame.
const kOfAScan = new Set(['reset', 'crop', 'export']);
const kQuestions = {
  reset: { head: 'Begin anew?', text: 'The mesh so far is thrown away.', yes: 'Reset', no: 'Keep it' },
  finish: { head: 'Finish the scan?', text: 'The mesh is written, and nothing more is added to it.', yes: 'Finish', no: 'Go on' },
};
const kCropIgnored = 'Nothing of the mesh is in the crop box: the whole mesh is written, and nothing more is added to it.';
const kDone = { reset: 'Begun anew.', export: 'The mesh is written.', crop: 'The crop box is set.' };

export class Commands {
  /// done(command): called when the program has done it; crop(): called by the crop button; null: there is no such
  /// button.
  constructor(bar, connection, { done, crop }) {
    this.bar = bar;
    this.connection = connection;
    this.done = done;
    this.allowed = new Set();
    this.phase = 'waiting';
    this.isHeld = false;       // paused: Start replaces Pause
    this.isCropEmpty = false;  // no triangle of the mesh is in the crop box in force
    this.endCropNote = () => {};
    this.hasScan = false;      // something has been fused
    this.isOpen = false;
    this.busy = new Set();
    this.hasCrop = crop !== null;
    this.buttons = new Map([...bar.querySelectorAll('[data-command]')].map((button) => [button.dataset.command, button]));
    for (const [command, button] of this.buttons) {
      button.addEventListener('click', () => (command === 'crop' ? crop() : this.ask(command)));
    }
  }

  update({ allowed = this.allowed, phase = this.phase, isOpen = this.isOpen, isCropEmpty = this.isCropEmpty, hasScan = this.hasScan }) {
    if (isCropEmpty && !this.isCropEmpty) { this.endCropNote = note('Nothing of the mesh is in the crop box.', { isBad: true }); }
    if (!isCropEmpty && this.isCropEmpty) { this.endCropNote(); }
    Object.assign(this, { allowed, phase, isOpen, isCropEmpty, hasScan });
    if (phase !== 'exporting') { this.isHeld = phase === 'paused'; }  // an export does not change it
    const { isHeld } = this;
    const focused = document.activeElement;
    for (const [command, button] of this.buttons) {
      const isMeant = allowed.has(command) && (command !== 'crop' || this.hasCrop) && !(command === 'start' && !isHeld) && !(command === 'pause' && isHeld);
      button.hidden = !isMeant || phase === 'finished' || phase === 'failed';
      button.disabled = !this.isPossible(command);
      button.classList.toggle('busy', this.busy.has(command));
      if (button.hidden && button === focused) { [...this.buttons.values()].find((other) => !other.hidden)?.focus(); }
    }
    this.bar.hidden = ![...this.bar.children].some((button) => !button.hidden);
  }

  isPossible(command) {
    return this.isOpen && this.allowed.has(command) && !this.busy.has(command) && kWhen[command].includes(this.phase) && (this.hasScan || !kOfAScan.has(command));
  }

  nameOf(command) { return this.buttons.get(command).firstChild.textContent.trim(); }

  async ask(command) {
    let question = kQuestions[command];
    if (command === 'finish' && this.isCropEmpty) { question = { ...question, text: kCropIgnored }; }
    if (question && !(await ask(question))) { return; }
    if (!this.isPossible(command)) {  // the scan went on while the question was open
      const why = this.phase === 'exporting' ? 'not while the mesh is being written, try again' : 'not possible any more';
      note(`${this.nameOf(command)}: ${why}.`, { isBad: true });
      return;
    }
    await this.send(command);
  }

  /// Resolves to true when the command was done.
  async send(command, fields = {}) {
    this.busy.add(command);
    this.update({});
    let isDone = false;
    try {
      await this.connection.send(command, fields);
      isDone = true;
      if (kDone[command]) { note(fields.box === null ? 'The crop box is gone.' : kDone[command]); }
    } catch (error) {
      note(`${this.nameOf(command)}: ${error.message}`, { isBad: true });
    }
    this.busy.delete(command);
    this.update({});
    if (isDone) { this.done(command); }
    return isDone;
  }
}

// The banner, readable from two metres away: the state of the scan, and advice.

import { count } from './quantities.js';

/// {tone, sign, head, advice} for the link's status ('connecting', 'open', 'lost', 'refused', 'full'), the newest state and hello.
export function wordsFor(link, state, hello) {
  const over = state?.phase === 'finished' || state?.phase === 'failed';
  if (link === 'refused') {
    return { tone: 'bad', sign: '✕', head: 'This link is no longer valid', advice: 'Open the link that the program prints now.' };
  }
  if (link === 'lost' && !over) {
    return { tone: 'gone', sign: '⌁', head: 'Connection lost', advice: 'Trying again. The scan goes on without this page.' };
  }
  if (link === 'full' && !over) {
    return { tone: 'gone', sign: '⌁', head: 'No room for this page', advice: 'Too many pages look on. Close one of them: this one tries again.' };
  }
  if (link === 'connecting' || !state) {
    return { tone: 'quiet', sign: '…', head: 'Connecting', advice: '' };
  }
  if (hello?.mode === 'file' && state.phase === 'finished') {
    return { tone: 'quiet', sign: '◆', head: hello.title, advice: link === 'lost' ? 'The program has ended.' : '' };
  }
  const phase = wordsForPhase(state, link, hello);
  return phase ?? wordsForTracking(state);
}

function wordsForPhase({ phase, message, frame, silent_s: silentS }, link, hello) {
  switch (phase) {
    case 'waiting':
      if (message) { return { tone: 'quiet', sign: '…', head: 'Getting ready', advice: sentence(message) }; }
      return { tone: 'quiet', sign: '…', head: 'Waiting for the first frame', advice: frame > 0 ? `Of ${count(frame)} so far none could be used.` : silence(silentS) };
    case 'scanning':
      return silentS > 0 ? { tone: 'warn', sign: '!', head: 'No frames come', advice: silence(silentS) } : null;
    case 'paused':
      return { tone: 'quiet', sign: '❚❚', head: 'Paused', advice: hello?.is_paced ? 'Frames pass by meanwhile. Start goes on with those that come then.' : 'Start goes on where it stopped.' };
    case 'exporting':
      return { tone: 'quiet', sign: '↓', head: message ? 'Working on the mesh' : 'Writing the mesh', advice: sentence(message) };
    case 'finished':
      return { tone: 'done', sign: '✓', head: 'Finished', advice: sentence(message) || (link === 'lost' ? 'The program has ended.' : '') };
    case 'failed':
      return { tone: 'bad', sign: '✕', head: 'The scan failed', advice: sentence(message) };
    default:
      return null;
  }
}

const kTracking = {
  ok: { tone: 'good', sign: '✓', head: 'Tracking well' },
  weak: { tone: 'warn', sign: '!', head: 'Weak' },
  lost: { tone: 'bad', sign: '✕', head: 'Lost' },
  recovered: { tone: 'good', sign: '↻', head: 'Found again' },
  none: { tone: 'good', sign: '●', head: 'Scanning' },
  unusable: { tone: 'bad', sign: '✕', head: 'No usable frame' },
};

function wordsForTracking({ tracking, reason, advice }) {
  const words = kTracking[tracking] ?? kTracking.none;
  return { ...words, head: reason ? `${words.head}: ${reason}` : words.head, advice: sentence(advice) };
}

function silence(seconds) {
  return seconds > 0 ? `Nothing from the scanner for ${count(seconds)} s.` : '';
}

function sentence(text) {
  return text ? text[0].toUpperCase() + text.slice(1) : '';
}

export class Banner {
  constructor(element) {
    this.element = element;
    this.sign = element.querySelector('#banner-sign');
    this.head = element.querySelector('#banner-head');
    this.advice = element.querySelector('#banner-advice');
    this.words = element.querySelector('#banner-words');
    this.retry = element.querySelector('#retry');
  }

  show(link, state, hello) {
    const { tone, sign, head, advice } = wordsFor(link, state, hello);
    this.retry.hidden = tone !== 'gone';
    if (this.element.dataset.tone === tone && this.head.textContent === head && this.advice.textContent === advice) { return; }
    if (tone === 'bad' && this.element.dataset.tone !== 'bad' && navigator.userActivation?.hasBeenActive) { navigator.vibrate?.(150); }
    this.element.dataset.tone = tone;
    this.words.setAttribute('aria-live', tone === 'bad' || tone === 'gone' ? 'assertive' : 'polite');
    this.sign.textContent = sign;
    this.head.textContent = head;
    this.advice.textContent = advice;
  }
}

// A question that must be answered, and a note that disappears by itself.

const kNoteMs = 6000;

/// Resolves to true if the user answers yes.
export function ask({ head, text, yes, no }) {
  const dialog = document.getElementById('ask');
  const put = (id, words) => { document.getElementById(id).textContent = words; };
  put('ask-head', head);
  put('ask-text', text);
  put('ask-yes', yes);
  put('ask-no', no);
  dialog.returnValue = 'no';
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => resolve(dialog.returnValue === 'yes'), { once: true });
  });
}

let timer = 0;

/// Returns a function that removes the note before it disappears by itself.
export function note(text, { isBad = false } = {}) {
  const element = document.getElementById('note');
  element.textContent = text;
  element.classList.toggle('bad', isBad);
  element.hidden = false;
  clearTimeout(timer);
  const end = () => { element.hidden = true; };
  const own = setTimeout(end, kNoteMs);
  timer = own;
  return () => { if (timer === own) { end(); } };
}

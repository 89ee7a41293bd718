// Buttons of which one is chosen: role=radio, arrows go from one to the next.

/// onChoose(button) is called for each choice. Returns choose(button).
export function connectRadios(buttons, onChoose) {
  const choose = (button) => {
    for (const other of buttons) {
      other.setAttribute('aria-checked', String(other === button));
      other.tabIndex = other === button ? 0 : -1;
    }
    onChoose(button);
  };
  buttons.forEach((button, i) => {
    button.tabIndex = button.getAttribute('aria-checked') === 'true' ? 0 : -1;
    button.addEventListener('click', () => choose(button));
    button.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
      if (!step) { return; }
      event.preventDefault();
      const next = buttons[(i + step + buttons.length) % buttons.length];
      choose(next);
      next.focus();
    });
  });
  return choose;
}

// The buttons that change how the mesh is drawn, but not the scan.

const $ = (id) => document.getElementById(id);

/// `picture` null: there is no WebGL, and no tools are shown.
export function connectTools(picture) {
  $('tools').hidden = !picture;
  const showRing = (isShown) => {
    $('ring').hidden = !isShown;
    $('ring-toggle').setAttribute('aria-pressed', String(isShown));
    picture?.viewer.redraw();
  };
  if (!picture) { return { showRing: () => {} }; }
  const { viewer, keeper } = picture;
  connectShadings(picture);
  $('fit').addEventListener('click', () => keeper.fit());
  $('follow').addEventListener('click', () => keeper.set({ isFitting: keeper.isFollowing === true, isFollowing: !keeper.isFollowing }));
  keeper.onChange = () => $('follow').setAttribute('aria-pressed', String(keeper.isFollowing === true));
  $('ring-toggle').addEventListener('click', () => showRing($('ring').hidden));
  viewer.redraw();
  return { showRing };
}

function connectShadings({ viewer, materials }) {
  const buttons = [...$('shading').querySelectorAll('[data-shading]')];
  const choose = (button) => {
    materials.shading = button.dataset.shading;
    for (const other of buttons) {
      other.setAttribute('aria-checked', String(other === button));
      other.tabIndex = other === button ? 0 : -1;
    }
    $('legend').hidden = button.dataset.shading !== 'coverage';
    viewer.redraw();
  };
  buttons.forEach((button, i) => {
    button.tabIndex = i === 0 ? 0 : -1;
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
}

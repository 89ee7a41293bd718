// The buttons that change how the mesh is drawn, but not the scan.

import { connectRadios } from './radios.js';

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
  connectRadios(buttons, (button) => {
    materials.shading = button.dataset.shading;
    $('legend').hidden = button.dataset.shading !== 'coverage';
    viewer.redraw();
  });
}

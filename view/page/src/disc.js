// The round picture of a point that can be taken or was picked.

import { CanvasTexture } from 'three';

export function disc() {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 64;
  const drawing = canvas.getContext('2d');
  drawing.fillStyle = '#fff';
  drawing.beginPath();
  drawing.arc(32, 32, 27, 0, 2 * Math.PI);
  drawing.fill();
  drawing.lineWidth = 6;
  drawing.strokeStyle = '#5b4a1e';
  drawing.stroke();
  return new CanvasTexture(canvas);
}

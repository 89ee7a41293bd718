// The page as it is built, served by a program that says on cue what the real one says rarely.

import { copyFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { MockProgram, chunkBody } from './mock_program.mjs';
import { temporaryFolder } from './program.mjs';

const kPage = join(dirname(fileURLToPath(import.meta.url)), '../../view/page');

/// The page as it is built, where the mock can serve it.
function builtPage() {
  const folder = temporaryFolder();
  for (const name of ['index.html', 'view.css', 'icon.svg']) { copyFileSync(join(kPage, name), join(folder, name)); }
  copyFileSync(process.env.SCANKNIT_VIEW_SCRIPT, join(folder, 'view.js'));
  return folder;
}

const folder = builtPage();

/// Ends with the test.
export async function startMock(context) {
  const program = await new MockProgram(folder).listen();
  context.after(() => program.close());
  return program;
}

/// A square of side 2 in the plane z = 0, seen from -z (y down, as a camera sees), corners in four colours.
export const kCorners = [[200, 60, 40], [60, 180, 75], [40, 90, 200], [7, 1, 30]];
export function square({ colours = kCorners, normal = [0, 0, -1], hasColours = true, shift = 0, coverage } = {}) {
  const places = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
  const vertices = places.map(([x, y], i) => ({ p: [x + shift, y, 0], colour: colours[i], normal, coverage }));
  return chunkBody(vertices, [0, 2, 1, 0, 3, 2], { hasColours });
}
export const lookAtSquare = (page) => page.evaluate(() => window.scanknit.look([0, 0, -3], [0, 0, 0]));

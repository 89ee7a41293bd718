// Starts the real program and makes recordings with it.

import { spawn, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { deflateSync } from 'node:zlib';
import { after } from 'node:test';
import { boxOf } from './known_shapes.mjs';

const kProgram = process.env.SCANKNIT_PROGRAM;

const running = new Set();
after(() => running.forEach((child) => child.kill('SIGKILL')));

/// A folder that is gone after the tests.
export function temporaryFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'scanknit_browser_'));
  after(() => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

/// Runs to the end; throws with what it said when it failed.
export function scanknit(...args) {
  const { status, stderr } = spawnSync(kProgram, args, { encoding: 'utf8' });
  if (status !== 0) { throw new Error(`scanknit ${args.join(' ')}: exit code ${status}\n${stderr}`); }
}

export function synthesise(folder, scene, { frames, width = 160, height = 120 }) {
  scanknit('synth', scene, '-o', folder, '--frames', String(frames), '--width', String(width), '--height', String(height), '--quiet');
  return folder;
}

/// With a live view: {url, port, stop(), kill(), step(frames) for `--pace stepped`}; stop() gives the exit code. What is not stopped is killed after the tests.
export async function startProgram(...args) {
  const child = spawn(kProgram, args, { stdio: ['pipe', 'ignore', 'pipe'] });
  running.add(child);
  let said = '';
  const exited = new Promise((resolve) => child.on('exit', (code) => {
    running.delete(child);
    resolve(code);
  }));
  const url = await new Promise((resolve, reject) => {
    child.stderr.setEncoding('utf8');
    child.stderr.on('data', (text) => {
      said += text;
      const link = /live view: (http:\S+)\n/.exec(said);
      if (link) { resolve(link[1]); }
    });
    exited.then((code) => reject(new Error(`ended with ${code} before the link was printed\n${said}`)));
  });
  const stop = () => {
    child.kill('SIGINT');
    return exited;
  };
  return { url, port: Number(new URL(url).port), stop, kill: () => child.kill('SIGKILL'), step: (frames) => child.stdin.write('\n'.repeat(frames)) };
}

export const kRed = [200, 60, 40], kGreen = [60, 180, 75], kBlue = [40, 90, 200];

/// A closed box of 20 cm whose colour goes by x: red below -4 cm, blue above 4 cm, green between. PLY.
export function writeColouredBox(path) {
  const { points, triangles } = boxOf([0.2, 0.2, 0.2], 10);
  const colourOf = (x) => (x < -0.041 ? kRed : x > 0.041 ? kBlue : kGreen);
  const vertices = points.map(([x, y, z]) => [x, y, z, ...colourOf(x)].join(' '));
  writeFileSync(path, ['ply', 'format ascii 1.0', `element vertex ${points.length}`, 'property float x', 'property float y', 'property float z',
    'property uchar red', 'property uchar green', 'property uchar blue', `element face ${triangles.length}`,
    'property list uchar int vertex_indices', 'end_header', ...vertices, ...triangles.map((t) => `3 ${t.join(' ')}`), ''].join('\n'));
  return path;
}

/// Nothing is seen in these frames of a recording of `synth`: a hand before the lens.
export function coverFrames(recording, from, to, { width = 160, height = 120 } = {}) {
  const names = readdirSync(join(recording, 'depth')).sort();
  for (const name of names.slice(from, to)) { writeFileSync(join(recording, 'depth', name), blackDepth(width, height)); }
}

/// A PNG of 16-bit zeros.
function blackDepth(width, height) {
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header[8] = 16;  // bits; grey
  return Buffer.concat([Buffer.from('89504e470d0a1a0a', 'hex'), pngPart('IHDR', header),
    pngPart('IDAT', deflateSync(Buffer.alloc(height * (1 + 2 * width)))), pngPart('IEND', Buffer.alloc(0))]);
}

function pngPart(name, body) {
  const part = Buffer.concat([Buffer.from(name, 'latin1'), body]);
  const size = Buffer.alloc(4), check = Buffer.alloc(4);
  size.writeUInt32BE(body.length);
  check.writeUInt32BE(crc32(part));
  return Buffer.concat([size, part, check]);
}

function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) { crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0); }
  }
  return (crc ^ 0xffffffff) >>> 0;
}

/// Of the mesh files in a folder: name -> digest.
export function meshDigests(folder) {
  const names = readdirSync(folder).filter((name) => name.startsWith('model.'));
  return Object.fromEntries(names.map((name) => [name, createHash('sha256').update(readFileSync(join(folder, name))).digest('hex')]));
}

// Speaks the live view's protocol (docs/live_view.md) with a made-up scan, for what the real program cannot be made to say on
// cue: every tracking state, a lost connection, refused commands. Also: node mock_program.mjs PAGE_FOLDER [PORT], to look at it.

import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { WebSocketServer } from 'ws';
import { depthJpeg, chunksOfVase, orbitPose } from './mock_scan.mjs';

export const kPolicy = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'";
const kTypes = { html: 'text/html', css: 'text/css', js: 'text/javascript', svg: 'image/svg+xml' };

export function binaryMessage(kind, chunk, revision, body = new Uint8Array(0)) {
  const bytes = new Uint8Array(16 + body.byteLength);
  const view = new DataView(bytes.buffer);
  [0x314d4b53, kind, chunk, revision].forEach((word, i) => view.setUint32(4 * i, word, true));
  bytes.set(body, 16);
  return bytes;
}

/// vertices: [{p, colour, coverage, normal}], indices: numbers; the body of a message of kind 1.
export function chunkBody(vertices, indices, { hasColours = true } = {}) {
  const isWide = vertices.length > 65535;
  const low = [0, 1, 2].map((axis) => vertices.reduce((least, v) => Math.min(least, v.p[axis]), Infinity));
  const high = [0, 1, 2].map((axis) => vertices.reduce((most, v) => Math.max(most, v.p[axis]), -Infinity));
  const scale = Math.max(...[0, 1, 2].map((axis) => high[axis] - low[axis]), 1e-6) / 65535;
  const view = new DataView(new ArrayBuffer(32 + 16 * vertices.length + (isWide ? 4 : 2) * indices.length));
  [vertices.length, indices.length, (hasColours ? 1 : 0) | (isWide ? 2 : 0), 0].forEach((word, i) => view.setUint32(4 * i, word, true));
  [...low, scale].forEach((value, i) => view.setFloat32(16 + 4 * i, value, true));
  vertices.forEach(({ p, colour, coverage = 255, normal }, v) => {
    const at = 32 + 16 * v;
    p.forEach((x, axis) => view.setUint16(at + 2 * axis, Math.round((x - low[axis]) / scale), true));
    colour.forEach((byte, i) => view.setUint8(at + 8 + i, byte));
    view.setUint8(at + 11, coverage);
    normal.forEach((n, i) => view.setInt8(at + 12 + i, Math.round(127 * n)));
  });
  const end = 32 + 16 * vertices.length;
  indices.forEach((index, i) => (isWide ? view.setUint32(end + 4 * i, index, true) : view.setUint16(end + 2 * i, index, true)));
  return new Uint8Array(view.buffer);
}

export class MockProgram {
  /// page: the folder with index.html, view.css, icon.svg and the bundled view.js.
  constructor(page) {
    this.page = page;
    this.clients = new Set();
    this.commands = [];    // that came in
    this.answer = () => '';  // error of a command's ack
    this.hello = {
      type: 'hello', version: '0.1.0', title: 'made-up vase', mode: 'run', up: [0, -1, 0], is_orbit: true, voxel_size_m: 0.002,
      commands: ['start', 'pause', 'reset', 'crop', 'export', 'finish'],
    };
    this.state = {
      type: 'state', phase: 'waiting', tracking: 'ok', reason: '', advice: '', frame: 0, frames_total: 0, fused: 0, dropped: 0, lost: 0,
      fps: 0, silent_s: 0, losses: {}, triangles: 0, is_behind: false, is_crop_empty: false, memory_mib: 0, view_share: 0.01, message: '',
    };
    this.chunks = new Map();  // number -> message
    this.others = new Map([   // type -> message, told to each client after hello
      { type: 'files', files: [] }, { type: 'crop', box: null }, { type: 'trail', points: [] },
    ].map((message) => [message.type, message]));
    this.isFull = false;      // no page is let in
  }

  async listen(port = 0) {
    this.http = createServer((request, response) => this.get(request, response));
    this.sockets = new WebSocketServer({
      server: this.http, path: '/api/v1/live', handleProtocols: () => 'scanknit.v1', verifyClient: () => !this.isFull,
    });
    this.sockets.on('connection', (socket) => this.welcome(socket));
    await new Promise((resolve) => this.http.listen(port, '127.0.0.1', resolve));
    this.port = this.http.address().port;
    this.url = `http://127.0.0.1:${this.port}/`;
    return this;
  }

  async get(request, response) {
    const path = new URL(request.url, 'http://x').pathname;
    const name = path === '/' ? 'index.html' : path.slice(1);
    if (path === '/api/v1/state') { return response.writeHead(200, { 'content-type': 'application/json' }).end(JSON.stringify(this.state)); }
    if (!/^[a-z]+\.(html|css|js|svg)$/.test(name)) { return response.writeHead(404).end(); }
    try {
      const body = await readFile(join(this.page, name));
      return response.writeHead(200, { 'content-type': kTypes[name.split('.').pop()], 'content-security-policy': kPolicy }).end(body);
    } catch {
      return response.writeHead(404).end();
    }
  }

  welcome(socket) {
    const client = { socket, credit: 8, queue: [...this.chunks.values()] };
    this.clients.add(client);
    socket.on('close', () => this.clients.delete(client));
    socket.on('message', (data) => this.receive(client, JSON.parse(data)));
    for (const message of [this.hello, ...this.others.values(), this.state]) { socket.send(JSON.stringify(message)); }
    this.pump(client);
  }

  receive(client, message) {
    if ('got' in message) {
      client.credit += message.got;
      this.pump(client);
      return;
    }
    this.commands.push(message);
    const error = this.answer(message);
    client.socket.send(JSON.stringify({ type: 'ack', id: message.id, ok: error === '', error }));
  }

  pump(client) {
    while (client.credit > 0 && client.queue.length > 0) {
      --client.credit;
      client.socket.send(client.queue.shift());
    }
  }

  sendText(message) {
    if (message.type === 'state') { this.state = { ...this.state, ...message }; }
    if (['trail', 'files', 'crop'].includes(message.type)) { this.others.set(message.type, message); }
    for (const { socket } of this.clients) { socket.send(JSON.stringify(message.type === 'state' ? this.state : message)); }
  }

  sendBinary(message) {
    const view = new DataView(message.buffer);
    const [kind, chunk] = [view.getUint32(4, true), view.getUint32(8, true)];
    if (kind === 1) { this.chunks.set(chunk, message); }
    if (kind === 2) { this.chunks.delete(chunk); }
    for (const client of this.clients) {
      client.queue.push(message);
      this.pump(client);
    }
  }

  /// Ends every connection; new ones are welcome.
  drop() {
    for (const { socket } of this.clients) { socket.terminate(); }
  }

  async close() {
    this.drop();
    await new Promise((resolve) => this.http.close(resolve));
  }
}

/// Turns the made-up vase before the scanner, for ever.
async function demonstrate(folder, port) {
  const program = await new MockProgram(folder).listen(port);
  console.log(program.url);
  const vase = chunksOfVase(chunkBody);
  const steps = 240;
  for (let step = 0; ; ++step) {
    const share = Math.min(1, step / steps);
    const azimuth = 2 * Math.PI * Math.min(share, 0.85);
    for (const { number, body } of vase.revealed(share)) { program.sendBinary(binaryMessage(1, number, step, body)); }
    program.sendText({ type: 'pose', T: orbitPose(azimuth), half: [0.55, 0.42], is_lost: false });
    program.sendBinary(binaryMessage(3, 0, step, depthJpeg()));
    program.sendText({
      type: 'state', phase: 'scanning', tracking: 'ok', frame: step, fused: step, lost: 3, fps: 24.6, frames_total: 600, memory_mib: 13,
      triangles: vase.triangles(share),
    });
    if (step === steps) { program.sendText({ type: 'files', files: [{ name: 'model.glb', bytes: 1712344 }, { name: 'model.stl', bytes: 3430084 }] }); }
    await new Promise((resolve) => setTimeout(resolve, 60));
  }
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) { await demonstrate(process.argv[2], Number(process.argv[3] ?? 8765)); }

// A page without a picture: counts what comes, keeps the protocol, or breaks it on purpose.

import { WebSocket } from 'ws';

export class LiveClient {
  /// credit: gives it back for each binary message (a page does); else it takes eight and no more.
  constructor(url, { gives = true } = {}) {
    this.triangles = new Map();  // chunk -> count
    this.revisions = new Map();
    this.wentBack = 0;           // chunks that came in an older revision than before
    this.binary = 0;
    this.state = null;
    this.gives = gives;
    const address = new URL('api/v1/live', url);
    address.protocol = 'ws:';
    this.socket = new WebSocket(address, 'scanknit.v1', { origin: new URL(url).origin });
    this.socket.on('message', (data, isBinary) => this.receive(data, isBinary));
    this.socket.on('error', () => {});
    this.waiters = [];
  }

  receive(data, isBinary) {
    if (isBinary) { this.receiveBinary(data); } else {
      const message = JSON.parse(data);
      if (message.type === 'state') { this.state = message; }
    }
    this.waiters = this.waiters.filter(({ isMet, resolve }) => {
      if (isMet(this)) { resolve(); }
      return !isMet(this);
    });
  }

  receiveBinary(data) {
    ++this.binary;
    const [kind, chunk, revision] = [data.readUInt32LE(4), data.readUInt32LE(8), data.readUInt32LE(12)];
    if (kind !== 3) {
      if (revision < (this.revisions.get(chunk) ?? 0)) { ++this.wentBack; }
      this.revisions.set(chunk, revision);
      this.triangles.set(chunk, kind === 1 ? data.readUInt32LE(20) / 3 : 0);
    }
    if (this.gives) { this.socket.send('{"got":1}'); }
  }

  get triangleCount() { return [...this.triangles.values()].reduce((sum, n) => sum + n, 0); }

  until(isMet) {
    return isMet(this) ? Promise.resolve() : new Promise((resolve) => this.waiters.push({ isMet, resolve }));
  }
}

/// How a WebSocket is received: 'open', or the HTTP status it was refused with.
export function knock(url, { origin, protocol = 'scanknit.v1', headers = {} } = {}) {
  return new Promise((resolve) => {
    const socket = new WebSocket(url, protocol, { origin, headers });
    socket.on('open', () => {
      socket.terminate();
      resolve('open');
    });
    socket.on('unexpected-response', (_, response) => {
      response.resume();
      resolve(response.statusCode);
    });
    socket.on('error', () => resolve('error'));
  });
}

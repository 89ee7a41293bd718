// The WebSocket to the program: receives text and binary messages, sends commands, and reconnects when it breaks.

const kFirstWaitMs = 400;
const kLongestWaitMs = 8000;
/// After so long without a message, the page asks whether the program still runs.
const kSilenceMs = 8000;
const kProbeMs = 4000;

export class Connection {
  /// handlers: text(message), binary(buffer), status('connecting' | 'open' | 'lost' | 'refused' | 'full').
  constructor(handlers) {
    this.handlers = handlers;
    this.socket = null;
    this.wait = kFirstWaitMs;
    this.timer = 0;
    this.heardAt = 0;
    this.stateText = '';       // the newest state message
    this.missed = 0;           // how often in a row the program's state differed from the received one
    this.isWelcome = false;    // this socket has received hello
    this.nextId = 1;
    this.waiting = new Map();  // id of a command -> {resolve, reject} of its promise
    document.addEventListener('visibilitychange', () => document.visibilityState === 'visible' && this.retryNow());
    window.addEventListener('online', () => this.retryNow());
    setInterval(() => this.checkSilence(), 1000);
    this.open();
  }

  open() {
    clearTimeout(this.timer);
    this.timer = 0;
    const address = new URL('api/v1/live', location.href);
    address.protocol = address.protocol.replace('http', 'ws');
    const socket = new WebSocket(address, 'scanknit.v1');
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.isWelcome = false;
    socket.onopen = () => { this.heardAt = performance.now(); };
    socket.onmessage = (event) => this.receive(socket, event.data);
    socket.onclose = () => this.closed(socket);
  }

  receive(socket, data) {
    if (socket !== this.socket) { return; }
    this.heardAt = performance.now();
    this.missed = 0;
    if (typeof data !== 'string') {
      try {
        this.handlers.binary(data);
      } finally {
        socket.send('{"got":1}');  // also for a bad message: without credit the program would send no more
      }
      return;
    }
    const message = JSON.parse(data);
    if (message.type === 'state') { this.stateText = data; }
    if (message.type === 'hello') {
      this.wait = kFirstWaitMs;
      this.isWelcome = true;
      this.handlers.status('open');
    }
    if (message.type === 'ack') {
      this.settle(message);
    } else {
      this.handlers.text(message);
    }
  }

  settle({ id, ok, error }) {
    const pending = this.waiting.get(id);
    this.waiting.delete(id);
    if (!pending) { return; }
    if (ok) { pending.resolve(); } else { pending.reject(new Error(error || 'refused')); }
  }

  /// Sends a command. Resolves when the program has done it; rejects with the program's message.
  send(command, fields = {}) {
    if (this.socket?.readyState !== WebSocket.OPEN) { return Promise.reject(new Error('not connected')); }
    const id = this.nextId++;
    this.socket.send(JSON.stringify({ cmd: command, id, ...fields }));
    return new Promise((resolve, reject) => this.waiting.set(id, { resolve, reject }));
  }

  async closed(socket) {
    if (socket !== this.socket) { return; }
    this.socket = null;
    for (const { reject } of this.waiting.values()) { reject(new Error('the connection was lost; whether it was done is not known')); }
    this.waiting.clear();
    this.timer = setTimeout(() => this.open(), this.wait * (0.75 + 0.5 * Math.random()));
    this.wait = Math.min(2 * this.wait, kLongestWaitMs);
    const { isWelcome } = this;
    if (isWelcome) { this.handlers.status('lost'); }
    // A WebSocket does not report why it could not be opened; HTTP on the same port does.
    const { status } = await probe();
    if (this.timer === 0) { return; }
    const isRefused = status === 401 || status === 403;
    this.handlers.status(isRefused ? 'refused' : status === 200 && !isWelcome ? 'full' : 'lost');
  }

  retryNow() {
    if (this.timer === 0) { return; }
    this.wait = kFirstWaitMs;
    this.open();
  }

  /// Closes the connection and opens another, which sends the whole mesh again.
  again() {
    const socket = this.socket;
    if (!socket) { return; }
    socket.onmessage = null;
    socket.close();
    this.closed(socket);
  }

  async checkSilence() {
    const socket = this.socket;
    if (socket?.readyState !== WebSocket.OPEN || performance.now() - this.heardAt < kSilenceMs) { return; }
    this.heardAt = performance.now();
    const { status, text } = await probe();
    if (socket !== this.socket) { return; }
    // A dead connection, for example after a phone slept, stays open and silent.
    this.missed = status === 200 && text !== this.stateText ? this.missed + 1 : 0;
    if (status !== 200 || this.missed > 1) { this.again(); }
  }
}

/// The program's state, and the HTTP status of asking for it; 0 when nobody answers.
async function probe() {
  try {
    const answer = await fetch('api/v1/state', { signal: AbortSignal.timeout(kProbeMs), cache: 'no-store' });
    return { status: answer.status, text: await answer.text() };
  } catch {
    return { status: 0, text: '' };
  }
}

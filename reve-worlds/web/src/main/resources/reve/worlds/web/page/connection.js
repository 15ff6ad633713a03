// SPDX-License-Identifier: Apache-2.0
// A client of the agent protocol (agents/protocol/PROTOCOL.md) over the WebSocket.

const RETRY_MILLISECONDS = [250, 500, 1000, 2000, 4000];
const SILENT = new Set(["goodbye", "token-revoked", "bad-token", "not-permitted", "too-many-attempts", "name-taken"]);

/** The error with which the promise of a command rejects if the server refuses the command. */
export class Refused extends Error {
  constructor(code, reason) {
    super(reason);
    this.code = code;
  }
}

/** A client that reconnects when the server is available again. It dispatches these events:
 *  "welcome", "event" and "perception" with the message; "binary" with an ArrayBuffer; "end" with
 *  the message bye or null; and "retry". */
export class Connection extends EventTarget {
  #socket = null;
  #hello = null;
  #next = 1;
  #waiting = new Map();
  #attempt = 0;
  #timer = 0;
  #bye = null;
  #welcomed = false;

  /** Connects. The token in `hello` is kept in memory only. */
  open(hello) {
    this.close();
    this.#hello = hello;
    this.#attempt = 0;
    this.#welcomed = false;
    this.#connect();
  }

  /** Leaves the world. */
  close() {
    clearTimeout(this.#timer);
    this.#hello = null;
    const socket = this.#socket;
    this.#socket = null;
    if (socket) {
      if (socket.readyState === WebSocket.OPEN) socket.send('{"t":"bye"}');
      socket.close();
    }
    this.#fail("closed", "the connection was closed");
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  #connect() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/world`);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#bye = null;
    socket.onopen = () => socket.send(JSON.stringify({ t: "hello", protocol: 1, ...this.#hello }));
    socket.onmessage = (message) => {
      if (socket !== this.#socket) return;
      if (typeof message.data === "string") this.#take(JSON.parse(message.data));
      else this.dispatchEvent(new CustomEvent("binary", { detail: message.data }));
    };
    socket.onclose = () => {
      if (socket === this.#socket) this.#closed();
    };
  }

  #closed() {
    this.#socket = null;
    this.#fail("lost", "the connection broke");
    const starts = this.#bye?.code === "world-starting"; // a node of a cluster opens the world
    const again = this.#hello && (this.#welcomed || starts) && !SILENT.has(this.#bye?.code);
    if (again) {
      const wait = RETRY_MILLISECONDS[Math.min(this.#attempt++, RETRY_MILLISECONDS.length - 1)];
      this.#timer = setTimeout(() => this.#connect(), wait);
      this.dispatchEvent(new CustomEvent("retry", { detail: this.#bye }));
    } else {
      this.dispatchEvent(new CustomEvent("end", { detail: this.#bye }));
    }
  }

  #take(message) {
    switch (message.t) {
      case "ping":
        this.#socket.send('{"t":"pong"}');
        return;
      case "bye":
        this.#bye = message;
        return;
      case "welcome":
        this.#attempt = 0;
        this.#welcomed = true;
        this.dispatchEvent(new CustomEvent("welcome", { detail: message }));
        return;
      case "event":
        this.dispatchEvent(new CustomEvent("event", { detail: message }));
        return;
      case "perception":
        if (!this.#settle(message)) this.dispatchEvent(new CustomEvent("perception", { detail: message }));
        return;
      default:
        this.#settle(message);
    }
  }

  #settle(message) {
    const waiting = this.#waiting.get(message.id);
    if (!waiting) return false;
    this.#waiting.delete(message.id);
    if (message.t === "error") waiting.reject(new Refused(message.code, message.message));
    else if (message.t === "result" && !message.accepted) waiting.reject(new Refused(message.code, message.reason));
    else waiting.resolve(message);
    return true;
  }

  #fail(code, reason) {
    for (const { reject } of this.#waiting.values()) reject(new Refused(code, reason));
    this.#waiting.clear();
  }

  /** Sends a message that has an answer. Returns a promise of the answer, which rejects with
   *  Refused if the server refuses the message. */
  ask(t, fields = {}) {
    return new Promise((resolve, reject) => {
      if (!this.isOpen) {
        reject(new Refused("lost", "there is no connection"));
        return;
      }
      const id = this.#next++;
      this.#waiting.set(id, { resolve, reject });
      this.#socket.send(JSON.stringify({ t, id, ...fields }));
    });
  }

  /** Asks a question and returns the content of the report. */
  async report(t, fields) {
    const message = await this.ask(t, fields);
    return { frame: message.frame, ...message.content };
  }

  /** Sends a message without an answer. */
  say(t, fields = {}) {
    if (this.isOpen) this.#socket.send(JSON.stringify({ t, ...fields }));
  }

  /** Requests the next frame of the scene. The bits of `columns` select optional columns; 255 stops
   *  the view. */
  watch(columns) {
    if (this.isOpen) this.#socket.send(new Uint8Array([columns]));
  }
}

// SPDX-License-Identifier: Apache-2.0
// Pictures from the cameras of agents' bodies. The server takes a picture only on request.
import { h } from "./dom.js";

/** First time between two pictures of one camera [ms]. It doubles if the camera needs longer. */
const REPEAT_MILLISECONDS = 250;
const MOST_MILLISECONDS = 8000;

function bytes(base64) {
  return Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
}

/** Functions that convert a layer of a picture to colours of pixels, red, green, blue and alpha. */
const LAYERS = {
  colour: ({ colour }, to) => {
    const from = bytes(colour);
    for (let i = 0, p = 0; p < to.length; i += 3, p += 4) to.set([from[i], from[i + 1], from[i + 2], 255], p);
  },
  /** Near surfaces are light, far surfaces are dark, and pixels without a surface are black. */
  depth: ({ depth }, to) => {
    const distances = new Float32Array(bytes(depth).buffer);
    let near = Infinity;
    let far = 0;
    for (const distance of distances) {
      if (distance > 0) near = Math.min(near, distance);
      far = Math.max(far, distance);
    }
    for (let i = 0, p = 0; p < to.length; i++, p += 4) {
      const grey = distances[i] > 0 ? 255 - (205 * (distances[i] - near)) / Math.max(far - near, 1e-9) : 0;
      to.set([grey, grey, grey, 255], p);
    }
  },
  /** Each item has a colour of its own, and pixels without an item are black. */
  items: ({ items }, to) => {
    const numbers = new Uint16Array(bytes(items).buffer);
    for (let i = 0, p = 0; p < to.length; i++, p += 4) {
      const turn = numbers[i] * 2.399963; // the golden angle keeps the colours of neighbours apart
      const part = (shift) => (numbers[i] === 0 ? 0 : 150 + 90 * Math.cos(turn + shift));
      to.set([part(0), part(2.0944), part(4.1888), 255], p);
    }
  },
};

/** The pictures of one camera. */
class CameraCard {
  constructor(owner, connection, body, sensor) {
    this.owner = owner;
    this.connection = connection;
    this.body = body;
    this.sensor = sensor;
    this.wait = REPEAT_MILLISECONDS;
    const title = `${body}: ${sensor}`;
    this.canvas = h("canvas", { role: "img", "aria-label": `Camera ${sensor} of ${body}`, width: 1, height: 1 });
    this.layer = h("select", { "aria-label": `Layer of the pictures of ${title}`, onchange: () => this.draw() });
    this.repeat = h("input", { type: "checkbox", onchange: () => this.repeat.checked && this.take() });
    this.note = h("p", { className: "doc", role: "status" });
    this.element = h("section", { className: "card picture", "data-camera": title, "aria-label": `Pictures of ${title}` },
      h("header", null, h("h3", null, title),
        h("button", { className: "small", type: "button", "aria-label": `Take a picture with ${title}`, onclick: () => this.take() }, "Take"),
        h("button", { className: "small", type: "button", "aria-label": `Close the pictures of ${title}`, onclick: () => this.close() }, "✕")),
      this.canvas,
      h("div", { className: "row" }, this.layer, h("label", { className: "row" }, this.repeat, "Repeat")),
      this.note);
  }

  async take() {
    if (this.taking || this.closed) return;
    clearTimeout(this.timer);
    this.taking = true;
    try {
      this.image = await this.owner.look(this.connection, { sensor: this.sensor, item: this.body });
      this.show();
    } catch (refused) {
      this.note.textContent = refused.message;
      if (refused.code === "not-yet") this.wait = Math.min(2 * this.wait, MOST_MILLISECONDS);
      else if (refused.code !== "look-pending") this.repeat.checked = false;
    }
    this.taking = false;
    if (this.repeat.checked && !this.closed) this.timer = setTimeout(() => this.take(), this.wait);
  }

  show() {
    const layers = Object.keys(LAYERS).filter((layer) => layer in this.image);
    if (layers.join() !== [...this.layer.options].map((option) => option.value).join()) {
      this.layer.replaceChildren(...layers.map((layer) => new Option(layer, layer)));
    }
    this.layer.hidden = layers.length < 2;
    this.draw();
  }

  draw() {
    if (!this.image) return;
    const { width, height, frame, names } = this.image;
    const layer = this.layer.value;
    this.canvas.width = width;
    this.canvas.height = height;
    const context = this.canvas.getContext("2d");
    const pixels = context.createImageData(width, height);
    LAYERS[layer](this.image, pixels.data);
    context.putImageData(pixels, 0, 0);
    this.canvas.setAttribute("aria-label", `Camera ${this.sensor} of ${this.body}, ${layer}, frame ${frame}`);
    this.note.textContent = `frame ${frame}, ${width} × ${height} px${layer === "items" ? `: ${names.join(", ") || "no item"}` : ""}`;
  }

  close() {
    this.closed = true;
    clearTimeout(this.timer);
    this.element.remove();
    this.owner.cards.delete(this.element.dataset.camera);
  }
}

/** The open pictures. */
export class CameraPictures {
  /** By connection: the last request. A client has one request for a picture at a time. */
  #last = new WeakMap();

  constructor(holder) {
    this.holder = holder;
    this.cards = new Map();
  }

  /** Takes a picture. Opens a card for the camera, if it has none.
   *  @param connection the client that requests the picture
   *  @param body name of the body that carries the camera */
  open(connection, body, sensor) {
    let card = this.cards.get(`${body}: ${sensor}`);
    if (card && card.connection !== connection) card.close();
    if (!card || card.closed) {
      card = new CameraCard(this, connection, body, sensor);
      this.cards.set(`${body}: ${sensor}`, card);
      this.holder.append(card.element);
    }
    card.take();
  }

  look(connection, fields) {
    const before = this.#last.get(connection) ?? Promise.resolve();
    const image = before.then(() => connection.ask("look", fields));
    this.#last.set(connection, image.catch(() => {}));
    return image;
  }

  closeAll() {
    for (const card of [...this.cards.values()]) card.close();
  }
}

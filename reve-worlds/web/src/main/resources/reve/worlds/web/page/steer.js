// SPDX-License-Identifier: Apache-2.0
// A second client of the page: an agent whose body the user steers by the keyboard.
import * as THREE from "three";
import { Connection } from "./connection.js";
import { count, h, toast } from "./dom.js";

const PUSH_MILLISECONDS = 100;
const KEYS = { w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], e: [0, 1, 0], q: [0, -1, 0] };

export class Steer {
  constructor(app, name, token, box, left) {
    this.app = app;
    this.name = name;
    this.box = box;
    this.left = left;
    this.connection = new Connection();
    this.connection.addEventListener("welcome", (event) => this.welcome(event.detail));
    this.connection.addEventListener("perception", (event) => this.perceive(event.detail));
    this.connection.addEventListener("end", (event) => this.end(event.detail));
    this.keys = new Set();
    this.perceived = new Set();
    this.connection.open({ name, role: "agent", world: app.welcome.world, ...(token ? { token } : {}) });
    this.down = (event) => {
      const key = event.key.toLowerCase();
      if (!(key in KEYS) || event.ctrlKey || event.metaKey || event.altKey || this.app.scene.flying || event.target.matches("input, select, textarea")) return;
      this.keys.add(key);
      event.preventDefault();
    };
    this.up = (event) => this.keys.delete(event.key.toLowerCase());
    addEventListener("keydown", this.down);
    addEventListener("keyup", this.up);
    this.timer = setInterval(() => this.push(), PUSH_MILLISECONDS);
  }

  welcome(welcome) {
    this.body = welcome.body;
    this.app.agent = this;
    this.connection.say("perceive", { every: Math.max(1, Math.round(welcome.rate / 6)) });
    const item = this.app.view.byName.get(welcome.body);
    if (item) this.app.select(item.slot, false);
    this.show();
  }

  perceive(message) {
    if (message.items) this.perceived = new Set(message.items.map((item) => item.name));
    for (const name of message.left ?? []) this.perceived.delete(name);
    for (const item of message.entered ?? []) this.perceived.add(item.name);
    const own = (message.items ?? message.changed ?? []).find((item) => item.name === this.body);
    if (own?.actions) {
      this.actions = Object.entries(own.actions).filter(([, parameters]) => {
        const numbers = Object.values(parameters);
        return numbers.length === 1 && numbers[0].type === "number" && numbers[0].components === 3;
      });
      this.show();
    }
    if (this.highlight?.checked) this.mark();
    if (this.count) this.count.textContent = `perceives ${count(this.perceived.size, "item")}`;
  }

  mark() {
    const slots = [...this.perceived].map((name) => this.app.view.byName.get(name)?.slot).filter((slot) => slot !== undefined);
    this.app.scene.highlighted = new Set(this.highlight?.checked ? slots : []);
    this.app.moved = true;
  }

  show() {
    this.count = h("span", { className: "chip" }, `perceives ${count(this.perceived.size, "item")}`);
    this.highlight = h("input", { type: "checkbox", id: "agent-highlight", onchange: () => this.mark() });
    const controls = [];
    if (this.actions?.length) {
      this.action = h("select", { id: "steer-action", "aria-label": "Action that the keys perform" }, this.actions.map(([name]) => new Option(name, name)));
      const [, parameters] = this.actions[0];
      const [parameter] = Object.values(parameters);
      const most = parameter.max ?? 100;
      this.strength = h("input", { type: "range", min: 0, max: most, step: "any", "aria-label": "Strength" });
      this.strength.value = most / 2;
      controls.push(
        h("p", { className: "doc" }, "W A S D push along the view, E and Q up and down."),
        h("div", { className: "row" }, this.action, h("span", { className: "grow" }, this.strength), h("span", { className: "chip" }, parameter.unit ?? "")),
      );
    } else if (this.actions) {
      controls.push(h("p", { className: "doc" }, "This body has no action that takes one vector, so the keys do not steer it. Pick an item to use its actions."));
    }
    this.box.replaceChildren(
      h("div", { className: "card" },
        h("header", null, h("h3", null, `Your body: ${this.body}`), this.count),
        h("label", { className: "row" }, this.highlight, "Dim what it does not perceive"),
        ...controls));
  }

  push() {
    if (this.keys.size === 0 || !this.action || this.pushing || !this.connection.isOpen) return;
    const camera = this.app.scene.camera;
    const ahead = camera.getWorldDirection(new THREE.Vector3()).setY(0).normalize();
    const right = new THREE.Vector3().crossVectors(ahead, camera.up).normalize();
    const along = new THREE.Vector3();
    for (const key of this.keys) {
      const [x, y, z] = KEYS[key];
      along.addScaledVector(right, x).addScaledVector(ahead, z).add(new THREE.Vector3(0, y, 0));
    }
    if (along.lengthSq() === 0) return;
    along.setLength(Number(this.strength.value));
    const [name, parameters] = this.actions.find(([action]) => action === this.action.value);
    this.pushing = true;
    this.connection
      .ask("act", { item: this.body, action: name, arguments: { [Object.keys(parameters)[0]]: along.toArray() } })
      .catch((refused) => {
        toast(`${name}: ${refused.message}`, true);
        this.keys.clear();
      })
      .finally(() => (this.pushing = false));
  }

  leave() {
    this.connection.close();
    this.end({ code: "goodbye" });
  }

  end(bye) {
    if (this.ended) return;
    this.ended = true;
    clearInterval(this.timer);
    removeEventListener("keydown", this.down);
    removeEventListener("keyup", this.up);
    this.app.scene.highlighted = new Set();
    this.box.replaceChildren();
    if (bye && bye.code !== "goodbye") toast(`${bye.message}${bye.hint ? ": " + bye.hint : ""}`, true);
    this.left();
  }
}

// SPDX-License-Identifier: Apache-2.0
// The page of the nodes of a cluster. It shows their load, and where each world runs; it moves worlds
// and drains nodes. It polls the server, so it wakes no world that sleeps.
import { $, count, h, toast } from "./dom.js";

const READ_MILLISECONDS = 1000;
const MOST_ROWS = 500;
const MOST_LINES = 200;
const ANY = "any";

/** Sets the text of an element, if it is another one. */
function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function percent(share) {
  return share === undefined ? "" : `${Math.round(share * 100)} %`;
}

/** Returns the state of a world as one word. */
function stateOf(world) {
  if (world.asleep) return "asleep";
  if (world.node) return "runs";
  return world.running ? "starts" : "waits";
}

const STATE_CLASS = { runs: "chip good", asleep: "chip", starts: "chip warn", waits: "chip warn" };

/** The row of a node. */
class NodeRow {
  constructor(page, name) {
    this.page = page;
    this.name = h("th", { scope: "row" });
    this.status = h("span");
    this.worlds = h("td", { className: "number" });
    this.clients = h("td", { className: "number" });
    this.cpu = h("meter", { min: 0, max: 1, low: 0.7, high: 0.9, optimum: 0 });
    this.cpuText = h("span", { className: "doc" });
    this.memory = h("meter", { min: 0, max: 1, low: 0.7, high: 0.9, optimum: 0 });
    this.memoryText = h("span", { className: "doc" });
    this.agents = h("td", { className: "value" });
    this.drain = h("button", { className: "small", type: "button", onclick: () => page.drain(this.node) });
    this.element = h("tr", { "data-node": name }, this.name, h("td", null, this.status), this.worlds, this.clients,
      h("td", { className: "load" }, this.cpu, this.cpuText), h("td", { className: "load" }, this.memory, this.memoryText), this.agents,
      h("td", { className: "act" }, this.drain));
  }

  show(node, self) {
    this.node = node;
    say(this.name, node.node + (node.node === self ? " (this one)" : ""));
    say(this.status, node.drained ? "drained" : node.watching && node.status === "up" ? "watches" : node.status);
    this.status.className = node.status !== "up" ? "chip bad" : node.drained ? "chip warn" : "chip good";
    this.drain.hidden = Boolean(node.watching);
    this.status.title = node.version === undefined ? "" : `REVE ${node.version}`;
    say(this.worlds, String(node.worlds));
    say(this.clients, node.clients === undefined ? "" : String(node.clients));
    this.cpu.value = node.cpu ?? 0;
    say(this.cpuText, percent(node.cpu));
    this.memory.value = node.memory ?? 0;
    say(this.memoryText, percent(node.memory));
    say(this.agents, node.agents);
    say(this.drain, node.drained ? "End drain" : "Drain");
    this.drain.title = node.drained ? "Let the node run worlds again" : "Move all worlds of the node to other nodes";
  }
}

/** The row of a world. */
class WorldRow {
  constructor(page, name) {
    this.name = h("th", { scope: "row" });
    this.state = h("span");
    this.node = h("td", { className: "value" });
    this.frame = h("td", { className: "number" });
    this.epoch = h("td", { className: "number" });
    this.places = "";
    this.move = h("select", { "aria-label": `Move ${name}`, onchange: () => {
      const node = this.move.value;
      this.move.value = "";
      page.move(name, node);
    } });
    this.element = h("tr", { "data-world": name }, this.name, h("td", null, this.state), this.node, this.frame, this.epoch, h("td", { className: "act" }, this.move));
    this.label = name;
  }

  show(world, nodes) {
    const state = stateOf(world);
    say(this.state, state);
    this.state.className = STATE_CLASS[state];
    say(this.node, (world.node ?? "") + (world.ordered ? (world.ordered === world.node ? " (ordered)" : ` (ordered to ${world.ordered})`) : ""));
    say(this.frame, world.frame < 0 ? "" : String(world.frame));
    say(this.epoch, String(world.epoch));
    const web = nodes.find((node) => node.node === world.node)?.web;
    const link = web ? `${web}?world=${encodeURIComponent(world.world)}` : "";
    if (link !== this.link) {
      this.link = link;
      this.name.replaceChildren(link ? h("a", { href: link, target: "_blank", rel: "noopener" }, this.label) : this.label);
    }
    const places = nodes.filter((node) => node.status === "up" && !node.drained && !node.watching && node.node !== world.node).map((node) => node.node);
    if (places.join("\n") !== this.places || this.move.length === 0) {
      this.places = places.join("\n");
      this.move.replaceChildren(new Option("Move…", ""), ...places.map((place) => new Option(`to ${place}`, place)), new Option("to any node", ANY));
    }
  }
}

class Page {
  constructor() {
    this.token = null;
    this.state = null;
    this.nodes = new Map();
    this.worlds = new Map();
    this.before = new Map();
    this.theme(localStorage.getItem("theme") ?? (matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark"));
    $("theme").onclick = () => this.theme(document.documentElement.dataset.theme === "light" ? "dark" : "light");
    $("filter").oninput = () => this.show();
    $("enter").addEventListener("cancel", (event) => event.preventDefault());
    $("enter-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.token = $("token").value.trim();
      $("token").value = "";
      $("enter").close();
      this.read();
    });
    setInterval(() => this.read(), READ_MILLISECONDS);
    this.read();
  }

  theme(theme) {
    document.documentElement.dataset.theme = theme;
    localStorage.setItem("theme", theme);
  }

  /** Sends a request and returns the answer, or null if the server wants a token. */
  async request(path, method = "GET") {
    const response = await fetch(path, { method, cache: "no-store", headers: this.token ? { Authorization: `Bearer ${this.token}` } : {} });
    const answer = await response.json();
    if (response.ok) return answer;
    if (response.status === 401 || (response.status === 403 && method === "GET")) {
      this.ask(this.token === null ? "This server admits operators with a token." : answer.reason);
      return null;
    }
    throw new Error(answer.reason);
  }

  ask(why) {
    this.connected("a token is needed", "chip warn");
    $("join-why").textContent = why;
    if (!$("enter").open) $("enter").showModal();
  }

  connected(text, className) {
    say($("status"), text);
    $("status").className = className;
    document.body.dataset.state = className.endsWith("good") ? "open" : "closed";
  }

  async read() {
    if (this.reads || document.hidden || $("enter").open) return;
    this.reads = true;
    try {
      const state = await this.request("cluster");
      if (state) {
        this.compare(state);
        this.state = state;
        this.connected("connected", "chip good");
        this.show();
      }
    } catch (failed) {
      this.connected(failed instanceof TypeError ? "no answer" : failed.message, "chip bad");
    } finally {
      this.reads = false;
    }
  }

  async order(path, fields, said) {
    try {
      if (await this.request(`${path}?${new URLSearchParams(fields)}`, "POST")) toast(said);
      this.read();
    } catch (refused) {
      toast(refused.message, true);
    }
  }

  move(world, node) {
    if (node) this.order("cluster/move", { world, node }, node === ANY ? `The cluster chooses the node of ${world}` : `${world} moves to ${node}`);
  }

  drain(node) {
    const drained = !node.drained;
    this.order("cluster/drain", { node: node.node, drained }, drained ? `The worlds of ${node.node} move` : `${node.node} may run worlds again`);
  }

  /** Logs the differences between the last state and the new one. */
  compare(state) {
    const nodes = new Map(state.nodes.map((node) => [node.node, node]));
    for (const [name, node] of nodes) {
      const before = this.state?.nodes.find((each) => each.node === name);
      if (this.state && !before) this.log(`node ${name}: ${node.status}`);
      else if (before && before.status !== node.status) this.log(`node ${name}: ${before.status}, now ${node.status}`, node.status !== "up");
      if (before && before.drained !== node.drained) this.log(`node ${name}: ${node.drained ? "drained" : "may run worlds again"}`);
    }
    for (const before of this.state?.nodes ?? []) {
      if (!nodes.has(before.node)) this.log(`node ${before.node}: has left the cluster`, true);
    }
    for (const world of state.worlds) {
      const before = this.before.get(world.world);
      const place = world.node ?? before?.place;
      if (this.state && !before) this.log(`world ${world.world}: added`);
      if (before) this.#compareWorld(world, before);
      const state = stateOf(world);
      const slept = state === "asleep" || (state !== "runs" && before?.slept === true);
      this.before.set(world.world, { place, epoch: world.epoch, slept });
    }
  }

  #compareWorld(world, before) {
    const state = stateOf(world);
    if (state === "asleep" && !before.slept) this.log(`world ${world.world}: sleeps at frame ${world.frame}`);
    if (state !== "runs") return;
    if (before.slept) this.log(`world ${world.world}: wakes on ${world.node} (epoch ${world.epoch})`);
    else if (!before.place) this.log(`world ${world.world}: on ${world.node} (epoch ${world.epoch})`);
    else if (before.place !== world.node) this.log(`world ${world.world}: from ${before.place} to ${world.node} (epoch ${world.epoch})`);
    else if (before.epoch !== world.epoch) this.log(`world ${world.world}: opened again on ${world.node} (epoch ${world.epoch})`);
  }

  log(text, bad = false) {
    const time = new Date().toLocaleTimeString([], { hour12: false });
    $("moves").prepend(h("li", null, h("span", { className: "frame" }, time), h("span", { className: bad ? "fault" : "" }, text)));
    while ($("moves").children.length > MOST_LINES) $("moves").lastChild.remove();
  }

  show() {
    const state = this.state;
    if (!state) return;
    document.title = `${state.cluster} – REVE`;
    say($("cluster"), state.cluster);
    const asleep = state.worlds.filter((world) => world.asleep).length;
    const awake = state.worlds.filter((world) => world.node).length;
    say($("totals"), `${count(state.nodes.length, "node")} · ${count(state.worlds.length, "world")}: ${awake} run, ${asleep} sleep`);
    this.#rows($("nodes"), this.nodes, state.nodes, (node) => node.node, NodeRow, (row, node) => row.show(node, state.node));
    const words = $("filter").value.trim().toLowerCase();
    const wanted = state.worlds.filter((world) => `${world.world} ${world.node ?? ""} ${stateOf(world)}`.toLowerCase().includes(words));
    this.#rows($("worlds"), this.worlds, wanted.slice(0, MOST_ROWS), (world) => world.world, WorldRow, (row, world) => row.show(world, state.nodes));
    say($("more"), wanted.length > MOST_ROWS ? `and ${wanted.length - MOST_ROWS} more; the search finds them` : wanted.length === 0 ? "no world" : "");
  }

  /** Shows one row for each value, in their order. Rows stay the same elements, so that a list that
   *  is open stays open. */
  #rows(body, known, values, nameOf, Row, show) {
    const names = new Set(values.map(nameOf));
    for (const [name, row] of known) {
      if (!names.has(name)) {
        row.element.remove();
        known.delete(name);
      }
    }
    values.forEach((value, i) => {
      const name = nameOf(value);
      if (!known.has(name)) known.set(name, new Row(this, name));
      const row = known.get(name);
      show(row, value);
      if (body.children[i] !== row.element) body.insertBefore(row.element, body.children[i] ?? null);
    });
  }
}

window.nodes = new Page();

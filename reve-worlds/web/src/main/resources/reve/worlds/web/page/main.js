// SPDX-License-Identifier: Apache-2.0
// The main program of the page: one client of the agent protocol, the view of its world, and the
// panels around it.
import { AgentsPanel } from "./agents.js";
import { Connection } from "./connection.js";
import { $, h, number, toast } from "./dom.js";
import { ItemPanel } from "./item.js";
import { LawsPanel } from "./laws.js";
import { PlotsPanel } from "./plots.js";
import { Scene } from "./scene.js";
import { Sound } from "./sound.js";
import { Transport } from "./transport.js";
import { View } from "./view.js";

const TABS = { item: "Items", laws: "Laws", plots: "Plots", agents: "Agents" };
const SWITCHES = {
  grid: "Ground and grid", shadows: "Shadows", springs: "Springs", surfaces: "Surfaces", labels: "Labels", boxes: "Boxes",
  trails: "Trails", velocity: "Velocities", force: "Forces", sensors: "Sensors",
};
const VELOCITY_BIT = 1, FORCE_BIT = 2, CONTACTS_BIT = 4, STOP = 255;

class App {
  constructor() {
    this.connection = new Connection();
    this.view = new View();
    this.scene = new Scene($("canvas"), $("labels"), this.view);
    this.status = {};
    this.role = null;
    this.agent = null;
    this.moved = false;
    this.#makeTabs();
    this.plots = new PlotsPanel(this, $("panel-plots"));
    this.itemPanel = new ItemPanel(this, $("panel-item"));
    this.laws = new LawsPanel(this, $("panel-laws"));
    this.agents = new AgentsPanel(this, $("panel-agents"));
    this.transport = new Transport(this);
    this.sound = new Sound(this);
    this.#makeSwitches();
    this.#listen();
    this.#theme(localStorage.getItem("theme") ?? (matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark"));
    requestAnimationFrame((now) => this.#draw(now));
    this.#greet();
  }

  // ---- connection ----

  #greet() {
    this.name = `page-${Math.floor(Math.random() * 1e6)}`;
    $("join-name").value = this.name;
    const world = new URLSearchParams(location.search).get("world");
    $("join-world").value = world ?? "";
    this.enter({ name: this.name, role: "control", ...(world ? { world } : {}) });
  }

  enter(hello) {
    this.asked = hello;
    this.#open(hello);
  }

  #open(hello) {
    this.hello = hello;
    this.name = hello.name;
    this.connection.open(hello);
  }

  #listen() {
    const connection = this.connection;
    connection.addEventListener("welcome", (event) => this.#welcome(event.detail));
    connection.addEventListener("binary", (event) => {
      if (this.view.read(event.detail)) {
        this.moved = true;
        this.waiting = false;
        this.received = (this.received ?? 0) + 1;
        this.sound.contacts();
      }
    });
    connection.addEventListener("perception", (event) => {
      this.view.perceive(event.detail);
      this.moved = true;
      this.received = (this.received ?? 0) + 1;
    });
    connection.addEventListener("event", (event) => this.#event(event.detail));
    connection.addEventListener("retry", () => {
      $("status").textContent = "reconnecting…";
      $("status").className = "chip bad";
      document.body.dataset.state = "reconnecting";
    });
    connection.addEventListener("end", (event) => this.#ended(event.detail));
    $("join-form").addEventListener("submit", (event) => {
      event.preventDefault();
      const form = new FormData(event.target);
      const hello = { name: form.get("name").trim(), role: form.get("role") };
      for (const field of ["token", "world"]) if (form.get(field).trim()) hello[field] = form.get(field).trim();
      $("join-token").value = "";
      $("join").close();
      this.enter(hello);
    });
    $("join").addEventListener("cancel", (event) => event.preventDefault());
    $("theme").onclick = () => this.#theme(document.documentElement.dataset.theme === "light" ? "dark" : "light");
    $("fit").onclick = () => this.scene.fit();
    $("follow").onclick = () => this.#toggle("follow", "following");
    $("fly").onclick = () => this.#toggle("fly", "flying");
    const canvas = $("canvas");
    let pressed = null;
    canvas.addEventListener("pointerdown", (event) => (pressed = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 5 && event.button === 0) {
        this.select(this.scene.pick(event.clientX, event.clientY));
      }
      pressed = null;
    });
    addEventListener("keydown", (event) => this.#key(event));
    addEventListener("keyup", (event) => this.scene.keys.delete(event.key.toLowerCase()));
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.connection.watch(STOP);
      this.sound.skip();
      this.waiting = false;
    });
  }

  #welcome(welcome) {
    this.welcome = welcome;
    this.role = welcome.role;
    document.body.dataset.state = "open";
    document.body.dataset.role = welcome.role;
    document.title = `${welcome.world} – REVE`;
    $("world").textContent = welcome.world;
    $("status").textContent = welcome.role;
    $("status").className = "chip good";
    $("transport").hidden = welcome.role !== "control";
    this.view.clear();
    this.scene.showGhost(null);
    $("ahead").setAttribute("aria-pressed", "false");
    this.scene.selected = null;
    this.scene.wasFitted = this.scene.wasFitted && this.shownWorld === welcome.world;
    this.shownWorld = welcome.world;
    this.waiting = false;
    this.itemPanel.list();
    this.laws.clear();
    this.agents.clear();
    this.plots.clear();
    this.transport.state = null;
    this.transport.read();
    if (welcome.role === "agent") this.connection.say("perceive", { every: Math.max(1, Math.round(welcome.rate / 30)) });
  }

  #ended(bye) {
    if (bye?.code === "moved" && this.hello.role === "control") {
      this.#open({ ...this.hello, role: "observer" }); // a node that watches admits observers only
      return;
    }
    this.role = null;
    document.body.dataset.state = "closed";
    $("status").textContent = "not connected";
    $("status").className = "chip bad";
    $("transport").hidden = true;
    const why = bye === null ? "The server cannot be reached." : bye.code === "bad-token" ? "This server admits clients with a token." : `${bye.message}${bye.hint ? ": " + bye.hint : ""}`;
    $("join-why").textContent = why;
    $("join-role").value = this.asked.role;
    $("join-name").value = this.hello.name;
    if (!$("join").open) $("join").showModal();
  }

  #event(event) {
    this.agents.event(event);
    this.sound.event(event.type);
    if (["law-loaded", "law-unloaded", "law-shadow", "over-budget", "fault"].includes(event.type)) this.laws.read();
    if (event.type === "law-shadow") this.laws.shadow(event.fields);
    if (event.type === "rewound") {
      this.plots.clear();
      this.scene.trails.clear();
    }
  }

  // ---- selection and keys ----

  select(slot, open = true) {
    const item = slot === null ? null : this.view.items[slot];
    this.scene.selected = item ? slot : null;
    this.itemPanel.select(item?.name ?? null);
    if (item && open) this.openTab("item");
  }

  #toggle(id, property) {
    this.scene[property] = !this.scene[property];
    $(id).setAttribute("aria-pressed", String(this.scene[property]));
  }

  #key(event) {
    if (event.target.matches("input, select, textarea") || event.ctrlKey || event.metaKey || event.altKey || $("join").open) return;
    const key = event.key.toLowerCase();
    if (this.scene.flying && "wasdqe".includes(key)) {
      this.scene.keys.add(key);
      event.preventDefault();
      return;
    }
    const orbit = { arrowleft: [-1, 0], arrowright: [1, 0], arrowup: [0, -1], arrowdown: [0, 1] }[key];
    if (orbit && event.target === $("canvas")) {
      event.preventDefault();
      event.stopImmediatePropagation();
      this.scene.orbit(...orbit);
    } else if ((key === "+" || key === "-" || key === "=") && event.target === $("canvas")) {
      this.scene.zoom(key === "-" ? 1.15 : 1 / 1.15);
    } else if (key === " " && event.target.tagName !== "BUTTON" && event.target.tagName !== "SUMMARY") {
      event.preventDefault();
      this.transport.toggle();
    } else if (key === ".") this.transport.step();
    else if (key === "f") this.scene.fit();
    else if (key === "c") this.#toggle("follow", "following");
    else if (key === "v") this.#toggle("fly", "flying");
    else if (key === "m") this.sound.toggle();
    else if (key === "/") {
      event.preventDefault();
      this.openTab("item");
      this.itemPanel.search.focus();
    } else if (key === "escape") this.select(null);
  }

  // ---- layout ----

  #makeTabs() {
    for (const [name, label] of Object.entries(TABS)) {
      $("tabs").append(h("button", { id: `tab-${name}`, role: "tab", "aria-controls": `panel-${name}`, type: "button", onclick: () => this.openTab(name) }, label, h("span", { className: "count", hidden: true })));
      $("panels").append(h("div", { id: `panel-${name}`, className: "panel", role: "tabpanel", "aria-labelledby": `tab-${name}`, tabIndex: 0 }));
    }
    $("tabs").addEventListener("keydown", (event) => {
      const names = Object.keys(TABS);
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      const next = names[(names.indexOf(this.tab) + step + names.length) % names.length];
      this.openTab(next);
      $(`tab-${next}`).focus();
    });
    this.openTab("item");
  }

  openTab(name) {
    this.tab = name;
    for (const other of Object.keys(TABS)) {
      const on = other === name;
      $(`tab-${other}`).setAttribute("aria-selected", String(on));
      $(`tab-${other}`).tabIndex = on ? 0 : -1;
      $(`panel-${other}`).hidden = !on;
    }
  }

  badge(tab, count) {
    const badge = $(`tab-${tab}`).querySelector(".count");
    badge.textContent = String(count);
    badge.hidden = count === 0;
  }

  #makeSwitches() {
    for (const [name, label] of Object.entries(SWITCHES)) {
      const box = h("input", { type: "checkbox", id: `show-${name}`, onchange: () => {
        this.scene.options[name] = box.checked;
        this.moved = true;
      } });
      box.checked = this.scene.options[name];
      $("switches").append(h("label", null, box, label));
    }
    document.addEventListener("pointerdown", (event) => {
      if (!$("show").contains(event.target)) $("show").open = false;
    });
  }

  #theme(theme) {
    document.documentElement.dataset.theme = theme;
    localStorage.setItem("theme", theme);
    this.scene.setTheme(theme === "dark");
    this.plots?.theme();
  }

  // ---- drawing ----

  #draw(now) {
    requestAnimationFrame((next) => this.#draw(next));
    const seconds = (now - (this.drawn ?? now)) / 1000;
    this.drawn = now;
    if (!this.waiting && this.role && this.role !== "agent" && !document.hidden && this.connection.isOpen) {
      this.waiting = true;
      this.connection.watch((this.scene.options.velocity ? VELOCITY_BIT : 0) | (this.scene.options.force ? FORCE_BIT : 0) | (this.sound.isOn ? CONTACTS_BIT : 0));
    }
    if (this.listed !== this.view.version) {
      this.listed = this.view.version;
      clearTimeout(this.lister);
      this.lister = setTimeout(() => this.itemPanel.list(), 60);
      if (this.itemPanel.name !== null) {
        const item = this.view.byName.get(this.itemPanel.name);
        this.scene.selected = item?.slot ?? null;
      }
    }
    this.scene.draw(this.moved, seconds);
    this.moved = false;
    this.#count(now);
  }

  #count(now) {
    this.shown = (this.shown ?? 0) + 1;
    if (now - (this.counted ?? 0) < 500) return;
    const span = (now - (this.counted ?? now - 500)) / 1000;
    const kilobytes = (this.view.bytes - (this.bytesBefore ?? 0)) / span / 1000;
    $("fps").textContent = `${Math.round(this.shown / span)} drawn · ${Math.round((this.received ?? 0) / span)} received a second · ${number(Math.round(kilobytes))} kB/s`;
    $("clock").replaceChildren("frame ", h("b", null, String(this.view.frame)), ` · ${this.view.time.toFixed(2)} s`);
    this.counted = now;
    this.shown = this.received = 0;
    this.bytesBefore = this.view.bytes;
  }
}

try {
  window.reve = new App();
} catch (failed) {
  toast(`The page cannot draw: ${failed.message}`, true);
  throw failed;
}

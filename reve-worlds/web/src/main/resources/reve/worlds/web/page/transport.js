// SPDX-License-Identifier: Apache-2.0
// The controls of time. They pause, step, rewind and save the world, set its speed, and show the
// state of the frame loop.
import { $, toast } from "./dom.js";

const READ_MILLISECONDS = 500;
/** Minimum time between two measurements of the clients' round-trip times [ms]. */
const ROUND_TRIP_MILLISECONDS = 2000;
const AHEAD_SECONDS = 2;
const RUN_ICON = "M4.5 2.5l9 5.5-9 5.5z";
const PAUSE_ICON = "M4.5 3h2.5v10H4.5zM9 3h2.5v10H9z";

export class Transport {
  constructor(app) {
    this.app = app;
    this.state = null;
    this.before = null;
    this.measured = -Infinity;
    $("play").onclick = () => this.toggle();
    $("step").onclick = () => this.step();
    $("rewind").onclick = () => this.command("rewind", {}, "rewound to the start");
    $("speed").onchange = () => this.command("speed", { factor: Number($("speed").value) });
    $("keep").onclick = () => this.keep();
    $("ahead").onclick = () => this.ahead();
    $("images").onchange = () => {
      const image = $("images").value;
      $("images").value = "";
      if (image) this.command("rewind", { image }, `rewound to ${image}`);
    };
    setInterval(() => this.read(), READ_MILLISECONDS);
  }

  async command(t, fields, said) {
    try {
      const result = await this.app.connection.ask(t, fields);
      if (said) toast(`${said} (frame ${result.frame})`);
      this.read();
    } catch (refused) {
      toast(refused.message, true);
    }
  }

  toggle() {
    if (this.app.role !== "control") return;
    this.command(this.state?.paused ? "run" : "pause", {});
  }

  async step() {
    if (this.app.role !== "control") return;
    if (!this.state?.paused) await this.command("pause", {});
    this.command("step", { frames: 1 });
  }

  /** Shows or hides a prediction of the world: the places of all items if no agent acts. */
  async ahead() {
    const on = $("ahead").getAttribute("aria-pressed") !== "true";
    $("ahead").setAttribute("aria-pressed", String(on));
    if (!on) {
      this.app.scene.showGhost(null);
      return;
    }
    try {
      const frames = Math.round(AHEAD_SECONDS * this.app.welcome.rate);
      const perception = await this.app.connection.ask("fork", { frames });
      this.app.scene.showGhost(perception.items);
    } catch (refused) {
      $("ahead").setAttribute("aria-pressed", "false");
      toast(refused.message, true);
    }
  }

  keep() {
    const image = prompt("Name of the image", `frame-${this.app.view.frame}`);
    if (image) this.command("snapshot", { image }, `kept as ${image}`);
  }

  async read() {
    const app = this.app;
    if (!app.connection.isOpen || !app.role || app.role === "agent" || document.hidden) return;
    try {
      const state = await app.connection.report("state", this.#measures() ? { roundTrips: true } : {});
      this.show(state);
      app.agents.showClients(state.clients);
      app.plots.state(state, this.state);
      this.state = state;
    } catch {
      // The error is ignored here, because the connection shows the reason.
    }
  }

  /** Returns whether the next report of the state also measures the clients' round-trip times. Only
   *  the panel of agents shows them. */
  #measures() {
    const now = performance.now();
    if (this.app.role !== "control" || this.app.tab !== "agents" || now - this.measured < ROUND_TRIP_MILLISECONDS) return false;
    this.measured = now;
    return true;
  }

  show(state) {
    const play = $("play");
    play.querySelector("path").setAttribute("d", state.paused ? RUN_ICON : PAUSE_ICON);
    play.setAttribute("aria-label", state.paused ? "Run" : "Pause");
    $("speed").disabled = state.fast;
    if (document.activeElement !== $("speed")) {
      const speed = String(state.speed);
      if (![...$("speed").options].some((option) => option.value === speed)) $("speed").add(new Option(`${speed}×`, speed));
      $("speed").value = speed;
    }
    const names = state.images.join("\n");
    if (names !== this.names) {
      this.names = names;
      $("images").replaceChildren(new Option("Rewind to…", ""), ...state.images.map((image) => new Option(image, image)));
    }
    const status = $("status");
    status.textContent = state.paused ? "paused" : state.fast ? "as fast as possible" : state.speed === 1 ? "running" : `running at ${state.speed}×`;
    status.className = state.paused ? "chip warn" : "chip good";
  }
}

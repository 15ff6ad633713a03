// SPDX-License-Identifier: Apache-2.0
// The panel of agents. It shows the agents in the world and the log of events, and lets the user
// join with a body.
import { AuditPanel } from "./audit.js";
import { CameraPictures } from "./camera.js";
import { count, h, number, toast } from "./dom.js";
import { Steer } from "./steer.js";

const EVENTS = 200;
/** Time between two reports of what an agent perceives [ms]. */
const PERCEIVED_MILLISECONDS = 500;

export class AgentsPanel {
  constructor(app, panel) {
    this.app = app;
    this.clients = h("tbody", { id: "clients" });
    this.name = h("input", { id: "agent-name", value: "visitor", "aria-label": "Name of the agent", autocomplete: "off", spellcheck: false });
    this.token = h("input", { id: "agent-token", type: "password", "aria-label": "Token of the agent", autocomplete: "off", placeholder: "token, if the server uses tokens" });
    this.go = h("button", { id: "agent-join", className: "primary", type: "submit" }, "Join");
    this.form = h("form", { className: "inline-form", onsubmit: (event) => { event.preventDefault(); this.join(); } },
      h("label", null, "Name", this.name), h("label", null, "Token", this.token), this.go);
    this.steerBox = h("div", { id: "steer" });
    this.watched = null;
    this.perceives = h("p", { className: "doc", id: "agent-perceives", role: "status", hidden: true });
    setInterval(() => this.readPerceived(), PERCEIVED_MILLISECONDS);
    this.pictureBox = h("div", { id: "pictures" });
    this.pictures = new CameraPictures(this.pictureBox);
    this.audit = new AuditPanel(app);
    this.log = h("ol", { className: "log", id: "events", "aria-label": "Events" });
    panel.append(
      h("h4", null, "In the world"),
      h("table", null, h("thead", null, h("tr", null, ["name", "role", "body", "round trip"].map((t) => h("th", { scope: "col", className: t === "round trip" ? "number" : "" }, t)))), this.clients),
      this.perceives, this.pictureBox,
      h("h4", null, "A body of your own"), this.form, this.steerBox,
      h("h4", null, "Events"), this.log, this.audit.element,
    );
  }

  clear() {
    this.clients.replaceChildren();
    this.shape = null;
    this.watch(null);
    this.pictures.closeAll();
    this.audit.clear();
    this.form.hidden = this.app.role === "agent";
    if (this.app.role === "agent") {
      const { agent, body, cameras } = this.app.welcome;
      this.showClients([{ name: agent, role: "agent", body, cameras, connected: true }]);
    }
  }

  showClients(clients) {
    const shape = JSON.stringify(clients.map((client) => ({ ...client, roundTripSeconds: undefined, shown: this.app.view.byName.has(client.body), looks: Boolean(this.looker(client)) })));
    if (shape !== this.shape) {
      this.shape = shape;
      this.app.status.clients = clients.length;
      this.audit.offer(clients.map((client) => client.name));
      this.roundTrips = new Map();
      this.clients.replaceChildren(...clients.map((client) => this.client(client)));
    }
    for (const client of clients) {
      const cell = this.roundTrips.get(client.name);
      const text = client.roundTripSeconds === undefined ? "–" : `${number(+(client.roundTripSeconds * 1000).toPrecision(2))} ms`;
      if (cell.textContent !== text) cell.textContent = text;
    }
  }

  /** Returns the connection that may take pictures with the cameras of a client's body: that of the
   *  role control, or the client's own. Returns null if the page has no such connection. */
  looker(client) {
    const app = this.app;
    if (app.role === "control" || app.role === "agent") return app.connection;
    return app.agent?.name === client.name ? app.agent.connection : null;
  }

  /** Returns the row of a client. */
  client(client) {
    const item = client.body && this.app.view.byName.get(client.body);
    const roundTrip = h("td", { className: "number", title: "Time from a ping of the server until the answer of the client's program" });
    this.roundTrips.set(client.name, roundTrip);
    const standing = [client.lockStep ? "lock-step" : "", client.limited ? "sensors" : "", client.connected ? "" : "away"].filter(Boolean).join(", ");
    const connection = this.looker(client);
    const cameras = connection === null ? [] : (client.cameras ?? []).map((sensor) =>
      h("button", { className: "small", type: "button", title: `Take a picture with the camera ${sensor}`, "aria-label": `Camera ${sensor} of ${client.body}`,
        onclick: () => this.pictures.open(connection, client.body, sensor) }, `◉ ${sensor}`));
    const watch = client.role !== "agent" || this.app.role === "agent" ? null
      : h("button", { className: "small", type: "button", title: "Dim what this agent does not perceive", "aria-label": `Highlight what ${client.name} perceives`,
        "aria-pressed": String(this.watched === client.name), onclick: () => this.watch(this.watched === client.name ? null : client.name) }, "◎");
    return h("tr", { "data-client": client.name },
      h("td", null, client.name + (client.name === this.app.name ? " (this page)" : "")),
      h("td", null, client.role, standing ? h("span", { className: "standing" }, ` ${standing}`) : null),
      h("td", null, item ? h("button", { className: "small", onclick: () => this.app.select(item.slot) }, client.body) : (client.body ?? "–"), " ", watch, cameras.flatMap((camera) => [" ", camera])),
      roundTrip);
  }

  /** Highlights in the scene what an agent perceives. The argument null ends this. */
  watch(name) {
    this.watched = name;
    this.perceives.hidden = name === null;
    this.perceives.textContent = "";
    this.app.scene.highlighted = new Set();
    this.app.moved = true;
    for (const button of this.clients.querySelectorAll("button[aria-pressed]")) {
      button.setAttribute("aria-pressed", String(button.closest("tr").dataset.client === name));
    }
    this.readPerceived();
  }

  async readPerceived() {
    const { app, watched } = this;
    if (watched === null || !app.connection.isOpen || document.hidden || this.reading) return;
    this.reading = true;
    try {
      const report = await app.connection.report("perceived", { client: watched });
      if (watched === this.watched) this.showPerceived(report);
    } catch (refused) {
      if (refused.code === "no-such-agent" && watched === this.watched) this.watch(null);
    } finally {
      this.reading = false;
    }
  }

  showPerceived({ everything, count: seen, items }) {
    const { scene, view } = this.app;
    this.perceives.textContent = everything ? `${this.watched} perceives everything: its body has no sensors.`
      : seen === 0 ? `${this.watched} has perceived nothing yet.`
      : `${this.watched} perceives ${count(seen, "item")}${items.length < seen ? `, of which ${items.length} are highlighted` : ""}.`;
    scene.highlighted = new Set((items ?? []).map((name) => view.byName.get(name)?.slot).filter((slot) => slot !== undefined));
    this.app.moved = true;
  }

  event(event) {
    const fields = Object.entries(event.fields).filter(([name]) => name !== "sha256" && name !== "source").map(([name, value]) => `${name}=${value}`).join(" ");
    this.log.prepend(h("li", null, h("span", { className: "frame" }, String(event.frame)), h("span", { className: event.type === "fault" ? "fault" : "" }, `${event.type} ${fields}`)));
    while (this.log.children.length > EVENTS) this.log.lastChild.remove();
    if (event.type === "fault") {
      toast(`${event.fields.library ?? event.fields.source ?? "fault"}: ${event.fields.message ?? "a law failed"}`, true);
    }
  }

  join() {
    if (this.steer) {
      this.steer.leave();
      return;
    }
    this.steer = new Steer(this.app, this.name.value.trim(), this.token.value.trim(), this.steerBox, () => {
      this.steer = null;
      this.go.textContent = "Join";
      this.name.disabled = this.token.disabled = false;
      this.app.agent = null;
    });
    this.token.value = "";
    this.go.textContent = "Leave";
    this.name.disabled = this.token.disabled = true;
  }
}

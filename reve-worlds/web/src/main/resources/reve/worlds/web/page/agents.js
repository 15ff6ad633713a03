// SPDX-License-Identifier: Apache-2.0
// The panel of agents. It shows the agents in the world and the log of events, and lets the user
// join with a body.
import { h, toast } from "./dom.js";
import { Steer } from "./steer.js";

const EVENTS = 200;

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
    this.log = h("ol", { className: "log", id: "events", "aria-label": "Events" });
    panel.append(
      h("h4", null, "In the world"),
      h("table", null, h("thead", null, h("tr", null, ["name", "role", "body", ""].map((t) => h("th", { scope: "col" }, t)))), this.clients),
      h("h4", null, "A body of your own"), this.form, this.steerBox,
      h("h4", null, "Events"), this.log,
    );
  }

  clear() {
    this.clients.replaceChildren();
    this.shape = null;
    this.form.hidden = this.app.role === "agent";
  }

  showClients(clients) {
    const shape = JSON.stringify(clients);
    if (shape === this.shape) return;
    this.shape = shape;
    this.app.status.clients = clients.length;
    this.clients.replaceChildren(...clients.map((client) => {
      const item = client.body && this.app.view.byName.get(client.body);
      return h("tr", null,
        h("td", null, client.name + (client.name === this.app.name ? " (this page)" : "")), h("td", null, client.role),
        h("td", null, item ? h("button", { className: "small", onclick: () => this.app.select(item.slot) }, client.body) : (client.body ?? "–")),
        h("td", { className: "unit" }, [client.lockStep ? "lock-step" : "", client.limited ? "sensors" : "", client.connected ? "" : "away"].filter(Boolean).join(", ")));
    }));
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

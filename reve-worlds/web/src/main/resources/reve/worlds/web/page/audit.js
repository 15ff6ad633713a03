// SPDX-License-Identifier: Apache-2.0
// The newest records of the audit log: the messages that the server has sent to clients.
import { fill, h } from "./dom.js";

const READ_MILLISECONDS = 2000;
const RECORDS = 100;

export class AuditPanel {
  constructor(app) {
    this.app = app;
    this.client = h("select", { id: "audit-client", "aria-label": "Client whose records are shown", onchange: () => this.read() }, new Option("all clients", ""));
    this.frequent = h("input", { type: "checkbox", id: "audit-frequent", onchange: () => this.read() });
    this.note = h("p", { className: "doc", id: "audit-note", role: "status" });
    this.records = h("ol", { className: "log", id: "audit", tabIndex: 0, "aria-label": "Newest records of the audit log" });
    this.element = h("details", { id: "audit-panel", ontoggle: () => this.read() },
      h("summary", null, "Audit record"),
      h("label", { className: "row" }, "Client", this.client), h("label", { className: "row" }, this.frequent, "Also perceptions, reports and pings"), this.note, this.records);
    setInterval(() => this.read(), READ_MILLISECONDS);
  }

  /** Prepares the panel for another session, which may have another role. */
  clear() {
    this.element.hidden = this.app.role !== "control";
    this.element.open = false;
    this.note.textContent = "";
    this.records.replaceChildren();
  }

  /** Offers the present clients, and the client that was chosen before. */
  offer(names) {
    const chosen = this.client.value;
    const all = [...new Set([...names, ...(chosen ? [chosen] : [])])].sort();
    const offered = [...this.client.options].slice(1).map((option) => option.value);
    if (all.join("\n") === offered.join("\n")) return;
    this.client.replaceChildren(new Option("all clients", ""), ...all.map((name) => new Option(name, name)));
    this.client.value = chosen;
  }

  async read() {
    const app = this.app;
    if (!this.element.open || app.role !== "control" || app.tab !== "agents" || !app.connection.isOpen || document.hidden || this.reading) return;
    this.reading = true;
    try {
      const client = this.client.value;
      this.show(await app.connection.report("audit", { most: RECORDS, frequent: this.frequent.checked, ...(client ? { client } : {}) }));
    } catch (refused) {
      this.note.textContent = refused.message;
      this.records.replaceChildren();
    } finally {
      this.reading = false;
    }
  }

  show({ records, unrecorded }) {
    this.note.textContent = unrecorded > 0
      ? `${unrecorded} messages have no record, because the file could not be written.`
      : "Messages that the server has sent to clients, the newest first. The file of the record contains all of them in full.";
    // Clients choose their names and texts, so these are shown as text nodes, never as markup.
    fill(this.records, records.map((record) =>
      h("li", null,
        h("time", { className: "frame", dateTime: record.at }, record.at.slice(11, 23)),
        h("b", null, record.client), " ", h("span", { className: "chip" }, record.type), " ",
        h("code", null, record.message + (record.length ? `… (${record.length} characters)` : "")))));
  }
}

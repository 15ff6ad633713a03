// SPDX-License-Identifier: Apache-2.0
// The panel of laws. It lists the loaded laws with the properties that they use, their parameters,
// their cost and their lines in the ledger.
import { count, h, number, toast } from "./dom.js";
import { LawText } from "./lawtext.js";

const READ_MILLISECONDS = 1000;
const MOST_TRIALS = 4;
const PLOT = { width: 260, height: 64 };
const TRUST = {
  shipped: ["shipped", "good", "These are the bytes of a law that ships with REVE."],
  text: ["text", "good", "A law as text accesses only the properties that it declares."],
  operator: ["trusted", "warn", "The operator lets this code run with all rights of the server's account."],
  untrusted: ["not trusted", "warn", "The operator does not trust this code."],
};
const THEN = { warn: "warn", unload: "unload", "skip-steps": "skip steps" };
const ACCESS = { read: "reads", write: "writes", accumulate: "adds to", scratch: "remembers" };

/** Returns the names of the fields that a law reads. */
function fields(law) {
  return law.uses.filter((use) => use.type === "field" && !use.optional).map((use) => use.name);
}

export class LawsPanel {
  constructor(app, panel) {
    this.app = app;
    this.available = h("select", { id: "law-choice", "aria-label": "Law to load", className: "grow" });
    this.load = h("button", { id: "law-load", className: "primary", onclick: () => this.loadLaw() }, "Load");
    this.loader = h("div", { className: "row", id: "law-loader" }, this.available, this.load);
    this.ledgerSwitch = h("input", { type: "checkbox", id: "ledger-on", onchange: () => this.switchLedger() });
    this.list = h("div", { id: "law-list" });
    this.shadows = h("div", { id: "law-shadows" });
    this.trials = new Map();
    this.out = h("div", { id: "law-quarantine" });
    this.editor = new LawText(app, () => this.read());
    panel.append(
      this.loader, this.editor.element,
      this.shadows,
      h("h4", null, "Loaded laws"), this.list,
      this.out,
      h("h4", null, "Ledger"),
      h("label", { className: "row", htmlFor: "ledger-on" }, this.ledgerSwitch, "Record the energy and momentum that each law adds"),
      (this.ledger = h("div", { id: "ledger" })),
    );
    this.cards = new Map();
    setInterval(() => this.read(), READ_MILLISECONDS);
  }

  clear() {
    this.shape = null;
    this.cards.clear();
    this.list.replaceChildren();
    this.out.replaceChildren();
    this.trials.clear();
    this.shadows.replaceChildren();
    this.ledger.replaceChildren();
    this.ledgerSwitch.checked = false;
    this.editor.element.hidden = this.loader.hidden = this.ledgerSwitch.parentElement.hidden = this.app.role !== "control";
    this.read();
  }

  async read() {
    const app = this.app;
    if (!app.connection.isOpen || !app.role || app.role === "agent" || document.hidden || this.reading) return;
    this.reading = true;
    try {
      this.show(await app.connection.report("laws"));
      if (this.ledgerSwitch.checked && app.role === "control") this.showLedger(await app.connection.report("ledger"));
    } catch (refused) {
      if (refused.code === "unsupported") this.list.replaceChildren(h("p", { className: "empty" }, refused.message));
    } finally {
      this.reading = false;
    }
  }

  show(report) {
    const loaded = new Set(report.loaded.map((library) => library.library));
    const choices = report.available.filter((name) => !loaded.has(name));
    if (choices.join() !== this.choices) {
      this.choices = choices.join();
      const chosen = this.available.value;
      this.available.replaceChildren(new Option("Choose a law…", ""), ...choices.map((name) => new Option(name, name)));
      if (choices.includes(chosen)) this.available.value = chosen;
    }
    const shape = JSON.stringify(report.loaded.map((library) => [library.sha256, library.apart, library.trust, library.budget, library.interval, library.laws.map((law) => law.parameters.map((p) => p.value))]));
    if (shape !== this.shape && !this.sliding) {
      this.shape = shape;
      this.cards.clear();
      this.list.replaceChildren(...report.loaded.map((library) => this.card(library)));
      if (report.loaded.length === 0) this.list.append(h("p", { className: "empty" }, "No law is loaded: nothing moves."));
    }
    this.cost(report);
    this.quarantine(report.quarantined);
  }

  card(library) {
    const control = this.app.role === "control";
    return h("section", { className: "card", "data-library": library.library, "aria-label": `Library ${library.library}` },
      h("header", null, h("h3", null, library.library),
        control && library.text ? h("button", { className: "small", "aria-label": `Edit ${library.library}`, onclick: () => this.editor.edit(library.text) }, "Edit") : null,
        control ? h("button", { className: "small danger", "aria-label": `Unload ${library.library}`, onclick: () => this.unload(library.library) }, "Unload") : null,
        this.standing(library)),
      library.text || library.equation ? h("pre", { className: "equation" }, library.text ?? library.equation) : null,
      library.laws.map((law) => {
        const cost = h("span", { className: "chip" }, "");
        this.cards.set(`${library.library}/${law.name}`, { cost });
        return h("div", null,
          h("p", { className: "doc" }, law.doc),
          h("p", { className: "chips" }, h("span", { className: "chip" }, law.phase), h("span", { className: "chip" }, `${law.name} ${law.version}`), cost),
          h("details", null, h("summary", { className: "doc" }, `uses ${count(law.uses.length, "property", "properties")}`),
            h("table", null, h("tbody", null, law.uses.map((use) =>
              h("tr", null,
                h("td", null, use.access.map((access) => ACCESS[access] ?? access).join(", ")),
                h("td", null, `${use.kind}.${use.name}${use.optional ? " (optional)" : ""}`),
                h("td", { className: "unit" }, `${use.components > 1 ? use.components + "×" : ""}${use.type} [${use.unit}]`)))))),
          law.parameters.map((parameter) => this.parameter(library, law, parameter, control)));
      }),
      this.budget(library, control));
  }

  /** Shows where a library runs, why the server runs it, and its budget. */
  standing(library) {
    const [trust, kind, why] = TRUST[library.trust] ?? [library.trust ?? "unknown", "warn", ""];
    const budget = library.budget;
    return h("p", { className: "chips standing" },
      library.apart
        ? h("span", { className: "chip good apart", title: "It runs apart, in a sandboxed process of its own." }, "sandbox")
        : h("span", { className: "chip apart", title: "It runs in the process of the engine, with the other laws." }, "engine"),
      h("span", { className: `chip trust ${kind}`, title: why }, trust),
      h("span", { className: "chip allowed", title: "Computing time that it may take in a frame" },
        budget ? `budget ${number(budget.milliseconds)} ms, then ${THEN[budget.then] ?? budget.then}` : "no budget"));
  }

  /** Shows the budget of a library: the computing time that it may take in a frame, and the
   *  reaction if it takes more. */
  budget(library, control) {
    const given = library.budget ?? { then: "warn" };
    const id = `budget-${library.library}`;
    const field = (properties) => h("input", { type: "number", min: 0, step: "any", className: "exact", disabled: !control,
      onfocus: () => (this.sliding = true), onblur: () => (this.sliding = false), onchange: () => send(), ...properties });
    const milliseconds = field({ id, placeholder: "none", value: given.milliseconds ?? "" });
    const every = field({ "aria-label": `Steps of ${library.library}`, min: 2, step: 1, value: given.every ?? 2, hidden: given.then !== "skip-steps" });
    const then = h("select", { "aria-label": `What happens if ${library.library} exceeds its budget`, disabled: !control, onchange: () => send() },
      new Option("warn", "warn"), new Option("unload it", "unload"), new Option("skip steps", "skip-steps"));
    then.value = given.then;
    const send = async () => {
      this.sliding = false;
      every.hidden = then.value !== "skip-steps";
      const time = milliseconds.valueAsNumber;
      if (!(time > 0) && !library.budget) return;
      const budget = time > 0 ? { milliseconds: time, then: then.value, ...(every.hidden ? {} : { every: every.valueAsNumber }) } : {};
      try {
        await this.app.connection.ask("set-budget", { library: library.library, ...budget });
      } catch (refused) {
        toast(refused.message, true);
        this.shape = null;
      }
      this.read();
    };
    return h("div", { className: "parameter budget" },
      h("label", { htmlFor: id, title: "Computing time that the laws of this library may take in a frame" }, h("span", null, "budget [ms]"), milliseconds),
      h("div", { className: "row" }, then, every,
        library.interval ? h("span", { className: "chip bad" }, `acts in every ${library.interval}. step`) : null));
  }

  parameter(library, law, parameter, control) {
    const low = Number.isFinite(parameter.min) ? parameter.min : Math.min(0, 2 * parameter.value, -Math.abs(parameter.default));
    const high = Number.isFinite(parameter.max) && parameter.max < 1e6 ? parameter.max : Math.max(2 * Math.abs(parameter.value), 2 * Math.abs(parameter.default), 1);
    const unit = parameter.unit && parameter.unit !== "1" ? ` ${parameter.unit}` : "";
    const id = `p-${library.library}-${law.name}-${parameter.name}`;
    const exact = h("input", { id, type: "number", step: "any", disabled: !control, className: "exact",
      onfocus: () => (this.sliding = true),
      onblur: () => (this.sliding = false),
      onchange: () => Number.isFinite(exact.valueAsNumber) && send(exact.valueAsNumber) });
    exact.value = +parameter.value.toPrecision(9);
    const send = async (value) => {
      this.sliding = false;
      exact.value = +value.toPrecision(9);
      try {
        await this.app.connection.ask("set-law", { library: library.library, parameters: { [`${law.name}.${parameter.name}`]: value } });
        this.app.plots.mark(`${law.name}.${parameter.name} = ${number(value)}`);
      } catch (refused) {
        toast(refused.message, true);
        this.shape = null;
      }
      this.read();
    };
    const slider = h("input", { "aria-label": `${parameter.name}, slider`, type: "range", min: low, max: high, step: "any", disabled: !control,
      oninput: () => {
        this.sliding = true;
        exact.value = +Number(slider.value).toPrecision(6);
      },
      onchange: () => send(Number(slider.value)) });
    slider.value = parameter.value;
    return h("div", { className: "parameter" }, h("label", { htmlFor: id, title: parameter.doc }, h("span", null, parameter.name + (unit && ` [${unit.trim()}]`)), exact), slider);
  }

  cost(report) {
    const milliseconds = (seconds) => number(+(seconds * 1000).toPrecision(2));
    for (const library of report.loaded) {
      for (const law of library.laws) {
        const card = this.cards.get(`${library.library}/${law.name}`);
        if (!card) continue;
        card.cost.classList.toggle("warn", law.resting === true);
        if (law.resting) {
          card.cost.textContent = `rests: no law provides ${fields(law).join(" or ")}`;
          card.cost.title = "The server does not evaluate this law until a loaded law provides the field.";
          continue;
        }
        card.cost.textContent = `${milliseconds(law.p50Seconds)} ms per frame (p99 ${milliseconds(law.p99Seconds)} ms), ${number(+(100 * law.share).toPrecision(2))} %`;
        card.cost.title = "Median and 99th percentile of the last frames, and share of the time of all frames";
      }
    }
  }

  quarantine(laws) {
    const shape = JSON.stringify(laws);
    if (shape === this.quarantined) return;
    this.quarantined = shape;
    this.app.badge("laws", laws.length);
    this.out.replaceChildren(
      ...(laws.length ? [h("h4", null, "In quarantine")] : []),
      ...laws.map((law) =>
        h("section", { className: "card bad" },
          h("header", null, h("h3", null, law.library), h("span", { className: "chip bad" }, law.status.toLowerCase().replaceAll("_", " "))),
          h("p", { className: "fault" }, law.message ?? "only the role control sees the message"),
          h("p", { className: "doc" }, `frame ${law.frame}; the world continues as if it had not been there`))),
    );
  }

  /** Handles an event of the trial of a new version of a law. The new version acts in a copy of the
   *  world. */
  shadow(event) {
    const { library, stage, frames } = event;
    if (stage === "begins" || !this.trials.has(library)) {
      this.trials.delete(library);
      this.trials.set(library, { points: [] });
      while (this.trials.size > MOST_TRIALS) this.trials.delete(this.trials.keys().next().value);
    }
    const trial = this.trials.get(library);
    trial.event = event;
    const last = trial.points.at(-1);
    if (last && frames < last.frames) trial.points = []; // the copy has begun again
    if (!last || frames > last.frames || trial.points.length === 0) trial.points.push({ frames, position: event.position, velocity: event.velocity });
    this.shadows.replaceChildren(h("h4", null, "In the shadow"), ...[...this.trials.values()].map((one) => this.trial(one)));
  }

  trial({ event, points }) {
    const difference = (name, unit) => h("p", { className: `doc ${name}` },
      `largest difference of ${name}: ${number(event[name])} ${unit}${event[`${name}Item`] ? ` (${event[`${name}Item`]})` : ""}`);
    return h("section", { className: event.stage === "refused" ? "card bad" : "card", "data-library": event.library, "aria-label": `Trial of ${event.library}` },
      h("header", null, h("h3", null, event.library),
        h("span", { className: event.stage === "refused" ? "chip bad" : event.stage === "accepted" ? "chip good" : "chip" }, event.stage),
        h("span", { className: "chip" }, `${event.frames} of ${event.of} frames`)),
      event.parameters ? h("p", { className: "doc parameters" }, event.parameters) : null,
      this.divergence(points, event.of),
      difference("position", "m"), difference("velocity", "m/s"),
      event.message ? h("p", { className: "fault" }, event.message) : null);
  }

  /** Plots the differences over the frames of a trial. The largest value of each line determines
   *  its scale. */
  divergence(points, of) {
    const lines = ["position", "velocity"].map((name) => {
      const most = Math.max(...points.map((point) => point[name])) || 1;
      const places = points.map((point) =>
        `${((PLOT.width * point.frames) / of).toFixed(1)},${(PLOT.height - 2 - ((PLOT.height - 4) * point[name]) / most).toFixed(1)}`);
      return `<polyline class="${name}" points="${places.join(" ")}"/>`;
    });
    return h("div", { className: "divergence", role: "img",
      "aria-label": "Differences of position and velocity over the frames of the trial",
      innerHTML: `<svg viewBox="0 0 ${PLOT.width} ${PLOT.height}">${lines.join("")}</svg>` });
  }

  async loadLaw() {
    const library = this.available.value;
    if (!library) return;
    this.load.disabled = true;
    try {
      const result = await this.app.connection.ask("load-law", { library });
      toast(`${library} acts from frame ${result.frame} on`);
      this.app.plots.mark(`+ ${library}`);
    } catch (refused) {
      toast(refused.message, true);
    } finally {
      this.load.disabled = false;
      this.read();
    }
  }

  async unload(library) {
    try {
      const result = await this.app.connection.ask("unload-law", { library });
      toast(`${library} was unloaded in frame ${result.frame}`);
      this.app.plots.mark(`− ${library}`);
    } catch (refused) {
      toast(refused.message, true);
    }
    this.read();
  }

  async switchLedger() {
    try {
      this.showLedger(await this.app.connection.report("ledger", { open: this.ledgerSwitch.checked }));
    } catch (refused) {
      this.ledgerSwitch.checked = false;
      toast(refused.message, true);
    }
  }

  showLedger(report) {
    this.app.plots.ledger(report, this.app.view.time);
    if (!report.open) {
      this.ledger.replaceChildren();
      return;
    }
    this.ledger.replaceChildren(
      h("table", null,
        h("caption", { className: "sr" }, "Energy and momentum by law since the ledger was opened"),
        h("thead", null, h("tr", null, ["source", "energy [J]", "potential [J]", "|momentum| [kg·m/s]"].map((name, i) => h("th", { scope: "col", className: i ? "number" : "" }, name)))),
        h("tbody", null, report.lines.map((line) =>
          h("tr", null, h("th", { scope: "row" }, line.name), h("td", { className: "number" }, number(line.energy)),
            h("td", { className: "number" }, line.potentialEnergy === undefined ? "–" : number(line.potentialEnergy)),
            h("td", { className: "number" }, number(Math.hypot(...line.momentum))))))));
  }
}

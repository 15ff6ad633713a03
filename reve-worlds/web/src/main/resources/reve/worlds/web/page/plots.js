// SPDX-License-Identifier: Apache-2.0
// Plots over time. They show the phases of the frame, the energy by law, and any property of any
// item.
import uPlot from "uplot";
import { h, number } from "./dom.js";

const POINTS = 600;
const MARKS = 24;
const COLOURS = ["#4fd1c5", "#f6ad55", "#fc8181", "#90cdf4", "#b794f4", "#68d391", "#f687b3", "#faf089", "#a0aec0"];

/** Returns a number on an axis as a short text. */
function short(value) {
  return Math.abs(value) >= 1e5 ? value.toExponential(1).replace("e+", "e") : number(value);
}

class Plot {
  /** @param marks changes of the laws; the plot shows them as vertical lines */
  constructor(title, unit, holder, marks, onremove) {
    this.marks = marks;
    this.title = title;
    this.unit = unit;
    this.names = [];
    this.data = [[]];
    this.body = h("div");
    this.element = h("section", { className: "plot", "aria-label": `Plot of ${title}` },
      h("header", null, h("h3", null, title + (unit ? ` [${unit}]` : "")),
        onremove ? h("button", { className: "small", "aria-label": `Remove the plot of ${title}`, onclick: onremove }, "✕") : null),
      this.body);
    holder.append(this.element);
  }

  add(time, values) {
    const names = Object.keys(values);
    if (names.join() !== this.names.join()) {
      this.names = names;
      this.data = [[], ...names.map(() => [])];
      this.make();
    }
    const times = this.data[0];
    if (times.length && time < times[times.length - 1]) for (const column of this.data) column.length = 0;
    if (times.length && time === times[times.length - 1]) return;
    times.push(time);
    names.forEach((name, i) => this.data[i + 1].push(values[name]));
    if (times.length > POINTS) for (const column of this.data) column.shift();
    this.stale = true;
  }

  make() {
    this.chart?.destroy();
    this.body.replaceChildren();
    const style = getComputedStyle(document.documentElement);
    const quiet = style.getPropertyValue("--quiet").trim();
    const line = style.getPropertyValue("--line").trim();
    const axis = { stroke: quiet, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 }, font: "11px system-ui", size: 58 };
    this.chart = new uPlot(
      {
        width: Math.max(160, this.element.clientWidth - 18), height: 170, legend: { live: true },
        cursor: { points: { size: 5 } },
        hooks: { draw: [(chart) => this.#drawMarks(chart, quiet)] },
        scales: { x: { time: false } },
        axes: [{ ...axis, size: 30, values: (_, ticks) => ticks.map((t) => `${number(t)} s`) }, { ...axis, values: (_, ticks) => ticks.map(short) }],
        series: [{ label: "time", value: (_, v) => (v === null ? "–" : `${number(v)} s`) },
          ...this.names.map((name, i) => ({ label: name, stroke: COLOURS[i % COLOURS.length], width: 1.5, points: { show: false }, value: (_, v) => (v === null || v === undefined ? "–" : number(v)) }))],
      },
      this.data, this.body);
  }

  #drawMarks(chart, colour) {
    const { ctx, bbox } = chart;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = colour;
    ctx.font = `${10 * devicePixelRatio}px system-ui`;
    ctx.setLineDash([4, 4]);
    for (const { time, label } of this.marks) {
      if (!(time >= chart.scales.x.min && time <= chart.scales.x.max)) continue;
      const x = chart.valToPos(time, "x", true);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText(label, x + 3, bbox.top + 10 * devicePixelRatio);
    }
    ctx.restore();
  }

  draw() {
    if (!this.stale || !this.chart || this.element.offsetParent === null) return;
    this.stale = false;
    const width = Math.max(160, this.element.clientWidth - 18);
    if (width !== this.chart.width) this.chart.setSize({ width, height: 170 });
    this.chart.setData(this.data);
  }

  remove() {
    this.chart?.destroy();
    this.element.remove();
  }
}

export class PlotsPanel {
  constructor(app, panel) {
    this.app = app;
    this.holder = h("div");
    this.hint = h("p", { className: "doc" }, "Press ∿ beside a property of an item to plot it. The ledger (tab Laws) adds a plot of energy.");
    panel.append(this.hint, this.holder);
    this.watched = new Map();
    this.marks = [];
    this.frame = new Plot("Frame time by phase", "ms", this.holder, []);
    setInterval(() => {
      for (const plot of [this.frame, this.energy, ...[...this.watched.values()].map((watch) => watch.plot)]) plot?.draw();
    }, 250);
    setInterval(() => this.readOthers(), 250);
  }

  clear() {
    this.before = null;
    for (const plot of [this.frame, this.energy]) if (plot) for (const column of plot.data) column.length = 0;
    this.marks.length = 0;
  }

  theme() {
    for (const plot of [this.frame, this.energy, ...[...this.watched.values()].map((watch) => watch.plot)]) {
      if (plot?.chart) {
        plot.make();
        plot.stale = true;
      }
    }
  }

  /** Adds, for each phase, the mean time per frame between two reports of the state. */
  state(state, before) {
    if (!before || state.frames <= before.frames) return;
    const values = {};
    for (const [phase, seconds] of Object.entries(state.phaseSeconds)) {
      values[phase] = ((seconds - before.phaseSeconds[phase]) * 1000) / (state.frames - before.frames);
    }
    this.frame.add(performance.now() / 1000, values);
  }

  ledger(report, time) {
    if (!report.open) {
      this.energy?.remove();
      this.energy = null;
      return;
    }
    this.energy ??= new Plot("Energy added by each law", "J", this.holder, this.marks);
    const values = {};
    for (const line of report.lines) values[line.name] = line.energy + (line.potentialChange ?? 0);
    this.energy.add(time, values);
  }

  /** Records a change of the laws. Plots over the world's time show it as a vertical line. */
  mark(label) {
    this.marks.push({ time: this.app.view.time, label });
    if (this.marks.length > MARKS) this.marks.shift();
  }

  add(item, path, unit) {
    const key = `${item} ${path}`;
    if (this.watched.has(key)) return;
    const plot = new Plot(`${item}: ${path}`, unit === "1" ? "" : unit, this.holder, this.marks, () => {
      plot.remove();
      this.watched.delete(key);
    });
    this.watched.set(key, { item, path, plot });
    this.app.openTab("plots");
  }

  wants(item) {
    return [...this.watched.values()].some((watch) => watch.item === item);
  }

  /** Adds the values of the plotted properties from a report about an item. */
  sample(report, time) {
    for (const { item, path, plot } of this.watched.values()) {
      if (item !== report.name) continue;
      const [aspect, ...rest] = path.split(".");
      const value = report[aspect].find?.((property) => property.name === rest.join("."))?.value;
      if (typeof value === "number") plot.add(time, { value });
      else if (Array.isArray(value)) {
        plot.add(time, Object.fromEntries([...value.map((v, i) => [value.length === 3 ? "xyz"[i] : String(i), v]), ...(value.length === 3 ? [["length", Math.hypot(...value)]] : [])]));
      }
    }
  }

  /** Requests reports about the plotted items. The selected item is skipped, because its report is
   *  requested anyway. */
  async readOthers() {
    const app = this.app;
    if (this.reading || !app.connection.isOpen || app.role === "agent" || document.hidden) return;
    const others = new Set([...this.watched.values()].map((watch) => watch.item).filter((item) => item !== app.itemPanel.name));
    if (others.size === 0) return;
    this.reading = true;
    for (const item of others) {
      try {
        this.sample(await app.connection.report("inspect", { item }), app.view.time);
      } catch {
        // The error is ignored, because the item has left the world.
      }
    }
    this.reading = false;
  }
}

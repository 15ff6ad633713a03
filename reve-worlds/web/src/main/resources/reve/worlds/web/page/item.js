// SPDX-License-Identifier: Apache-2.0
// The panel of items. It searches items, and shows the present properties of the selected item by
// its four aspects.
import { count, h, show, toast } from "./dom.js";

const FOUND = 60;
/** Time after the last letter until the server searches the symbols [ms]. */
const SEARCH_MILLISECONDS = 250;
const READ_MILLISECONDS = 200;

export class ItemPanel {
  constructor(app, panel) {
    this.app = app;
    this.name = null;
    this.search = h("input", {
      id: "search", type: "search", placeholder: "Search by name or symbol  ( / )", "aria-label": "Search items by name or symbol",
      autocomplete: "off", spellcheck: false, oninput: () => {
        this.list();
        this.searchSymbols();
      },
      onkeydown: (event) => {
        if (event.key === "Enter") this.found.querySelector("button")?.click();
      },
    });
    this.found = h("ul", { className: "list", id: "found", "aria-label": "Items" });
    this.count = h("p", { className: "doc", id: "found-count" });
    this.heading = h("h2", { id: "item-name" });
    this.body = h("div", { id: "aspects" });
    this.tables = {};
    panel.append(this.search, this.count, this.found, this.body);
    this.timer = setInterval(() => this.read(), READ_MILLISECONDS);
  }

  /** Shows the items that match the search. */
  list() {
    const wanted = this.search.value.trim().toLowerCase();
    const found = [];
    let all = 0;
    for (const item of this.app.view.items) {
      if (!item) continue;
      const named = !wanted || item.name.toLowerCase().includes(wanted) || (item.class ?? item.kind).toLowerCase().includes(wanted);
      const reason = named ? (item.class ?? item.kind) : this.reason(item, wanted);
      if (reason === null) continue;
      all++;
      if (found.length < FOUND) found.push([item, reason]);
    }
    const label = wanted ? `${all} found` : count(all, "item");
    this.count.textContent = all > FOUND ? `${label}, the first ${FOUND} are listed` : label;
    this.found.replaceChildren(
      ...found.map(([item, reason]) =>
        h("li", null,
          h("button", { type: "button", onclick: () => this.app.select(item.slot), "aria-current": String(item.name === this.name) },
            h("span", null, item.name), h("span", { className: "kind" }, reason)))),
    );
  }

  /** Returns the symbols of an item that contain the wanted text, or null. An agent searches what it
   *  perceives, and other roles what the server has found. */
  reason(item, wanted) {
    const symbols = this.app.role === "agent"
      ? Object.fromEntries(Object.entries(item.perceived?.symbols ?? {}).filter(([name, value]) => `${name} ${value}`.toLowerCase().includes(wanted)))
      : this.symbols?.text === wanted ? (this.symbols.found.get(item.name) ?? {}) : {};
    const shown = Object.entries(symbols).map(([name, value]) => `${name}: ${show(value)}`);
    return shown.length ? shown.join(", ") : null;
  }

  /** Asks the server for the items whose symbols contain the wanted text. */
  searchSymbols() {
    clearTimeout(this.searching);
    this.searching = setTimeout(async () => {
      const text = this.search.value.trim().toLowerCase();
      if (text.length < 2 || !this.app.role || this.app.role === "agent") return;
      try {
        const { items } = await this.app.connection.report("search", { text });
        this.symbols = { text, found: new Map(items.map((item) => [item.name, item.symbols])) };
        if (this.search.value.trim().toLowerCase() === text) this.list();
      } catch {
        // The error is ignored: the list shows the items that the page has found by their names.
      }
    }, SEARCH_MILLISECONDS);
  }

  select(name) {
    if (name === this.name) return;
    this.name = name;
    this.report = null;
    this.body.replaceChildren();
    this.list();
    if (name !== null) this.read();
  }

  async read() {
    const app = this.app;
    if (this.name === null || this.reading || document.hidden || app.role === "agent" && !app.view.byName.has(this.name)) return;
    if (app.role === "agent") {
      this.fromPerception(app.view.byName.get(this.name).perceived);
      return;
    }
    if (!app.connection.isOpen || (app.tab !== "item" && !app.plots?.wants(this.name))) return;
    this.reading = true;
    const name = this.name;
    try {
      const report = await app.connection.report("inspect", { item: name });
      if (name === this.name) this.showReport(report);
      app.plots?.sample(report, app.view.time);
    } catch (refused) {
      if (refused.code === "no-such-item" && name === this.name) this.app.select(null);
    } finally {
      this.reading = false;
    }
  }

  fromPerception(item) {
    this.showReport({
      name: item.name, kind: "perceived", semantic: item.symbols ?? {},
      physical: item.location ? [{ name: "location", value: item.location, unit: "m" }, { name: "orientation", value: item.orientation ?? [0, 0, 0, 1], unit: "1" }] : [],
      physics: [],
      access: {
        capabilities: item.capabilities ?? [], sensors: [],
        actions: Object.entries(item.actions ?? {}).map(([name, parameters]) => ({
          name, needs: Object.hasOwn(item.needs ?? {}, name) ? item.needs[name] : [], parameters: Object.entries(parameters).map(([key, value]) => ({ name: key, ...value })),
        })),
      },
    });
  }

  showReport(report) {
    const columns = report.lawColumns ?? [];
    const shape = JSON.stringify([columns.map((column) => [column.library, column.law, column.name]), report.moreLawColumns, report.name, report.physical.map((p) => p.name), report.physics.map((p) => p.name), report.access, Object.keys(report.semantic), this.app.role, Boolean(this.app.agent?.body)]);
    if (shape !== this.shape || !this.body.firstChild) {
      this.shape = shape;
      this.build(report);
    }
    for (const property of report.physical) this.put("physical." + property.name, property);
    for (const property of report.physics) this.put("physics." + property.name, property);
    columns.forEach((column, i) => this.put("laws." + i, column));
    for (const [name, value] of Object.entries(report.semantic)) this.put("semantic." + name, { value });
  }

  put(path, property) {
    const cell = this.cells.get(path);
    if (!cell) return;
    const shown = show(property.value);
    if (cell.textContent !== shown) {
      cell.textContent = shown;
      if (path === "physical.colour") cell.prepend(this.swatch(property.value));
    }
    this.values.set(path, property.value);
  }

  swatch(colour) {
    const swatch = h("span", { className: "swatch" });
    swatch.style.background = colour.slice(0, 7);
    return swatch;
  }

  build(report) {
    this.cells = new Map();
    this.values = new Map();
    const edits = this.app.role === "control";
    const table = (aspect, properties, unit) =>
      h("table", { "aria-label": `${aspect} aspect` },
        h("tbody", null, properties.map((property) => {
          const path = `${aspect}.${property.name}`;
          const value = h("td", { className: "value" });
          this.cells.set(path, value);
          const canEdit = edits && (property.editable || aspect === "semantic" && !["name", "dimensions"].includes(property.name));
          const numeric = aspect !== "semantic" && property.editable && property.name !== "colour" && path !== "physical.width";
          return h("tr", null,
            h("th", { scope: "row", title: property.doc ?? "" }, property.name), value,
            unit ? h("td", { className: "unit" }, property.unit && property.unit !== "1" ? property.unit : "") : null,
            h("td", { className: "act" },
              numeric ? h("button", { className: "small", title: `Plot ${property.name}`, "aria-label": `Plot ${property.name}`, onclick: () => this.app.plots.add(report.name, path, property.unit) }, "∿") : null,
              canEdit ? h("button", { className: "small", title: `Edit ${property.name}`, "aria-label": `Edit ${property.name}`, onclick: () => this.edit(report.name, path, value) }, "✎") : null));
        })));
    const symbols = Object.keys(report.semantic).map((name) => ({ name }));
    this.body.replaceChildren(
      h("h4", null, "Item"),
      h("div", { className: "row" },
        h("h2", { className: "grow", id: "item-name" }, report.name),
        h("span", { className: "chip" }, report.kind),
        h("button", { className: "small", onclick: () => this.app.scene.fit(this.app.view.byName.get(report.name)?.slot ?? null) }, "Show")),
      ...(report.physical.length ? [h("h4", null, "Physical"), table("physical", report.physical, true)] : []),
      h("h4", null, "Semantic"), table("semantic", symbols, false),
      h("h4", null, "Access"), this.access(report),
      h("h4", null, "Physics"),
      report.physics.length ? table("physics", report.physics, true) : h("p", { className: "empty" }, this.app.role === "agent" ? "not perceived" : "none: laws do not move this item"),
      ...this.lawColumns(report),
    );
  }

  /** Returns the table of the columns that laws have of their own, if the item has any. */
  lawColumns(report) {
    const columns = report.lawColumns ?? [];
    const more = report.moreLawColumns ? [h("p", { className: "doc" }, `${count(report.moreLawColumns, "further column")}`)] : [];
    if (!columns.length) return more;
    const rows = columns.map((column, i) => {
      const value = h("td", { className: "value" });
      this.cells.set(`laws.${i}`, value);
      const law = column.law === column.library ? column.law : `${column.library}: ${column.law}`;
      return h("tr", null, h("th", { scope: "row", title: `Column of the law ${law}` }, column.name), value,
        h("td", { className: "unit" }, column.unit && column.unit !== "1" ? column.unit : ""), h("td", { className: "unit" }, law));
    });
    return [h("h4", null, "Columns of laws"), h("table", { id: "law-columns", "aria-label": "columns of laws" }, h("tbody", null, rows)), ...more];
  }

  access(report) {
    const access = report.access;
    const agent = this.app.role === "agent" ? this.app.connection : this.app.agent?.connection;
    const parts = [];
    if (access.capabilities.length) parts.push(h("p", { className: "doc" }, "can: " + access.capabilities.join(", ")));
    if (access.sensors.length) parts.push(h("p", { className: "doc" }, "senses by: " + access.sensors.join(", ")));
    if (access.voice) {
      const limits = Object.entries(access.voice).map(([name, metres]) => `${name} ${metres} m`);
      parts.push(h("p", { className: "doc" }, "speaks: " + (limits.join(", ") || "without limits")));
    }
    for (const action of access.actions) {
      const inputs = new Map();
      const fields = action.parameters.map((parameter) => {
        const type = parameter.type;
        const unit = parameter.unit && parameter.unit !== "1" ? ` [${parameter.unit}]` : "";
        const input = type === "truth"
          ? h("input", { type: "checkbox" })
          : h("input", { autocomplete: "off", spellcheck: false, placeholder: type === "number" ? Array(parameter.components).fill("0").join(", ") : type });
        inputs.set(parameter, input);
        return h("label", { title: parameter.doc ?? "" }, parameter.name + unit, input);
      });
      parts.push(
        h("div", { className: "card" },
          h("h3", null, action.name), action.doc ? h("p", { className: "doc" }, action.doc) : null,
          action.needs.length ? h("p", { className: "doc" }, "needs: " + action.needs.join(", ")) : null,
          h("form", { className: "inline-form", "aria-label": `Action ${action.name}`, onsubmit: (event) => {
            event.preventDefault();
            this.act(agent, report.name, action, inputs);
          } }, fields,
          h("button", { className: "small primary", type: "submit", disabled: !agent, title: agent ? "" : "Join as an agent (tab Agents) to act" }, agent ? "Do it" : "Join to act"))),
      );
    }
    return parts.length ? h("div", null, parts) : h("p", { className: "empty" }, "no actions");
  }

  async act(agent, item, action, inputs) {
    const values = {};
    for (const [parameter, input] of inputs) {
      values[parameter.name] = parameter.type === "truth" ? input.checked
        : parameter.type === "number" ? this.numbers(input.value, parameter.components) : input.value;
    }
    try {
      const result = await agent.ask("act", { item, action: action.name, arguments: values });
      toast(`${item}: ${action.name} in frame ${result.frame}`);
    } catch (refused) {
      toast(refused.message, true);
    }
  }

  numbers(text, components = 1) {
    const values = text.split(/[,\s]+/).filter(Boolean).map(Number);
    return components === 1 ? (values[0] ?? 0) : values;
  }

  edit(item, path, cell) {
    const before = this.values.get(path);
    const text = Array.isArray(before) ? before.map((v) => (typeof v === "number" ? String(+v.toPrecision(9)) : v)).join(", ") : String(before ?? "");
    const input = h("input", { value: text, "aria-label": `New value of ${path}`, spellcheck: false });
    const holder = h("td", { className: "value" }, input);
    cell.replaceWith(holder);
    input.select();
    input.focus();
    let done = false;
    const end = async (save) => {
      if (done) return;
      done = true;
      holder.replaceWith(cell);
      if (!save || input.value === text) return;
      try {
        const result = await this.app.connection.ask("edit", { item, property: path, value: this.value(before, input.value) });
        toast(`${item}: ${path} set in frame ${result.frame}`);
      } catch (refused) {
        toast(refused.message, true);
      }
    };
    input.addEventListener("keydown", (event) => {
      event.stopPropagation();
      if (event.key === "Enter") end(true);
      if (event.key === "Escape") end(false);
    });
    input.addEventListener("blur", () => end(true));
  }

  value(before, text) {
    if (typeof before === "boolean") return text === "yes" || text === "true";
    if (typeof before === "number") return Number(text);
    if (Array.isArray(before)) return text.split(/[,\s]+/).filter(Boolean).map(Number);
    return text;
  }
}

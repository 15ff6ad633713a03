// SPDX-License-Identifier: Apache-2.0
// The editor of laws as text. The user writes a law, or drops a file with a law. The editor loads
// the law into the running world.
import { h, toast } from "./dom.js";

const ENDING = ".law";
const EXAMPLE = `law wind "Drag towards a uniform wind."
  parameter c = 2 kg/s, from 0 to 1e6 kg/s
  parameter w = (5, 0, 0) m/s
  each body:
    force += c (w - velocity)
`;

export class LawText {
  constructor(app, done) {
    this.app = app;
    this.done = done;
    this.text = h("textarea", { id: "law-text", rows: 9, spellcheck: false, autocomplete: "off", wrap: "off",
      "aria-label": "Law as text", "aria-describedby": "law-problems", "aria-keyshortcuts": "Control+Enter",
      onkeydown: (event) => this.#key(event) });
    this.text.value = EXAMPLE;
    this.load = h("button", { id: "law-text-load", className: "primary", title: "Load the text (Ctrl+Enter)", onclick: () => this.send() }, "Load the text");
    const file = h("input", { type: "file", accept: ENDING, id: "law-file", hidden: true, onchange: () => {
      this.take(file.files[0]);
      file.value = "";
    } });
    this.problems = h("pre", { id: "law-problems", role: "status", "aria-live": "polite" });
    this.element = h("details", { id: "law-editor" },
      h("summary", null, "Write a law"),
      this.text, this.problems,
      h("div", { className: "row" }, this.load, h("button", { onclick: () => file.click() }, "Open a file…"), file));
    this.#acceptDrops();
  }

  /** Shows a text in the editor. */
  edit(text) {
    this.text.value = text;
    this.problems.textContent = "";
    this.element.open = true;
    this.text.focus();
    this.text.scrollIntoView({ block: "center" });
  }

  /** Reads a file that contains a law as text, and loads the law. */
  async take(file) {
    if (!file) return;
    this.app.openTab("laws");
    if (!file.name.endsWith(ENDING)) {
      toast(`${file.name} is not a law as text (${ENDING}). The server takes libraries and laws in Python only from the folder of its option --laws.`, true);
      return;
    }
    this.edit(await file.text());
    await this.send(file.name);
  }

  /** Loads the law in the editor. The argument `source` names the text in messages. */
  async send(source = "text") {
    this.load.disabled = true;
    this.problems.textContent = "";
    try {
      const result = await this.app.connection.ask("load-law", { library: source, text: this.text.value });
      const name = /^\s*law\s+(\w+)/m.exec(this.text.value)?.[1] ?? source;
      toast(`${name} acts from frame ${result.frame} on`);
      this.app.plots.mark(`+ ${name}`);
    } catch (refused) {
      this.problems.textContent = refused.message;
      this.problems.scrollIntoView({ block: "nearest" });
      this.#select(refused.message);
    } finally {
      this.load.disabled = false;
      this.done();
    }
  }

  /** Selects the line of the first problem. The message of a problem begins with
   *  source:line:column. */
  #select(message) {
    const place = /:(\d+):(\d+): /.exec(message);
    if (!place) return;
    const lines = this.text.value.split("\n");
    const line = Math.min(Number(place[1]), lines.length) - 1;
    const start = lines.slice(0, line).reduce((sum, before) => sum + before.length + 1, 0);
    this.text.focus();
    this.text.setSelectionRange(start, start + lines[line].length);
  }

  #key(event) {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      this.send();
    }
  }

  #acceptDrops() {
    const hasFiles = (event) => this.app.role === "control" && event.dataTransfer?.types.includes("Files");
    document.addEventListener("dragover", (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      document.body.classList.add("dropping");
    });
    document.addEventListener("dragleave", (event) => event.relatedTarget || document.body.classList.remove("dropping"));
    document.addEventListener("drop", async (event) => {
      document.body.classList.remove("dropping");
      if (!hasFiles(event)) return;
      event.preventDefault();
      for (const file of [...event.dataTransfer.files]) await this.take(file);
    });
  }
}

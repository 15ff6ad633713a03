// SPDX-License-Identifier: Apache-2.0
// Helpers for elements, numbers and messages.

/** Creates an element. A property whose name begins with "on" becomes an event listener. */
export function h(tag, properties, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties ?? {})) {
    if (name.startsWith("on")) {
      element.addEventListener(name.slice(2), value);
    } else if (name in element && !name.includes("-") && name !== "list") {
      element[name] = value;
    } else if (value !== null && value !== undefined && value !== false) {
      element.setAttribute(name, value);
    }
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

export const $ = (id) => document.getElementById(id);

/** Returns a number as text with at most five significant digits. */
export function number(value) {
  if (typeof value !== "number") return String(value);
  if (value === 0 || Object.is(value, -0)) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(3).replace("e+", "e");
  return String(+value.toPrecision(5));
}

/** Returns a number, a list of numbers, a text or a truth value as text. */
export function show(value) {
  if (Array.isArray(value)) return value.length === 0 ? "–" : value.map(show).join(", ");
  if (value === true) return "yes";
  if (value === false) return "no";
  return number(value);
}

/** Returns a number of things as text, such as "1 item" or "2 items". */
export function count(things, one, many = `${one}s`) {
  return `${things} ${things === 1 ? one : many}`;
}

/** Shows a message for some seconds. */
export function toast(message, bad = false) {
  const element = h("div", { className: bad ? "toast bad" : "toast" }, message);
  $("toasts").append(element);
  while ($("toasts").children.length > 5) $("toasts").firstChild.remove();
  setTimeout(() => element.remove(), bad ? 9000 : 4000);
}

/** Replaces the children of an element. Does nothing if the new children look the same. */
export function fill(element, ...children) {
  const next = h("div", null, ...children);
  if (next.innerHTML !== element.innerHTML) element.replaceChildren(...next.childNodes);
}

// Elements, and panels of labelled controls that follow the state.
import { clamp, rounded, withDecimals } from "./vectors.js";

const attributes = /^(role|for|aria-|data-)/;

/**
 * An element. Properties that begin with "on" are listeners, "class" and "text" are what they say.
 */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(properties)) {
    if (value === undefined) continue;
    if (key === "class") element.className = value;
    else if (key === "text") element.textContent = value;
    else if (attributes.test(key)) element.setAttribute(key, value);
    else if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else element[key] = value;
  }
  element.append(...children.flat(3).filter(Boolean));
  return element;
}

export function button(text, onclick, properties = {}) {
  return make("button", { type: "button", text, onclick, ...properties });
}

/**
 * A numbered list of items with buttons: Go, if onGo is given, and Remove, which calls onChange
 * after it.
 */
export function listOf(name, items, textOf, onChange, onGo) {
  return make("ol", { id: `${name}s`, class: "items" }, items.map((item, i) => {
    const act = (text, onclick) => button(text, onclick, { id: `${name}-${i}-${text.toLowerCase()}`,
                                                           "aria-label": `${text}, ${name} ${i + 1}` });
    const remove = () => onChange(items.splice(items.indexOf(item), 1));
    return make("li", {}, make("span", { text: textOf(item, i) }), onGo && act("Go", () => onGo(item)),
                act("Remove", remove));
  }));
}

/** The value to which a key moves a slider, or undefined for other keys. Shift makes fine steps. */
export function keyValue(event, value, low, high) {
  const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 };
  const ends = { Home: low, End: high }, step = (high - low) / (event.shiftKey ? 1000 : 100);
  if (!(event.key in steps) && !(event.key in ends)) return undefined;
  event.preventDefault();
  event.stopPropagation();
  return clamp(ends[event.key] ?? value + steps[event.key] * step, low, high);
}

/** Tells assistive technology what a slider that is not an <input> shows. */
export function describeSlider(element, low, high, value, unit = "") {
  const attributes = { valuemin: low, valuemax: high, valuenow: clamp(value, low, high),
                       valuetext: `${rounded(value)} ${unit}`.trim() };
  for (const [key, text] of Object.entries(attributes)) element.setAttribute(`aria-${key}`, text);
}

/** A colour of a document (a CSS name, "#rrggbb" or linear [r, g, b]) as "#rrggbb". */
export function hexColor(color, otherwise = "#c7bdad") {
  if (Array.isArray(color)) {
    const encoded = color.map((x) => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
    const digits = (x) => Math.round(255 * clamp(x, 0, 1)).toString(16).padStart(2, "0");
    return `#${encoded.map(digits).join("")}`;
  }
  if (!color || color === "none") return otherwise;
  const pen = hexColor.pen ??= document.createElement("canvas").getContext("2d");
  pen.fillStyle = otherwise;
  pen.fillStyle = color;
  return pen.fillStyle.startsWith("#") ? pen.fillStyle : otherwise;
}

/**
 * A part of the page with controls. They are built again only if a signature changes, and never
 * while a pointer holds one of them. The focus stays on the control with the same id.
 *
 * Every control takes {id, label, get, set}: get() returns the value to show, or undefined if there
 * is none; set(value, moving) is called when the user changes it.
 */
export class Panel {
  #refreshers = [];
  #signature = null;
  #isHeld = false;

  /** @param onRelease  is called when a pointer leaves a control */
  constructor(root, onRelease) {
    this.root = root;
    root.addEventListener("pointerdown", () => { this.#isHeld = true; });
    for (const name of ["pointerup", "pointercancel"])
      window.addEventListener(name, () => {
        if (!this.#isHeld) return;
        this.#isHeld = false;
        setTimeout(onRelease);  // after the click that may follow
      });
  }

  show(signature, build) {
    const text = JSON.stringify(signature);
    if (text !== this.#signature) {
      if (this.#isHeld) return;
      this.#signature = text;
      this.#rebuild(build);
    }
    for (const refresh of this.#refreshers) refresh();
  }

  /** Calls a function now and whenever the state changed, until the panel is built again. */
  onRefresh(refresh) {
    this.#refreshers.push(refresh);
  }

  #rebuild(build) {
    const focused = this.root.contains(document.activeElement) ? document.activeElement.id : "";
    const open = new Map([...this.root.querySelectorAll("details[id]")].map((each) => [each.id, each.open]));
    this.#refreshers = [];
    this.root.replaceChildren(...[build()].flat(3).filter(Boolean));
    for (const each of this.root.querySelectorAll("details[id]")) each.open = open.get(each.id) ?? each.open;
    if (focused) document.getElementById(focused)?.focus();
  }

  #labelled(input, label, ...more) {
    return make("div", { class: "row" }, make("label", { for: input.id, text: label }), input, ...more);
  }

  checkbox({ id, label, get, set, isEnabled }) {
    const input = make("input", { id, type: "checkbox", onchange: () => set(input.checked) });
    this.onRefresh(() => {
      input.checked = Boolean(get());
      if (isEnabled) input.disabled = !isEnabled();
    });
    return make("label", { class: "check", for: id }, input, make("span", { text: label }));
  }

  /** `min` and `max` may be functions. */
  slider({ id, label, min, max, get, set, unit = "" }) {
    const text = make("span", { class: "value" }), act = (moving) => set(input.valueAsNumber, moving);
    const input = make("input", { id, type: "range", step: "any", oninput: () => act(true),
                                  onchange: () => act(false) });
    this.onRefresh(() => {
      const value = get();
      [input.min, input.max] = [min, max].map((bound) => typeof bound === "function" ? bound() : bound);
      input.disabled = value === undefined;
      if (value === undefined) return;
      input.value = value;
      text.textContent = `${rounded(value, 4)} ${unit}`.trim();
      input.setAttribute("aria-valuetext", text.textContent);
    });
    return this.#labelled(input, label, text);
  }

  number({ id, label, get, set, unit = "" }) {
    let isTyping = false;
    const input = make("input", { id, type: "number", step: "any", oninput: () => { isTyping = true; },
      onchange: () => {
        isTyping = false;
        if (Number.isFinite(input.valueAsNumber)) set(input.valueAsNumber, false);
      } });
    this.onRefresh(() => {
      const value = get();
      if (isTyping && document.activeElement === input) return;
      input.value = Number.isFinite(value) ? withDecimals(value, 7) : "";
    });
    return this.#labelled(input, unit ? `${label} (${unit})` : label);
  }

  /** @param options  values, or pairs of a value and its text; or a function that returns them */
  select({ id, label, options, get, set }) {
    const input = make("select", { id, onchange: () => set(input.value) });
    const pairs = () => (typeof options === "function" ? options() : options)
      .map((each) => Array.isArray(each) ? each : [each, each]);
    let shown = "";
    this.onRefresh(() => {
      const wanted = pairs(), value = String(get() ?? "");
      if (!wanted.some(([each]) => each === value)) wanted.unshift([value, value || "default"]);
      if (JSON.stringify(wanted) !== shown)
        input.replaceChildren(...wanted.map(([each, text]) => make("option", { value: each, text })));
      shown = JSON.stringify(wanted);
      input.value = value;
    });
    return this.#labelled(input, label);
  }

  color({ id, label, get, set }) {
    const input = make("input", { id, type: "color", oninput: () => set(input.value, true),
                                  onchange: () => set(input.value, false) });
    this.onRefresh(() => { input.value = hexColor(get()); });
    return this.#labelled(input, label);
  }
}

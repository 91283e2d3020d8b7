// The histogram of a field with one handle for each isovalue.
import { button, describeSlider, keyValue, make } from "./controls.js";
import { wheelNotches } from "./gestures.js";
import { clamp, rounded } from "./vectors.js";

const fineSteps = 1000, doubleClickMs = 500;

/**
 * field() returns {name, unit, range, histogram}; marks() returns the isovalues as {id, label,
 * color, value, set(value, moving)}; onAdd takes the isovalue of a layer to add.
 */
export class Histogram {
  #handles = new Map();
  #active = null;  // id of the handle that was used last
  #before = null;  // {id, value, at} of the newest press, for a double click

  constructor({ id, field, marks, onAdd }) {
    Object.assign(this, { field, marks, onAdd, isLogarithmic: true });
    this.canvas = make("canvas", { class: "histogram-counts", role: "img",
                                   "aria-label": `Histogram of ${field().name}` });
    this.track = make("div", { class: "histogram", id }, this.canvas);
    const logarithmic = make("input", { type: "checkbox", id: `${id}-log`, checked: true, onchange: () => {
      this.isLogarithmic = logarithmic.checked;
      this.draw();
    } });
    this.ends = make("p", { class: "ends" });
    this.element = make("div", {}, this.track, this.ends, make("div", { class: "row" },
      make("label", { class: "check", for: logarithmic.id }, logarithmic, "Logarithmic counts"),
      button("Add isovalue", () => this.#addBetween(), { id: `${id}-add` })));
    this.#connect();
    new ResizeObserver(() => this.draw()).observe(this.track);
  }

  refresh() {
    const marks = this.marks(), { range: [low, high], name, unit } = this.field();
    for (const [id, handle] of this.#handles)
      if (!marks.some((mark) => mark.id === id)) {
        handle.remove();
        this.#handles.delete(id);
      }
    for (const { id, value, color, label } of marks) {
      const handle = this.#handles.get(id) ?? this.#makeHandle(id);
      handle.style.left = `${100 * clamp((value - low) / (high - low || 1), 0, 1)}%`;
      handle.style.color = color;
      handle.setAttribute("aria-label", label);
      describeSlider(handle, low, high, value, unit);
    }
    const texts = [rounded(low, 4), unit ? `${name} (${unit})` : name, rounded(high, 4)];
    this.ends.replaceChildren(...texts.map((text) => make("span", { text })));
    if (this.drawnCounts !== this.field().histogram) this.draw();
  }

  /** Draws the counts; the handles are elements of their own. */
  draw() {
    const { canvas } = this, counts = this.drawnCounts = this.field().histogram;
    const width = canvas.width = Math.round(canvas.clientWidth * devicePixelRatio);
    const height = canvas.height = Math.round(canvas.clientHeight * devicePixelRatio);
    const measure = this.isLogarithmic ? Math.log1p : (x) => x, most = measure(Math.max(1, ...counts));
    const pen = canvas.getContext("2d");
    pen.fillStyle = getComputedStyle(canvas).color;
    pen.globalAlpha = 0.45;
    counts.forEach((count, i) => {
      const tall = height * measure(count) / most;
      pen.fillRect(width * i / counts.length, height - tall, width / counts.length, tall);
    });
  }

  #valueAt(event) {
    const [low, high] = this.field().range, box = this.track.getBoundingClientRect();
    return low + (high - low) * clamp((event.clientX - box.left) / box.width, 0, 1);
  }

  #mark(id) {
    return this.marks().find((mark) => mark.id === id);
  }

  #set(mark, value) {
    mark?.set(clamp(value, ...this.field().range), true);
  }

  /** Adds an isovalue in the middle of the widest gap. */
  #addBetween() {
    const [low, high] = this.field().range, values = this.marks().map((mark) => mark.value);
    const ends = [low, ...values.sort((a, b) => a - b), high];
    const gaps = ends.slice(1).map((end, i) => end - ends[i]);
    const widest = gaps.indexOf(Math.max(...gaps));
    this.onAdd(ends[widest] + gaps[widest] / 2);
  }

  #makeHandle(id) {
    const handle = make("div", { class: "handle", id, role: "slider", tabIndex: 0,
      onfocus: () => { this.#active = id; },
      onkeydown: (event) => {
        const mark = this.#mark(id), value = mark && keyValue(event, mark.value, ...this.field().range);
        if (value !== undefined) this.#set(mark, value);
      } });
    this.#handles.set(id, handle);
    this.track.append(handle);
    return handle;
  }

  #connect() {
    const { track } = this;
    track.addEventListener("pointerdown", (event) => this.#press(event));
    track.addEventListener("pointermove", (event) => {
      if (!(event.buttons & 1) || !track.hasPointerCapture(event.pointerId)) return;
      if (event.clientX === this.pressedX) return;  // a handle that is pressed at its edge does not jump
      this.pressedX = undefined;
      this.#set(this.#mark(this.#active), this.#valueAt(event));
    });
    track.addEventListener("dblclick", (event) => {
      const before = this.#before;
      this.#before = null;
      if (before) this.#set(this.#mark(before.id), before.value);  // the first click moved it
      this.onAdd(this.#valueAt(event));
    });
    track.addEventListener("wheel", (event) => {
      const mark = this.#mark(this.#active) ?? this.marks()[0], [low, high] = this.field().range;
      event.preventDefault();
      if (mark) this.#set(mark, mark.value - wheelNotches(event) * (high - low) / fineSteps);
    }, { passive: false });
  }

  #press(event) {
    const value = this.#valueAt(event), marks = this.marks(), now = performance.now();
    if (event.button !== 0 || marks.length === 0) return;
    const pressed = event.target.closest(".handle")?.id;
    const nearest = (a, b) => Math.abs(a.value - value) <= Math.abs(b.value - value) ? a : b;
    const mark = this.#mark(pressed) ?? marks.reduce(nearest);
    if (!this.#before || now - this.#before.at > doubleClickMs)
      this.#before = { id: mark.id, value: mark.value, at: now };
    this.track.setPointerCapture(event.pointerId);
    event.preventDefault();
    this.pressedX = event.clientX;
    this.#handles.get(mark.id)?.focus();
    this.#active = mark.id;
    if (!pressed) this.#set(mark, value);
  }
}

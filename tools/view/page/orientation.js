// The directions of the axes and a scale bar, in the upper right corner of a view. They follow the
// camera at once and are not part of the picture, whose own annotations stand elsewhere by default.
import { extent, frameOf } from "./camera.js";
import { make } from "./controls.js";
import { rounded } from "./vectors.js";

const size = 56, reach = 15, letterReach = 22, widestBar = 110;
const namesOfAxes = { low: "", high: "xyz" };

/** The longest length of 1, 2 or 5 times a power of 10 that is not above a limit. */
export function roundLength(limit) {
  const power = 10 ** Math.floor(Math.log10(limit));
  return power * [5, 2, 1].find((digit) => digit * power <= limit * (1 + 1e-12));
}

export class Orientation {
  #axes = [];
  #isBody = false;

  constructor(overlay, { directions, length_unit: unit }) {
    this.unit = unit;
    const { low, high } = directions ?? namesOfAxes;
    this.#isBody = Boolean(directions);
    const ends = [...high].map((letter, axis) => ({ letter, axis, sign: 1 }))
      .concat([...low].map((letter, axis) => ({ letter, axis, sign: -1 })));
    const template = make("template", { innerHTML:
      `<svg class="directions" viewBox="${-size / 2} ${-size / 2} ${size} ${size}">` +
      ends.map(({ axis }) => `<g class="axis-${axis}"><line x1="0" y1="0"/><text/></g>`).join("") + "</svg>" });
    this.drawing = template.content.firstElementChild;
    this.#axes = ends.map(({ letter, axis, sign }, i) => {
      const element = this.drawing.children[i], [line, text] = element.children;
      text.textContent = letter;
      return { axis, sign, element, line, text };
    });
    this.text = make("div");
    this.bar = make("div", { class: "scale-bar" });
    this.element = make("div", { class: "orientation", role: "img" }, this.drawing,
                        make("div", {}, this.text, this.bar));
    overlay.append(this.element);
  }

  place({ camera, size: [width, height] }) {
    const { right, above, back } = frameOf(camera);
    const facing = this.#axes.map(({ axis, sign, element, line, text }) => {
      const [x, y, depth] = [sign * right[axis], -sign * above[axis], sign * back[axis]];
      for (const [key, value] of [["x2", reach * x], ["y2", reach * y]]) line.setAttribute(key, value);
      for (const [key, value] of [["x", letterReach * x], ["y", letterReach * y]]) text.setAttribute(key, value);
      element.classList.toggle("behind", depth < 0);
      return { depth, element, letter: text.textContent };
    }).sort((a, b) => a.depth - b.depth);
    const inOrder = facing.map(({ element }) => element);  // the nearest last; moving elements is slow
    if (inOrder.some((element, i) => element !== this.drawing.children[i])) this.drawing.append(...inOrder);
    const perPixel = extent(camera) / Math.max(1, height);
    const length = roundLength(perPixel * Math.min(widestBar, width / 3));
    this.bar.style.width = `${length / perPixel}px`;
    const where = camera.ortho_height ? "" : " at the pivot";  // perspective makes the near larger
    this.text.textContent = `${rounded(length, 1)} ${this.unit}`.trim() + where;
    this.element.setAttribute("aria-label", `${this.#towards(facing)}; scale bar: ${this.text.textContent}`);
  }

  /** A sentence: which axis, or which side of a body, faces the viewer. */
  #towards(facing) {
    if (this.#isBody) return `${facing.at(-1).letter} faces the viewer`;
    const most = facing.reduce((a, b) => Math.abs(b.depth) > Math.abs(a.depth) ? b : a);
    return `${most.depth < 0 ? "−" : "+"}${most.letter} faces the viewer`;
  }
}

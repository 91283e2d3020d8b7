// Two views: side by side, or one over the other with a divider.
import { describeSlider, keyValue, make } from "./controls.js";
import { View } from "./view.js";
import { clamp } from "./vectors.js";

export class Comparison {
  layout = "side";
  areLinked = true;
  #share = 50;  // of the first view in a wipe, in percent

  constructor(container, app) {
    Object.assign(this, { container, app });
    const divider = this.divider = make("div", {
      id: "divider", role: "slider", tabIndex: 0, "aria-label": "Divider of the two views",
      onpointerdown: (event) => {
        divider.setPointerCapture(event.pointerId);
        divider.focus();
        event.preventDefault();
      },
      onpointermove: (event) => {
        const box = container.getBoundingClientRect();
        if (divider.hasPointerCapture(event.pointerId))
          this.#divide(100 * (event.clientX - box.left) / box.width);
      },
      onkeydown: (event) => this.#divide(keyValue(event, this.#share, 0, 100) ?? this.#share) });
  }

  get isOn() {
    return this.app.views.length > 1;
  }

  /** Opens a second view, by default with the scene and the camera of the first, or closes it. */
  toggle({ patch, camera } = this.app.views[0]) {
    const { views } = this.app, [first] = views;
    if (this.isOn) {
      views.pop().close();
      this.app.activate(first);
    } else {
      const second = new View("B", this.container, this.app);
      this.app.addView(Object.assign(second, { patch: structuredClone(patch), camera }));
    }
    this.arrange();
  }

  arrange() {
    this.container.dataset.layout = this.isOn ? this.layout : "single";
    if (this.isOn && this.layout === "wipe") this.container.append(this.divider);
    else this.divider.remove();
    this.#divide(this.#share);
    this.app.mark();
    this.app.stateChanged(this.app.active);
    this.app.refresh();
  }

  #divide(share) {
    this.#share = clamp(share, 0, 100);
    this.divider.style.left = `${this.#share}%`;
    describeSlider(this.divider, 0, 100, this.#share, "percent of view A");
    const clips = [`inset(0 ${100 - this.#share}% 0 0)`, `inset(0 0 0 ${this.#share}%)`];
    this.app.views.forEach(({ section }, i) => {
      section.style.clipPath = this.divider.isConnected ? clips[i] : "";
    });
  }

  show(panel) {
    panel.show(this.isOn, () => [
      make("button", { id: "compare", type: "button", "aria-pressed": String(this.isOn), text: "Compare",
                       onclick: () => this.toggle() }),
      this.isOn && panel.select({ id: "layout", label: "Layout",
        options: [["side", "side by side"], ["wipe", "wipe"]], get: () => this.layout,
        set: (layout) => { this.layout = layout; this.arrange(); } }),
      this.isOn && panel.checkbox({ id: "link-cameras", label: "Link cameras", get: () => this.areLinked,
        set: (areLinked) => {
          this.areLinked = areLinked;
          this.app.active.setCamera(this.app.active.camera, false);
        } })]);
  }
}

// One view: a canvas with its own connection, camera and patch of the scene document.
import { Connection } from "./connection.js";
import { make } from "./controls.js";
import { Orientation } from "./orientation.js";
import { at, difference, equal, merge, put } from "./patch.js";
import { decode, drawPicture, readPicture } from "./pictures.js";
import { Prober } from "./prober.js";
import { rounded } from "./vectors.js";

const restMs = 150, largestSide = 4096, lossless = "finished, lossless";
/** Opacity of a boundary around something else, as that of `rhoray render --context`. */
const faint = 0.12;

export class View {
  hello = null;
  camera = null;
  patch = {};
  resolved = null;      // the newest `resolved`, even if it is older than the patch
  drawn = null;         // {request, spacing, isLossless, frame} of the picture in the canvas
  png = null;           // the picture in the canvas, if it is lossless
  finished = null;
  check = null;
  effects = null;       // what each effect of the picture costs
  orientation = null;
  methodMs = {};        // by accuracy or method: ms of the newest finished picture
  markers = [];         // elements of pinned points
  clipHandles = [];     // of the clip region, in the picture (clipping.js)
  layerInfo = new Map();  // by number of a layer: what `resolved` said when it was last drawn
  size = [1, 1];        // of the canvas, CSS pixels
  requestNumber = 0;
  setNumber = 0;        // of the newest state that the program which started the server has set
  isMoving = false;
  isOnline = false;
  state = "connecting";
  numbers = "";
  #isDirty = false;
  #editedAt = 0;        // the first request that has the newest patch
  #restTimer = 0;
  #hasSize = false;
  #rest = null;         // {n, method} of the newest request at rest
  #keepers = [];
  #drawnAt = [];        // times of the pictures of the last second
  #document = null;
  #isOfLink = false;    // the patch is that of a link, and was not drawn yet

  /** @param app  see main.js */
  constructor(name, container, app) {
    this.name = name;
    this.app = app;
    this.canvas = make("canvas", {
      id: name === "A" ? "picture" : "picture-2", tabIndex: 0, role: "application",
      "aria-label": `Picture of the data, view ${name}. Arrow keys turn it, plus and minus zoom.` });
    this.overlay = make("div", { class: "overlay" });
    this.labelName = make("strong");
    this.labelState = make("span", { text: this.state });
    this.label = make("p", { class: "view-label", hidden: true }, this.labelName, ": ", this.labelState);
    this.section = make("section", { class: "view", "aria-label": `View ${name}` },
                        this.canvas, this.overlay, this.label);
    container.append(this.section);
    this.observer = new ResizeObserver((entries) => this.#resize(entries[0]));
    try {  // so that a screen of another resolution is noticed even if the CSS size stays
      this.observer.observe(this.canvas, { box: "device-pixel-content-box" });
    } catch {
      this.observer.observe(this.canvas);
    }
    this.prober = new Prober((message) => this.connection.send(message), app.say);
    this.connection = new Connection({
      onOpen: () => this.#start(),
      onMessage: (message) => this.#take(message),
      onPicture: (buffer, socket) => this.#draw(buffer, socket),
      onLost: (ms) => {
        this.isOnline = false;
        this.prober.reset();
        this.#setState(`no connection; the next try is in ${(ms / 1000).toFixed(1)} s`, true);
      },
      onRefused: () => this.#setState("not let in: open the URL that the program printed last; " +
        "it shows at most 8 views", true),
    });
  }

  close() {
    this.prober.reset();
    this.app.hideRefusal(this);
    clearTimeout(this.#restTimer);
    this.observer.disconnect();
    this.connection.close();
    this.section.remove();
  }

  /** The document that is asked for: that of the server with the patch. */
  get document() {
    return this.#document ??= merge(this.hello?.document ?? {}, this.patch);
  }

  /** Whether `resolved` belongs to the present patch. */
  get isResolved() {
    return this.resolved !== null && this.resolved.n >= this.#editedAt;
  }

  chosen(...path) {
    return at(this.resolved?.document, path);
  }

  /** The value at a path of keys that is asked for, or else what the server chose. */
  value(...path) {
    return at(this.document, path) ?? this.chosen(...path);
  }

  /** Sets a value of the patch at a path of keys; undefined removes it from the patch. */
  set(path, value, moving = false) {
    this.edit((patch) => put(patch, path, value), moving);
  }

  /**
   * Calls a function that changes the patch; what equals the document of the server is then left
   * out.
   */
  edit(act, moving = false) {
    const before = this.document;
    act(this.patch);
    this.#document = merge(this.hello.document, this.patch);
    this.patch = difference(this.hello.document, this.#document) ?? {};
    for (const key of Object.keys(this.patch)) if (equal(this.patch[key], {})) delete this.patch[key];
    if (!equal(before, this.#document)) this.#editedAt = this.requestNumber + 1;
    this.change(moving);
    this.app.refresh(this);
  }

  replacePatch(patch) {
    for (const { number, isAdded } of this.layers) if (isAdded) this.layerInfo.delete(number);
    this.patch = patch;
    this.edit(() => {});
  }

  /** The layers in the order of their numbers: {number, spec, isAdded, info}. */
  get layers() {
    const base = this.hello?.document.layers ?? {};
    return Object.entries(this.document.layers ?? {}).map(([key, spec]) => ({
      number: Number(key), spec, isAdded: !(key in base), info: this.layerInfo.get(Number(key)) ?? [] }));
  }

  /** What is added inside an opaque boundary would not be seen: the boundary becomes faint. */
  addLayer(spec) {
    const around = spec.type === "boundary" ? [] : this.layers.filter(({ spec: other }) =>
      other.type === "boundary" && other.data === spec.data && (other.opacity ?? 1) === 1);
    this.edit((patch) => {
      put(patch, ["layers", String(this.layers.length)], spec);
      for (const { number } of around) put(patch, ["layers", String(number), "opacity"], faint);
    });
  }

  /**
   * Removes a layer that the user added; those behind it get new numbers, because there may be no
   * gap.
   */
  removeLayer(number) {
    const added = this.layers.filter((layer) => layer.isAdded);
    const first = added[0]?.number, kept = added.filter((layer) => layer.number !== number);
    const infos = kept.map((layer) => layer.info);
    this.edit((patch) => {
      for (const layer of added) {
        delete patch.layers[layer.number];
        this.layerInfo.delete(layer.number);
      }
      kept.forEach((layer, i) => {
        patch.layers[first + i] = layer.spec;
        this.layerInfo.set(first + i, infos[i]);
      });
    });
  }

  /** The isovalues of a layer as numbers, as far as they are known. */
  isovalues({ spec, info }) {
    const asked = [spec.isovalue ?? "auto"].flat(), isNumber = (value) => typeof value === "number";
    if (asked.every(isNumber)) return asked;
    return info.flatMap((drawn) => drawn.spec.isovalue).filter(isNumber);
  }

  /** Notes a change; the next animation frame sends it. */
  change(moving = true) {
    this.#isDirty = true;
    this.isMoving = moving;
    clearTimeout(this.#restTimer);
    if (moving) this.#restTimer = setTimeout(() => this.change(false), restMs);
    this.app.schedule();
  }

  setCamera(camera, moving = true, tellsOthers = true) {
    this.camera = camera;
    this.change(moving);
    this.app.cameraMoved(this, moving, tellsOthers);
  }

  /** Sends the newest request, if there is a change; returns whether it did. */
  sendRequest() {
    if (!this.#isDirty || !this.#hasSize || !this.isOnline || !this.camera || document.hidden) return false;
    this.#isDirty = false;
    const n = ++this.requestNumber, size = [this.canvas.width, this.canvas.height];
    const { isMoving: moving, camera, patch: scene, setNumber: set } = this;
    if (!this.connection.send({ n, size, moving, camera, scene, set })) return false;
    this.check = this.effects = null;
    if (moving) return true;
    this.#rest = { n, method: this.method };
    this.app.rested();
    return true;
  }

  get probe() {
    return this.prober.newest;
  }

  get isAtRest() {
    return !this.isMoving && !this.#isDirty && this.drawn?.request === this.requestNumber;
  }

  /** The first layer whose rays look for crossings or maxima. */
  get #tracedLayer() {
    return this.layers.find(({ spec }) => ["isosurface", "mip"].includes(spec.type));
  }

  /** The accuracy of that layer, unless it has a method of its own. */
  get accuracy() {
    const layer = this.#tracedLayer;
    if (layer?.spec.method) return undefined;
    return layer?.spec.accuracy ?? this.document.accuracy ?? layer?.info[0]?.spec.accuracy ??
      this.chosen("accuracy");
  }

  /** Its accuracy or its method. */
  get method() {
    return this.#tracedLayer?.spec.method ?? this.accuracy;
  }

  /** The methods that it can have instead of an accuracy. */
  get methods() {
    return this.#tracedLayer ? this.methodsOf(this.#tracedLayer) : [];
  }

  methodsOf({ spec, info }) {
    const { data } = this.hello;
    return data[spec.data ?? info[0]?.spec.data ?? Object.keys(data)[0]]?.methods?.[spec.type] ?? [];
  }

  /** Asks for the command and the document of this picture. */
  keep(then) {
    this.sendRequest();
    if (this.connection.send({ keep: true })) this.#keepers.push(then);
    else this.app.showError(this, "There is no connection to the server. Try again when the picture is back.");
  }

  #start() {
    this.drawn = null;
    this.requestNumber = this.setNumber = this.#editedAt = 0;
    this.#keepers = [];
    if (this === this.app.views[0]) this.connection.send({ follow: true });
  }

  #take(message) {
    if (message.hello) this.#greet(message.hello);
    if (message.set) this.#takeOver(message.set);
    if (message.resolved) this.#resolve(message.resolved);
    if (message.finished) {
      this.finished = message.finished;
      this.app.hideRefusal(this);
      if (this.#rest?.n === this.finished.n) this.methodMs[this.#rest.method] = this.finished.ms;
    }
    if (message.check && message.check.n === this.requestNumber) this.check = message.check;
    if (message.effects && message.effects.n === this.requestNumber) this.effects = message.effects;
    if (message.probe) this.prober.take(message.probe);
    if (message.keep) this.#kept(message.keep);
    if (message.error) this.#refuse(message.error);
    this.app.refresh(this);
  }

  /** Shows the patch and the camera of a link. */
  openLink({ patch, camera }) {
    this.#isOfLink = Object.keys(patch).length > 0;
    this.replacePatch(patch);
    this.setCamera(camera, false);
  }

  /** Shows why the server refuses a request. A link that it refuses gives way to the start. */
  #refuse(error) {
    if (this.#isOfLink) {
      this.app.showError(this, `The link cannot be shown: ${error}`);
      this.openLink({ patch: {}, camera: this.camera });
    } else {
      this.app.showError(this, error, true);
      this.#setState("refused", true);
    }
  }

  /** One answer may stand for several requests. */
  #kept(keep) {
    const keepers = this.#keepers.splice(0);
    if (keep.error) this.app.showError(this, keep.error);
    else for (const then of keepers) then(keep);
  }

  #greet(hello) {
    const isFirst = !this.hello;
    this.hello = hello;
    this.#document = null;
    this.isOnline = true;
    this.camera ??= hello.camera;
    this.orientation ??= new Orientation(this.overlay, hello);
    if (isFirst) this.app.greeted(this);
    this.#setState("tracing");
    this.change(false);
  }

  /** Shows the state that the program which started the server has set. */
  #takeOver({ n, camera, scene }) {
    this.setNumber = n;
    this.replacePatch(scene);
    this.setCamera(camera ?? this.hello.camera, false);
  }

  #resolve(resolved) {
    this.resolved = resolved;
    if (!this.isResolved) return;  // numbers of layers may have changed
    const specs = Object.values(resolved.document.layers), infos = new Map();
    resolved.origins.forEach((number, i) => {
      const drawn = { spec: specs[i], field: resolved.fields[i], legend: resolved.legend[i] };
      infos.set(number, [...infos.get(number) ?? [], drawn]);
    });
    for (const [number, info] of infos) this.layerInfo.set(number, info);  // hidden layers keep theirs
  }

  async #draw(buffer, socket) {
    const picture = readPicture(buffer);
    try {
      const bitmap = await decode(picture);
      const isStale = socket !== this.connection.socket || picture.frame < this.drawn?.frame;
      if (!isStale) {  // a newer one may have been decoded before
        const { request, spacing, isLossless, frame } = picture;
        drawPicture(this.canvas, bitmap, picture);
        this.drawn = { request, spacing, isLossless, frame };
        this.#isOfLink = false;
        this.png = isLossless ? picture.blob : null;
        const now = performance.now();
        this.#drawnAt = [...this.#drawnAt.filter((time) => now - time < 1000), now];
        this.numbers = `${picture.width} × ${picture.height}, ${picture.ms.toFixed(1)} ms, ` +
          `${this.#drawnAt.length} pictures/s`;
        this.#setState(this.#pictureState(), isLossless);
        const detail = { ...this.drawn, view: this.name };
        if (!performance.getEntriesByName("first picture").length) performance.mark("first picture");
        document.dispatchEvent(new CustomEvent("drawn", { detail }));
      }
      bitmap.close();
    } finally {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ ack: picture.frame }));
    }
  }

  #pictureState() {
    const { spacing, isLossless } = this.drawn;
    if (isLossless) return lossless;
    const waiting = [];
    if ((this.value("image", "antialias") ?? 2) > 1) waiting.push("edges are smoothed");
    const annotations = { ...this.chosen("annotations"), ...this.document.annotations };
    if (Object.values(annotations).some(Boolean)) waiting.push("annotations are drawn");
    const rest = waiting.length && !this.isAtRest ? `; ${waiting.join(" and ")} at rest` : "";
    if (spacing > 1) return `tracing; traced pixels are ${rounded(spacing, 2)} pixels apart${rest}`;
    return this.isAtRest ? "finished; the lossless picture follows" : `every pixel traced${rest}`;
  }

  /** @param isNews  it is read aloud, unless it is what was read last */
  #setState(text, isNews = false) {
    this.state = text;
    this.app.stateChanged(this, isNews);
  }

  #resize(entry) {
    const { canvas } = this, box = entry.devicePixelContentBoxSize?.[0], isFirst = !this.#hasSize;
    if (canvas.clientWidth === 0) return;
    this.size = [canvas.clientWidth, canvas.clientHeight];
    const sides = box ? [box.inlineSize, box.blockSize] : this.size.map((css) => css * devicePixelRatio);
    const factor = Math.min(1, largestSide / Math.max(...sides));  // one for both: a pixel stays a square
    const [width, height] = sides.map((side) => Math.max(1, Math.round(factor * side)));
    this.#hasSize = true;
    this.app.placeOverlay(this);
    if (!isFirst && width === canvas.width && height === canvas.height) return;
    this.#enlarge(width, height);
    this.change(false);
  }

  /** Gives the canvas another size; the old picture fills it until the next one comes. */
  #enlarge(width, height) {
    const { canvas } = this;
    const old = this.drawn && make("canvas", { width: canvas.width, height: canvas.height });
    old?.getContext("2d").drawImage(canvas, 0, 0);
    [canvas.width, canvas.height] = [width, height];
    const pen = canvas.getContext("2d", { alpha: false });
    pen.fillStyle = getComputedStyle(canvas).backgroundColor;
    pen.fillRect(0, 0, width, height);
    if (old) pen.drawImage(old, 0, 0, width, height);
  }
}

// The page of `rhoray view`: connects the views with the panels, the keys and the URL.
import { Bookmarks } from "./bookmarks.js";
import { look, pan, standardViews, turn, zoom, lookAt } from "./camera.js";
import { placeHandles, showClipping } from "./clipping.js";
import { Comparison } from "./compare.js";
import { takeToken } from "./connection.js";
import { Panel, button, make } from "./controls.js";
import { showCost } from "./cost.js";
import { connectGestures } from "./gestures.js";
import { showLayers } from "./layers.js";
import { fromFragment, toFragment } from "./link.js";
import { download, downloadJson } from "./pictures.js";
import { Pins, probeText } from "./pins.js";
import { setOrthographic, showScene } from "./scene_controls.js";
import { ofBrowser, ofTab } from "./storage.js";
import { View } from "./view.js";

const $ = (id) => document.getElementById(id);
const linkMs = 300, keyStep = Math.PI / 36, keyZoom = 1.15, keyPan = 0.05;
const halfFrameMs = 8;  // of a display at 60 Hz

let isScheduled = false, needsRefresh = true, needsPlacing = false, linkTimer = 0, sentAt = 0;
let refusedView = null;  // to which the shown refusal belongs

/** What the views and the panels call when something changes. */
const app = {
  views: [],
  active: null,

  /**
   * Sends changes at once, unless it has just done so, and updates the panels in the next animation
   * frame.
   */
  schedule() {
    if (isScheduled) return;
    isScheduled = true;
    requestAnimationFrame(frame);
    if (performance.now() - sentAt > halfFrameMs) queueMicrotask(sendRequests);
  },
  refresh() {
    needsRefresh = true;
    app.schedule();
  },
  addView(view) {
    app.views.push(view);
    connectGestures(view, { hover, click, doubleClick });
    for (const name of ["pointerdown", "focusin"])
      view.section.addEventListener(name, () => app.activate(view), { capture: true });
  },
  activate(view) {
    if (app.active === view) return;
    app.active = view;
    app.mark();
    app.stateChanged(view);
    app.refresh();
  },
  /** Marks the view that the panels edit. */
  mark() {
    const areTwo = app.views.length > 1;
    for (const view of app.views) {
      const isActive = view === app.active;
      view.section.classList.toggle("active", areTwo && isActive);
      view.label.hidden = !areTwo;
      view.labelName.textContent = `View ${view.name}${isActive ? ", edited by the panels" : ""}`;
    }
    $("state").hidden = areTwo;
  },
  greeted(view) {
    if (view !== app.views[0]) return;
    document.title = `${view.hello.title}: Rhoray`;
    $("title").textContent = view.hello.title;
    $("program").textContent = view.hello.program;
    makeStandardViews(view);
    restore(view);
    restoreAfterReload();
  },
  /** Follows a change of the camera, which has scheduled a frame. */
  cameraMoved(view, moving, tellsOthers) {
    needsPlacing = true;
    if (view === app.active) $("probe").textContent = "";
    const others = tellsOthers && comparison.areLinked ? app.views.filter((each) => each !== view) : [];
    for (const other of others) other.setCamera(view.camera, moving, false);
  },
  placeOverlay(view) {
    if (!view.hello || !view.camera) return;
    placeHandles(view);
    pins.place(view);
    view.orientation.place(view);
  },
  stateChanged(view, isNews = false) {
    if (view.labelState.textContent !== view.state) view.labelState.textContent = view.state;
    if (view !== app.active) return;
    const text = app.views.length > 1 ? `View ${view.name}: ${view.state}` : view.state;
    if ($("state").textContent !== text) $("state").textContent = text;
    if (isNews && $("announcement").textContent !== text) $("announcement").textContent = text;
    $("numbers").textContent = view.numbers;
  },
  rested() {
    clearTimeout(linkTimer);
    linkTimer = setTimeout(writeLink, linkMs);
  },
  /** @param isRefusal  of a request: it is hidden when a later one of this view is finished */
  showError(view, text, isRefusal = false) {
    $("alert-text").textContent = app.views.length > 1 ? `View ${view.name}: ${text}` : text;
    $("alert").hidden = false;
    refusedView = isRefusal ? view : null;
  },
  hideRefusal(view) {
    if (view === refusedView) $("alert").hidden = true;
  },
  say,
};

const pins = new Pins(app.refresh), bookmarks = new Bookmarks(app.refresh);
const comparison = new Comparison($("views"), app);
const panels = Object.fromEntries([...document.querySelectorAll("[id^=panel-]")]
  .map((root) => [root.id.slice("panel-".length), new Panel(root, app.refresh)]));

function sendRequests() {
  for (const view of app.views) if (view.sendRequest()) sentAt = performance.now();
}

function frame() {
  isScheduled = false;
  sendRequests();
  const view = app.active;
  if (needsRefresh && view?.hello) showPanels(view);
  if (needsPlacing) app.views.forEach(app.placeOverlay);
  needsPlacing = false;
}

function showPanels(view) {
  needsRefresh = false;
  needsPlacing = true;
  showLayers(panels.layers, view);
  showClipping(panels.clipping, view, app.placeOverlay);
  showScene(panels.scene, view);
  pins.show(panels.measuring, view.hello.title);
  showCost(panels.cost, view);
  bookmarks.show(panels.bookmarks, view);
  comparison.show(panels.compare);
  const notes = view.resolved?.notes ?? [];
  panels.notes.show(notes, () => notes.map((text) => make("li", { text })));
}

function makeStandardViews(view) {
  $("standard-views").replaceChildren(
    ...standardViews(view.hello).map(([name], i) =>
      button(name, () => lookFrom(i), { title: `Key ${i + 1}` })),
    button("first view", reset, { title: "Key R", id: "reset" }));
}

function hover(view, pixel) {
  view.prober.hover(pixel, (answer) => {
    if (answer && view.isAtRest) $("probe").textContent = probeText(answer);
  });
}

async function click(view, pixel) {
  const answer = await view.prober.ask(pixel);
  if (answer) $("probe").textContent = probeText(answer);
  pins.add(answer);
}

/** The point that was hit becomes the pivot. */
async function doubleClick(view, pixel) {
  const answer = await view.prober.ask(pixel);
  if (answer) makePivot(view, answer);
}

/** The view turns around the point of a probe from now on. */
function makePivot(view, answer) {
  if (answer.position) view.setCamera(lookAt(view.camera, answer.position), false);
  say(answer.position ? `The view turns around this point from now on. ${probeText(answer)}` : probeText(answer));
}

/** The newest point, or else the newest pin or what is in the middle, becomes the pivot. */
async function pivotByKey() {
  const view = app.active;
  const known = [view.prober.newest, pins.list.at(-1)].find((answer) => answer?.position);
  const answer = known ?? await view.prober.ask(middlePixel(view));
  if (answer) makePivot(view, answer);
}

const middlePixel = ({ canvas }) => [canvas.width, canvas.height].map((side) => Math.floor(side / 2));

async function probeCentre() {
  const answer = await app.active.prober.ask(middlePixel(app.active));
  if (answer) say(probeText(answer));
}

function pinNewest() {
  const answer = app.active.prober.newest;
  say(pins.add(answer) ? `Pinned. ${probeText(answer)}` : "There is no point to pin. Press P first.");
}

/** Shows a text in the line of the probe, and has it read aloud. */
function say(text) {
  $("probe").textContent = $("announcement").textContent = text;
}

const fragment = () => toFragment(app.active.hello, app.active.camera, app.active.patch);

/** Writes the state into the URL. The token is never part of it. */
function writeLink() {
  if (app.active.hello)
    history.replaceState(null, "", `${location.pathname}#${fragment()}`.replace(/#$/, ""));
}

function restore(view) {
  try {
    view.openLink(fromFragment(view.hello, location.hash.slice(1)));
  } catch (error) {
    app.showError(view, error.message);
  }
}

/** Below a proxy, several viewers have the same origin. */
const reloadKey = () => `rhoray-page:${location.pathname}`;

/** Keeps for this tab what a reload would lose. */
function keepForReload() {
  const { layout, areLinked } = comparison, { list, count } = bookmarks;
  const views = app.views.map(({ patch, camera }) => ({ patch, camera }));
  ofTab.set(reloadKey(), JSON.stringify({ hash: location.hash, pins: pins.list, bookmarks: { list, count }, views,
                                          comparison: { layout, areLinked } }));
}

/** Shows what was kept, if the page was reloaded and its link is still the same. */
function restoreAfterReload() {
  const isReload = performance.getEntriesByType("navigation")[0]?.type === "reload";
  const kept = isReload && JSON.parse(ofTab.get(reloadKey()));
  if (!kept || kept.hash !== location.hash) return;
  pins.list.push(...kept.pins);
  Object.assign(bookmarks, kept.bookmarks);
  Object.assign(comparison, kept.comparison);
  const [first, second] = kept.views;
  app.views[0].openLink(first);
  if (second) comparison.toggle(second);
}

window.addEventListener("pagehide", () => {
  if (app.active.hello) keepForReload();
});
window.addEventListener("hashchange", () => {
  takeToken();
  if (app.active.hello) restore(app.active);
});

const lookFrom = (i) => {
  const [, direction, up] = standardViews(app.active.hello)[i];
  app.active.setCamera(look(app.active.camera, direction, up), false);
};
const reset = () => app.active.setCamera(app.active.hello.camera, false);
const move = (act) => app.active.setCamera(act(app.active.camera, app.active.hello.up));
const enlarge = (factor) => move((camera) => zoom(camera, factor));
const showHelp = () => $("help").showModal();

/** The token is a secret of this server, and therefore not part of links. */
const linkUse = "To open it elsewhere, append the part after # to the URL that the program printed, as in " +
  "…#token=…&iso=0.4.";

/** Copies a text, and shows it in case that the browser does not allow to copy. */
async function copy(text, what, use = "") {
  $("copied").textContent = text;
  try {
    await navigator.clipboard.writeText(text);
    say(`${what} copied. ${use}`.trim());
  } catch {
    getSelection().selectAllChildren($("copied"));
    say(`${what}: select and copy the text in the panel. ${use}`.trim());
  }
}

const askCommand = () => app.active.keep(({ command }) => copy(command, "Command"));
const saveScene = () => app.active.keep((kept) =>
  downloadJson(kept.document, `${app.active.hello.title}.json`));

function savePng() {
  const { png, isAtRest, hello } = app.active;
  if (png && isAtRest) download(png, `${hello.title}.png`);
  else app.showError(app.active, "The picture is not finished yet. Try again when it is lossless.");
}

const buttons = { command: askCommand, "save-scene": saveScene, save: savePng,
                  "copy-link": () => { writeLink(); copy(location.href, "Link", linkUse); } };
for (const [id, act] of Object.entries(buttons))
  $(id).addEventListener("click", () => { if (app.active.hello) act(); });
$("help-button").addEventListener("click", showHelp);
$("alert-close").addEventListener("click", () => { $("alert").hidden = true; app.active.canvas.focus(); });

const keys = {
  "+": () => enlarge(keyZoom), "=": () => enlarge(keyZoom), "-": () => enlarge(1 / keyZoom),
  r: reset, c: askCommand, s: savePng, d: saveScene,
  l: buttons["copy-link"], p: probeCentre, t: pivotByKey,
  b: () => bookmarks.add(app.active), v: () => comparison.toggle(),
  o: () => setOrthographic(app.active, !app.active.camera.ortho_height), "?": showHelp, h: showHelp,
};
const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/**
 * Whether keys of one character act. Users who dictate switch them off, because spoken words would
 * press them. The browser remembers this for the page's address.
 */
const characterKeys = {
  key: "rhoray-character-keys",
  box: $("character-keys"),
  restore() {
    this.box.checked = ofBrowser.get(this.key) !== "off";
  },
  store() {
    ofBrowser.set(this.key, this.box.checked ? "on" : "off");
  },
};
characterKeys.restore();
characterKeys.box.addEventListener("change", () => characterKeys.store());

/** What a key does; in panels the arrow keys and Enter keep their own meaning. */
function actOf(event) {
  const arrow = arrows[event.key], isPicture = event.target.matches("body, .view canvas");
  if (arrow || event.key === "Enter") {
    if (!isPicture) return null;
    if (!arrow) return pinNewest;
    const [x, y] = arrow;
    if (event.shiftKey) return () => move((camera) => pan(camera, x * keyPan, y * keyPan));
    return () => move((camera, up) => turn(camera, up, x * keyStep, y * keyStep));
  }
  if (!characterKeys.box.checked) return undefined;
  if (event.key >= "1" && event.key <= "6") return () => lookFrom(Number(event.key) - 1);
  return keys[event.key.toLowerCase()];
}

document.addEventListener("keydown", (event) => {
  const isTaken = event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey ||
    $("help").open || event.target.matches("input:not([type=checkbox], [type=range]), select");
  if (isTaken || !app.active.hello) return;
  const act = actOf(event);
  if (!act) return;
  event.preventDefault();
  act();
});
document.addEventListener("visibilitychange", () => {
  if (!document.hidden) app.views.forEach((view) => view.change(false));
});

takeToken();
app.addView(new View("A", $("views"), app));
app.activate(app.views[0]);
comparison.arrange();

/**
 * For tests and for curious users: `views` and `active` are View objects (view.js) with name,
 * canvas, camera, patch, resolved, drawn ({request, spacing, isLossless}), isAtRest, state, probe,
 * finished and check; `pins` are the pinned probes; `fragment` is the state as in a link.
 */
window.rhoray = {
  views: app.views,
  pins: pins.list,
  get active() { return app.active; },
  get fragment() { return fragment(); },
};

// The panel of the clip region, and its handles in the picture.
import { frameOf, project } from "./camera.js";
import { button, describeSlider, keyValue, make } from "./controls.js";
import { equal, put } from "./patch.js";
import { add, clamp, corners, cross, distance, dot, length, middle, scale, subtract, unit } from "./vectors.js";

const axes = ["x", "y", "z"], thinnestShare = 1e-3;
/** Handles of planes stand in rows of five, this share of the diagonal apart. */
const handleShare = 0.08, handleRow = 5;
/** A slice on the cut is moved by this share of the diagonal into what is shown. */
const sliceShift = 1e-6;

const clipOf = (view) => view.document.clip ?? {};
const planesOf = (view) => clipOf(view).planes ?? [];
const diagonal = (view) => distance(...view.hello.bounds);

/**
 * Changes keys of the clip region; the slices on its cuts follow. A plane that becomes null is
 * removed, and its slices with it.
 */
function setClip(view, changes, moving = false) {
  const { box, planes = [], keep } = { ...clipOf(view), ...changes }, kept = planes.filter(Boolean);
  const cuts = planes.map((_, i) => cutLayers(view, planesOf(view)[i]));
  const clip = { ...box && { box }, ...kept.length && { planes: kept } };
  const isRegion = Object.keys(clip).length > 0;
  if (isRegion && keep) clip.keep = keep;
  view.edit((patch) => {
    for (const key of ["box", "planes", "keep"]) put(patch, ["clip", key], clip[key] ?? null);
    if (!isRegion) patch.clip = null;
    planes.forEach((plane, i) => {
      for (const number of plane ? cuts[i] : [])
        Object.assign(patch.layers[number], cutPlane(view, plane, keep));
    });
  }, moving);
  removeCuts(view, cuts.filter((_, i) => !planes[i]).flat());
}

function cutPlane(view, { point, normal }, keep) {
  const way = (keep === "outside" ? -1 : 1) * sliceShift * diagonal(view);
  return { point: add(point, scale(way, unit(normal))), normal };
}

/** Numbers of the added slices that are on the cut of a plane. */
function cutLayers(view, plane) {
  const near = 1e3 * sliceShift * diagonal(view);
  const isCut = ({ spec, isAdded }) => isAdded && spec.type === "slice" && spec.point &&
    equal(spec.normal, plane.normal) && distance(spec.point, plane.point) < near;
  return plane ? view.layers.filter(isCut).map((layer) => layer.number) : [];
}

function addCut(view, plane) {
  const data = Object.keys(view.hello.data).find((name) => view.hello.data[name].kind !== "surface");
  if (data) view.addLayer({ type: "slice", data, ...cutPlane(view, plane, clipOf(view).keep) });
  else view.app.showError(view, "A slice needs a grid or a mesh, and there is none.");
}

/** The last goes first: it leaves the numbers of the others. */
function removeCuts(view, cuts) {
  for (const number of cuts.reverse()) view.removeLayer(number);
}

function setFace(view, end, axis, value, moving) {
  const { bounds } = view.hello, box = structuredClone(clipOf(view).box ?? bounds);
  const least = thinnestShare * (bounds[1][axis] - bounds[0][axis]);
  box[end][axis] = end ? Math.max(value, box[0][axis] + least) : Math.min(value, box[1][axis] - least);
  setClip(view, { box }, moving);
}

/** Offsets along a plane's normal: of the plane, and the least and largest of the data. */
function offsets(view, { point, normal }) {
  const all = corners(view.hello.bounds).map((corner) => dot(corner, unit(normal)));
  return { now: dot(point, unit(normal)), low: Math.min(...all), high: Math.max(...all) };
}

/** Puts a plane, or a new one, at an offset along its normal, by default in the middle of the data. */
function setPlane(view, index, direction, offset, moving) {
  const normal = unit(direction), centre = middle(...view.hello.bounds), middleOffset = dot(centre, normal);
  const point = add(centre, scale((offset ?? middleOffset) - middleOffset, normal));
  setClip(view, { planes: Object.assign([...planesOf(view)], { [index]: { point, normal } }) }, moving);
}

const away = (view) => scale(-1, frameOf(view.camera).back);
const axisVector = (axis) => [0, 1, 2].map((i) => Number(i === axis));
/** Where the handle of a plane is: in the plane, and apart from the handles of the others. */
function handlePlace(view, index) {
  const { point, normal } = planesOf(view)[index];
  const side = unit(cross(normal, axisVector(normal.findIndex((x) => Math.abs(x) < 0.6 * length(normal)))));
  return add(point, scale(index % handleRow * handleShare * diagonal(view), side));
}

const planeName = (index) => `Clip plane ${index + 1}`;
const axisOf = ({ normal }) => axes.find((_, i) => Math.abs(unit(normal)[i]) > 1 - 1e-9) ?? "camera";

/** @param onHandles  is called with the view when its handles are to be shown or hidden */
export function showClipping(panel, view, onHandles) {
  const hasBox = Boolean(clipOf(view).box), planeCount = planesOf(view).length;
  const { bounds, length_unit: lengthUnit, words } = view.hello;
  panel.show([view.name, hasBox, planeCount], () => [
    panel.checkbox({ id: "clip-box", label: "Clip box", get: () => clipOf(view).box,
                     set: (on) => setClip(view, { box: on ? bounds : null }) }),
    hasBox && axes.map((name, axis) => [0, 1].map((end) => panel.slider({
      id: `clip-${name}-${end ? "high" : "low"}`, label: `${name} ${end ? "to" : "from"}`, unit: lengthUnit,
      min: bounds[0][axis], max: bounds[1][axis], get: () => clipOf(view).box?.[end][axis],
      set: (value, moving) => setFace(view, end, axis, value, moving) }))),
    planesOf(view).map((_, index) => planePart(panel, view, index)),
    make("div", { class: "buttons" },
      button("Add a clip plane", () => setPlane(view, planeCount, axisVector(planeCount % axes.length)),
             { id: "clip-add" })),
    (hasBox || planeCount > 0) && panel.checkbox({ id: "clip-handles", label: "Show handles in the picture",
      get: () => !view.hidesHandles, set: (on) => { view.hidesHandles = !on; onHandles(view); } }),
    (hasBox || planeCount > 0) && panel.select({ id: "clip-keep", label: "Show",
      options: words.keep ?? ["inside", "outside"], get: () => clipOf(view).keep ?? "inside",
      set: (keep) => setClip(view, { keep }) })]);
}

function planePart(panel, view, index) {
  const plane = () => planesOf(view)[index], id = (name) => `clip-${index}-${name}`;
  return make("fieldset", {}, make("legend", { text: planeName(index) }),
    panel.select({ id: id("direction"), label: "Direction",
      options: [...axes, ["camera", "facing me"]], get: () => axisOf(plane()),
      set: (name) => setPlane(view, index, name === "camera" ? away(view) : axisVector(axes.indexOf(name))) }),
    panel.slider({ id: id("position"), label: "Position", unit: view.hello.length_unit,
      min: () => offsets(view, plane()).low, max: () => offsets(view, plane()).high,
      get: () => offsets(view, plane()).now,
      set: (offset, moving) => setPlane(view, index, plane().normal, offset, moving) }),
    panel.checkbox({ id: id("slice"), label: "Slice on the cut", get: () => cutLayers(view, plane()).length > 0,
      set: (on) => on ? addCut(view, plane()) : removeCuts(view, cutLayers(view, plane())) }),
    make("div", { class: "buttons" },
      button("Face me again", () => setPlane(view, index, away(view)), { id: id("face") }),
      button("Flip", () => setPlane(view, index, scale(-1, plane().normal), -offsets(view, plane()).now),
             { id: id("flip") }),
      button("Remove", () => setClip(view, { planes: Object.assign([...planesOf(view)], { [index]: null }) }),
             { id: id("remove"), "aria-label": `Remove ${planeName(index).toLowerCase()}` })));
}

/**
 * Places a small square on each face of the clip box and on each clip plane. Dragging it moves the
 * face or the plane.
 */
export function placeHandles(view) {
  const wanted = view.hidesHandles ? [] : handlesOf(view);
  const isSame = wanted.length === view.clipHandles.length &&
    wanted.every(({ name }, i) => name === view.clipHandles[i].name);
  if (!isSame) {
    for (const { element } of view.clipHandles) element.remove();
    view.clipHandles = wanted.map((handle) => ({ ...handle, element: makeHandle(view, handle) }));
  }
  for (const { element, place, range, value } of view.clipHandles) {
    placeAt(element, project(view.camera, view.size, place()), view.size);
    describeSlider(element, ...range(), value(), view.hello.length_unit);
  }
}

/**
 * The handles of a clip region: {name, place() in the world, way() in which it moves, range() and
 * value() along it, moveTo(value)}.
 */
function handlesOf(view) {
  const face = (end, axis) => ({
    name: `${end ? "Upper" : "Lower"} ${axes[axis]} face of the clip box`,
    place: () => faceCentre(clipOf(view).box, end, axis), way: () => axisVector(axis),
    range: () => view.hello.bounds.map((corner) => corner[axis]), value: () => clipOf(view).box[end][axis],
    moveTo: (value) => setFace(view, end, axis, value, true) });
  const ofPlane = (_, index) => {
    const plane = () => planesOf(view)[index], reach = () => offsets(view, plane());
    return { name: planeName(index), place: () => handlePlace(view, index), way: () => unit(plane().normal),
             range: () => [reach().low, reach().high], value: () => reach().now,
             moveTo: (value) => setPlane(view, index, plane().normal, value, true) };
  };
  const faces = clipOf(view).box ? axes.flatMap((_, axis) => [face(0, axis), face(1, axis)]) : [];
  return [...faces, ...planesOf(view).map(ofPlane)];
}

/** Places an element over the picture, or hides it if the place is outside. */
export function placeAt(element, place, size) {
  element.hidden = !place || place.some((x, i) => x < 0 || x > size[i]);
  if (place) [element.style.left, element.style.top] = place.map((x) => `${x}px`);
}

function faceCentre(box, end, axis) {
  return middle(...box).map((x, i) => i === axis ? box[end][axis] : x);
}

function makeHandle(view, handle) {
  const moveTo = (value) => handle.moveTo(clamp(value, ...handle.range()));
  let held = null;  // where the pointer was pressed, and the value then
  const drop = () => { held = null; };
  const element = make("div", { class: "face", role: "slider", tabIndex: 0,
    "aria-label": `${handle.name}, view ${view.name}`,
    onpointerup: drop, onpointercancel: drop,
    onpointerdown: (event) => {
      element.setPointerCapture(event.pointerId);
      element.focus();
      event.preventDefault();
      held = { x: event.clientX, y: event.clientY, value: handle.value(), way: pixelsOf(view, handle) };
    },
    onpointermove: (event) => {
      if (!held?.way) return;
      const moved = [event.clientX - held.x, event.clientY - held.y];
      moveTo(held.value + (moved[0] * held.way[0] + moved[1] * held.way[1]) / length(held.way) ** 2);
    },
    onkeydown: (event) => {
      const value = keyValue(event, handle.value(), ...handle.range());
      if (value !== undefined) moveTo(value);
    } });
  view.overlay.append(element);
  return element;
}

/**
 * How many pixels a handle moves in the picture for each world unit; null if it moves straight to
 * the eye.
 */
function pixelsOf(view, { place, way }) {
  const step = 1e-3 * diagonal(view);
  const [from, to] = [place(), add(place(), scale(step, way()))]
    .map((point) => project(view.camera, view.size, point));
  if (!from || !to) return null;
  const moved = scale(1 / step, subtract(to, from));
  return length(moved) * diagonal(view) > 10 ? moved : null;
}

// The panel of layers.
import { button, hexColor, make } from "./controls.js";
import { Histogram } from "./histogram.js";
import { put } from "./patch.js";
import { middle } from "./vectors.js";

const kinds = { isosurface: "Isosurface", mip: "Maximum intensity projection", slice: "Slice",
                boundary: "Boundary", triangles: "Surface" };
const palette = ["#4e8fd0", "#d0704e", "#5aa469", "#b07cc6", "#c9a227", "#d0608f"];
const takesColorBy = ["isosurface", "boundary"], alwaysColored = ["mip", "slice"], oneColor = "";

export function showLayers(panel, view) {
  const { layers } = view, names = Object.keys(view.hello.data);
  const dataOf = (layer) => layer.spec.data ?? layer.info[0]?.spec.data ?? names[0];
  const signature = layers.map((layer) => [
    layer.number, layer.isAdded, layer.spec.type, dataOf(layer), colorBy(layer), "normal" in layer.spec,
    view.isovalues(layer).length, layer.info[0]?.field?.unit, Boolean(layer.info[0]?.field?.histogram)]);
  panel.show([view.name, view.hello.data, signature], () => {
    const isOf = (name) => (layer) => layer.spec.type === "isosurface" && dataOf(layer) === name;
    const parts = names.map((name, i) => dataPart(panel, view, name, i, layers.filter(isOf(name))));
    const others = layers.filter(({ spec }) => spec.type !== "isosurface");
    const rest = others.map((layer) => layerPart(panel, view, layer.number, dataOf(layer)));
    return [parts, rest, addPart(view, names)];
  });
}

const layerOf = (view, number) =>
  view.layers.find((layer) => layer.number === number) ?? { spec: {}, info: [] };
const path = (number, ...keys) => ["layers", String(number), ...keys];

/** The field that colours a layer, or "" for one colour. */
function colorBy({ spec, info }) {
  return spec.color_by ?? (spec.color === undefined ? info[0]?.spec.color_by : undefined) ?? oneColor;
}

/** Isosurfaces of the same data: one histogram, the field, and their layers. */
function dataPart(panel, view, name, index, surfaces) {
  const { fields = [] } = view.hello.data[name];
  if (surfaces.length === 0 && fields.length < 2) return null;
  return make("section", { class: "data", "aria-label": `Data ${name}` }, make("h3", { text: name }),
    fields.length > 1 && panel.select({
      id: `data-${index}-field`, label: "Field", options: fields,
      get: () => view.value("data", name, "field"), set: (field) => setField(view, name, field) }),
    histogramPart(panel, view, index, surfaces.map((layer) => layer.number)),
    surfaces.map((layer) => layerPart(panel, view, layer.number, name)));
}

/** Shows another field: its isovalues and ranges are chosen anew. */
function setField(view, name, field) {
  const { data } = view.hello, isOfData = ({ spec }) => (spec.data ?? Object.keys(data)[0]) === name;
  view.edit((patch) => {
    put(patch, ["data", name, "field"], field);
    for (const { number, spec } of view.layers.filter(isOfData)) {
      if (spec.type === "isosurface") put(patch, path(number, "isovalue"), "auto");
      put(patch, path(number, "range"), null);
    }
  });
}

function histogramPart(panel, view, index, numbers) {
  const find = () => numbers.map((number) => layerOf(view, number).info[0]?.field)
    .find((field) => field?.histogram);
  let last = find();
  if (!last) return null;
  const histogram = new Histogram({
    id: `data-${index}-histogram`,
    field: () => last = find() ?? last,
    marks: () => numbers.flatMap((number) => marksOf(view, layerOf(view, number))),
    onAdd: (value) => addIsosurface(view, numbers[0], value),
  });
  panel.onRefresh(() => histogram.refresh());
  return histogram.element;
}

function marksOf(view, layer) {
  const { number, spec, info } = layer, name = info[0]?.field?.name ?? "the field";
  return view.isovalues(layer).map((value, k) => ({
    id: `layer-${number}-handle${k || ""}`, value, label: `Isovalue of ${name}, layer ${number + 1}`,
    color: spec.color ? hexColor(spec.color) : info[k]?.legend ?? info[0]?.legend ?? "",
    set: (wanted, moving) => setIsovalue(view, number, k, wanted, moving),
  }));
}

/** Sets one isovalue of a layer; a layer with several keeps the others. */
function setIsovalue(view, number, k, value, moving) {
  const values = view.isovalues(layerOf(view, number));
  view.set(path(number, "isovalue"), values.length > 1 ? values.with(k, value) : value, moving);
}

/** Adds a copy of a layer with another isovalue and a colour that no layer has. */
function addIsosurface(view, number, isovalue) {
  const used = view.layers.map(({ spec }) => hexColor(spec.color, ""));
  const color = palette.find((each) => !used.includes(each)) ?? palette[view.layers.length % palette.length];
  const { color_by, colormap, range, scale, levels, ...copy } = structuredClone(layerOf(view, number).spec);
  view.addLayer({ ...copy, isovalue, color });
}

/** Id, label, getter and setter of a control for one key of a layer. */
function field(view, number, key, label, otherwise) {
  return { id: `layer-${number}-${key.replace("_", "-")}`, label,
           get: () => {
             const { spec, info } = layerOf(view, number);
             return spec[key] ?? info[0]?.spec[key] ?? otherwise;
           },
           set: (value, moving) => view.set(path(number, key), value, moving) };
}

function layerPart(panel, view, number, data) {
  const layer = () => layerOf(view, number), { spec: { type }, isAdded } = layer(), id = `layer-${number}`;
  const { colors = [] } = view.hello.data[data] ?? {}, of = (...rest) => field(view, number, ...rest);
  const isColored = alwaysColored.includes(type) || colorBy(layer()) !== oneColor;
  return make("fieldset", { class: "layer", id },
    make("legend", { text: `${number + 1}. ${kinds[type] ?? type}, ${data}` }),
    panel.checkbox({ ...of("visible", "Visible"), get: () => layer().spec.visible !== false }),
    type === "isosurface" && view.isovalues(layer()).map((_, k) => panel.number({
      id: `${id}-isovalue${k || ""}`, label: "Isovalue", unit: layer().info[0]?.field?.unit,
      get: () => view.isovalues(layer())[k],
      set: (value, moving) => setIsovalue(view, number, k, value, moving) })),
    type === "slice" && slicePart(panel, view, number),
    type !== "mip" && panel.slider({ ...of("opacity", "Opacity", 1), min: 0, max: 1 }),
    takesColorBy.includes(type) && colors.length > 0 && panel.select({
      id: `${id}-color-by`, label: "Colour by", get: () => colorBy(layer()),
      options: [[oneColor, "one colour"], ...colors.map((each) => [each, each])],
      set: (name) => setColorBy(view, layer(), name) }),
    !isColored && panel.color({ ...of("color", "Colour"),
                                get: () => layer().spec.color ?? layer().info[0]?.legend }),
    isColored && colorPart(panel, view, number),
    isAdded && button("Remove layer", () => view.removeLayer(number), { id: `${id}-remove` }));
}

function slicePart(panel, view, number) {
  if ("normal" in layerOf(view, number).spec) return make("p", { text: "On an oblique plane" });
  const [low, high] = view.hello.bounds, axisField = field(view, number, "axis", "Axis", "z");
  const axis = () => "xyz".indexOf(axisField.get()), position = field(view, number, "position", "Position");
  return [
    panel.select({ ...axisField, options: ["x", "y", "z"], set: (name) => view.edit((patch) => {
      put(patch, path(number, "axis"), name);
      put(patch, path(number, "position"), middle(low, high)["xyz".indexOf(name)]);
    }) }),
    panel.slider({ ...position, unit: view.hello.length_unit, min: () => low[axis()], max: () => high[axis()],
                   get: () => position.get() ?? middle(low, high)[axis()] })];
}

function setColorBy(view, { number, spec, info }, name) {
  view.edit((patch) => {
    put(patch, path(number, "range"), null);
    put(patch, path(number, "color_by"), name === oneColor ? null : name);
    if (name !== oneColor) return;
    for (const key of ["colormap", "scale", "levels"]) put(patch, path(number, key), null);
    put(patch, path(number, "color"), hexColor(spec.color ?? info[0]?.legend));
  });
}

function colorPart(panel, view, number) {
  const id = `layer-${number}`, { colormap = [], scale = ["linear", "log"] } = view.hello.words;
  const range = field(view, number, "range");
  const rangeEnd = (end, label) => panel.number({
    id: `${id}-range-${end ? "last" : "first"}`, label, get: () => range.get()?.[end],
    set: (value) => {
      const wanted = (range.get() ?? layerOf(view, number).info[0]?.field?.range ?? [0, 1]).with(end, value);
      if (wanted[0] < wanted[1]) range.set(wanted);
      else view.app.showError(view, "The first value of the range must be below the last one.");
    } });
  return make("details", { id: `${id}-colors` }, make("summary", { text: "Colour map and range" }),
    panel.select({ ...field(view, number, "colormap", "Colour map"), options: colormap }),
    rangeEnd(0, "First value"), rangeEnd(1, "Last value"),
    panel.select({ ...field(view, number, "scale", "Scale", "linear"), options: scale }),
    button("Default range", () => range.set(null), { id: `${id}-range-default` }));
}

function addPart(view, names) {
  const data = make("select", { id: "add-data" },
                    names.map((name) => make("option", { value: name, text: name })));
  const buttons = make("div", { class: "buttons" });
  const accuracy = ({ type }) => type !== "slice" && view.accuracy && { accuracy: view.accuracy };
  const add = (spec) => () => view.addLayer({ ...spec, data: data.value, ...accuracy(spec) });
  const showButtons = () => {
    const { kind } = view.hello.data[data.value], slice = { type: "slice", axis: "z" };
    slice.position = middle(...view.hello.bounds)[2];
    const field = [button("Add isosurface", add({ type: "isosurface" }), { id: "add-isosurface" }),
                   button("Add slice", add(slice), { id: "add-slice" }),
                   button("Add projection", add({ type: "mip" }), { id: "add-projection" })];
    const boundary = button("Add boundary", add({ type: "boundary" }), { id: "add-boundary" });
    buttons.replaceChildren(...{ grid: field, mesh: [...field, boundary] }[kind] ?? []);
  };
  data.addEventListener("change", showButtons);
  showButtons();
  const label = make("label", { for: data.id, text: "Data of a new layer" });
  return [names.length > 1 ? make("div", { class: "row" }, label, data) : null, buttons];
}

// The panel of style, light, annotations and accuracy.
import { withProjection } from "./camera.js";
import { button, make } from "./controls.js";
import { put } from "./patch.js";
import { rounded } from "./vectors.js";

const annotations = { axes: "Axes", box: "Box", colorbar: "Colour bar", legend: "Legend" };

export function showScene(panel, view) {
  const { words } = view.hello;
  const at = (id, label, path, otherwise) => ({ id, label, get: () => view.value(...path) ?? otherwise,
                                                set: (value, moving) => view.set(path, value, moving) });
  panel.show([view.name, words], () => [
    panel.select({ ...at("style", "Style", ["style"]), options: words.style ?? [],
                   set: (style) => setStyle(view, style) }),
    panel.checkbox({ id: "shadows", label: "Shadows", get: () => lights(view).some((light) => light.shadows),
                     set: (on) => setShadows(view, on), isEnabled: () => lights(view).some(canShadow) }),
    panel.checkbox({ id: "ambient-occlusion", label: "Ambient occlusion",
      get: () => view.document.effects?.ambient_occlusion ?? styleHasOcclusion(view),
      isEnabled: () => !styleHasOcclusion(view), set: (on) => setOcclusion(view, on) }),
    Object.entries(annotations).map(([key, label]) =>
      panel.checkbox({ ...at(`annotation-${key}`, label, ["annotations", key]),
                       set: (on) => setAnnotation(view, key, on) })),
    panel.color(at("background", "Background", ["image", "background"], "#ffffff")),
    panel.checkbox({ id: "orthographic", label: "Orthographic", get: () => view.camera?.ortho_height,
                     set: (on) => setOrthographic(view, on) }),
    panel.select({ ...at("show", "Heat map", ["image", "show"], "color"),
      options: (words.show ?? []).map((word) => [word, word === "color" ? "none (colours)" : word]) }),
    panel.select({ id: "accuracy", label: "Accuracy or method", get: () => view.method,
      options: () => [...words.accuracy ?? [], ...view.methods].map((word) => [word,
        word in view.methodMs ? `${word}, ${rounded(view.methodMs[word], 2)} ms` : word]),
      set: (word) => setMethod(view, word) }),
    make("div", { class: "buttons" },
         button("Discard all changes", () => view.replacePatch({}), { id: "discard" }))]);
}

export function setOrthographic(view, isOrthographic) {
  if (Boolean(view.camera.ortho_height) === isOrthographic) return;
  view.setCamera(withProjection(view.camera, isOrthographic, view.hello.camera.fov), false);
}

/** Lights of another style replace those that were changed here. */
function setStyle(view, style) {
  view.edit((patch) => {
    delete patch.lights;
    patch.style = style;
  });
}

const lights = (view) => view.value("lights") ?? [];
const canShadow = ({ type }) => type !== "head";

function setShadows(view, on) {
  view.set(["lights"], lights(view).map((light) => canShadow(light) ? { ...light, shadows: on } : light));
}

/** Whether the style alone brings ambient occlusion; a patch cannot switch that off. */
function styleHasOcclusion(view) {
  return view.isResolved && !view.document.effects?.ambient_occlusion &&
    Boolean(view.chosen("effects", "ambient_occlusion"));
}

function setOcclusion(view, on) {
  const base = view.hello.document.effects?.ambient_occlusion ?? {};
  view.set(["effects", "ambient_occlusion"], on ? base : null);
}

/** What the document says of an annotation comes back with it. */
function setAnnotation(view, key, on) {
  view.set(["annotations", key], on && (view.hello.document.annotations?.[key] || true));
}

/**
 * Sets the accuracy of all layers, or the method of those that have it. Layers with a choice of
 * their own follow, too.
 */
function setMethod(view, word) {
  const isLevel = view.hello.words.accuracy.includes(word);
  view.edit((patch) => {
    if (isLevel) patch.accuracy = word;
    for (const layer of view.layers) {
      const { number, spec } = layer;
      const has = isLevel ? ["isosurface", "mip"].includes(spec.type) : view.methodsOf(layer).includes(word);
      if (!has) continue;
      put(patch, ["layers", String(number), "accuracy"], isLevel ? word : null);
      put(patch, ["layers", String(number), "method"], isLevel ? null : word);
    }
  });
}

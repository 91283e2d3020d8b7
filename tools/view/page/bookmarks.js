// Views that the user saved: a camera and the isovalues.
import { anglesOf } from "./camera.js";
import { button, listOf, make } from "./controls.js";
import { downloadJson } from "./pictures.js";
import { put } from "./patch.js";

const ofBookmarks = ["view", "azimuth", "elevation", "zoom", "position", "target", "up", "fov", "ortho",
                     "ortho_height"];
const isShownSurface = ({ type, visible }) => type === "isosurface" && visible !== false;

/** Whether the bookmarks are all perspective or all orthographic. No camera lies between the two. */
function areAlike(bookmarks) {
  return new Set(bookmarks.map(({ camera }) => Boolean(camera.ortho_height))).size < 2;
}

/** A scene document with a camera that passes the bookmarks, one in each unit of time. */
export function withPath(document, bookmarks) {
  const surfaces = Object.values(document.layers).filter(isShownSurface), camera = { ...document.camera };
  const isOne = surfaces.length === 1 && !Array.isArray(surfaces[0].isovalue);
  for (const key of ofBookmarks) delete camera[key];
  camera.keyframes = bookmarks.map(({ camera: { position, target, up, fov, ortho_height }, isovalues }, time) =>
    ({ time, position, target, up, ...ortho_height ? { ortho_height } : { fov },
       ...isOne && isovalues.length === 1 && { isovalue: isovalues[0][1] } }));
  return { ...document, camera };
}

export class Bookmarks {
  list = [];
  count = 0;  // of all that were added

  constructor(onChange) {
    this.onChange = onChange;
  }

  add(view) {
    const { az, el } = anglesOf(view.camera, view.hello);
    const isovalues = view.layers.filter(({ spec }) => isShownSurface(spec))
      .map((layer) => [layer.number, ...view.isovalues(layer)]).filter((row) => row.length === 2);
    const name = `View ${++this.count}: azimuth ${Math.round(az)}°, elevation ${Math.round(el)}°`;
    this.list.push({ name, camera: view.camera, isovalues });
    this.onChange();
  }

  /** Shows a bookmark in a view. Isovalues of layers that are gone are left out. */
  go(view, { camera, isovalues }) {
    const isSurface = (number) => view.document.layers[number]?.type === "isosurface";
    view.edit((patch) => {
      for (const [number, value] of isovalues)
        if (isSurface(number)) put(patch, ["layers", String(number), "isovalue"], value);
    });
    view.setCamera(camera, false);
  }

  show(panel, view) {
    const isPath = this.list.length > 1;
    panel.show([view.name, this.list.map(({ name }) => name)], () => [
      listOf("bookmark", this.list, ({ name }) => name, this.onChange, (bookmark) => this.go(view, bookmark)),
      make("div", { class: "buttons" },
        button("Save this view", () => this.add(view), { id: "bookmark-add" }),
        button("Save as camera path", () => savePath(view, this.list),
               { id: "bookmark-path", disabled: !isPath }))]);
  }
}

function savePath(view, bookmarks) {
  const save = ({ document }) => downloadJson(withPath(document, bookmarks), `${view.hello.title}-path.json`);
  if (areAlike(bookmarks)) view.keep(save);
  else view.app.showError(view, "A camera path is perspective or orthographic, and the saved views are both. " +
    "Remove those of one kind.");
}

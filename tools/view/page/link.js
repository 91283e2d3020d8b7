// The state of a view in the fragment of the URL: only what differs from the start.
//   #iso=500&az=30&el=20&zoom=1.5&at=1,2,3&ortho=1&patch={...}
import { anglesOf, extent, fromAngles, look, lookAt, withProjection, zoom } from "./camera.js";
import { merge, put } from "./patch.js";
import { distance, rounded, roundedWithin } from "./vectors.js";

const angleText = (x) => String(Number(x.toFixed(2)) || 0);
const encoded = (text) => encodeURIComponent(text).replaceAll("%2C", ",").replaceAll("%3A", ":");

/** Numbers of the isosurface layers of a document. */
function surfaceNumbers({ layers = {} }) {
  return Object.keys(layers).filter((number) => layers[number].type === "isosurface");
}

/** The fragment, without "#", for a camera and a patch. */
export function toFragment(hello, camera, patch) {
  const items = {}, rest = structuredClone(patch);
  const isovalues = surfaceNumbers(merge(hello.document, patch)).map((number) => {
    const value = patch.layers?.[number]?.isovalue;
    if (typeof value !== "number") return "";
    put(rest, ["layers", number, "isovalue"], undefined);
    return String(value);
  });
  if (isovalues.some((text) => text !== "")) items.iso = isovalues.join(",").replace(/,+$/, "");

  const start = anglesOf(hello.camera, hello), now = anglesOf(camera, hello);
  for (const key of ["az", "el"])
    if (angleText(now[key]) !== angleText(start[key])) items[key] = angleText(now[key]);
  const enlarged = rounded(extent(hello.camera) / extent(camera), 5);
  if (enlarged !== 1) items.zoom = enlarged;
  if (distance(camera.target, hello.camera.target) > 1e-6 * distance(...hello.bounds))
    items.at = camera.target.map((x) => roundedWithin(distance(...hello.bounds), x)).join(",");
  const isOrthographic = Boolean(camera.ortho_height);
  if (isOrthographic !== Boolean(hello.camera.ortho_height)) items.ortho = Number(isOrthographic);
  if (Object.keys(rest).length > 0) items.patch = JSON.stringify(rest);
  return Object.entries(items).map(([key, text]) => `${key}=${encoded(text)}`).join("&");
}

/**
 * The camera and the patch that a fragment tells. Throws an Error with a sentence if it cannot be
 * read.
 */
export function fromFragment(hello, fragment) {
  const items = Object.fromEntries(fragment.split("&").map((item) => item.split("=")));
  const read = (key, act) => {
    try {
      if (items[key]) return act(decodeURIComponent(items[key]));
    } catch {
      throw new Error(`The link cannot be read: its "${key}" is not valid.`);
    }
  };
  const numbers = (key, isValid = () => true) => read(key, (text) => {
    const values = text.split(",").map((each) => each === "" ? null : Number(each));
    if (values.some(Number.isNaN) || !isValid(values)) throw new Error();
    return values;
  });
  const isNumber = ([x]) => x !== null;

  const patch = read("patch", JSON.parse) ?? {}, surfaces = surfaceNumbers(merge(hello.document, patch));
  numbers("iso", ({ length }) => length <= surfaces.length)?.forEach((value, i) => {
    if (value !== null) put(patch, ["layers", surfaces[i], "isovalue"], value);
  });
  let camera = hello.camera;
  const az = numbers("az", isNumber), el = numbers("el", ([x]) => Math.abs(x) <= 90);
  const start = anglesOf(camera, hello);
  if (az || el) {
    const { direction, up } = fromAngles(az?.[0] ?? start.az, el?.[0] ?? start.el, hello);
    camera = look(camera, direction, up);
  }
  const enlarged = numbers("zoom", ([x]) => x > 0), at = numbers("at", ({ length }) => length === 3);
  const ortho = numbers("ortho", isNumber);
  if (enlarged) camera = zoom(camera, enlarged[0]);
  if (at) camera = lookAt(camera, at);
  if (ortho) camera = withProjection(camera, ortho[0] === 1, hello.camera.fov);
  return { camera, patch };
}

// Points that the user pinned, and texts of probes.
import { project } from "./camera.js";
import { placeAt } from "./clipping.js";
import { button, listOf, make } from "./controls.js";
import { download } from "./pictures.js";
import { distance, rounded, withDecimals } from "./vectors.js";

const withUnit = (x, unit, digits = 6) => `${rounded(x, digits)} ${unit ?? ""}`.trim();
const columns = ["x", "y", "z", "length_unit", "value", "unit", "cell", "error", "value_error",
                 "distance_from_previous", "distance_error"];

/** What a probe found, as a line of text. */
export function probeText(answer) {
  const { position, length_unit: lengthUnit, value, unit, cell, error, value_error: valueError } = answer;
  if (!position) return "Nothing is hit here.";
  const parts = [`Position ${position.map((x) => withDecimals(x)).join(", ")} ${lengthUnit ?? ""}`.trim()];
  if (Number.isFinite(value)) parts.push(`value ${withDecimals(value)} ${unit ?? ""}`.trim());
  if (cell !== null) parts.push(`cell ${[cell].flat().join(", ")}`);
  if (Number.isFinite(error)) parts.push(`certified error ${withUnit(error, lengthUnit, 2)}`);
  if (Number.isFinite(valueError)) parts.push(`certified error of value ${withUnit(valueError, unit, 2)}`);
  return parts.join("; ");
}

/** The distance of a pin from the one before, and the sum of their errors if both are known. */
export function fromPrevious(pin, previous) {
  if (!previous) return {};
  return { distance_from_previous: distance(pin.position, previous.position),
           distance_error: pin.error + previous.error };  // NaN if one is not known
}

/** The pins as comma-separated values with a line of names. */
export function csvOf(pins) {
  const quoted = (text) => /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  const rows = pins.map((pin, i) => {
    const [x, y, z] = pin.position, row = { ...pin, x, y, z, ...fromPrevious(pin, pins[i - 1]) };
    const text = (name) => row[name] || row[name] === 0 ? quoted(String(row[name])) : "";
    return [i + 1, ...columns.map(text)];
  });
  return [["pin", ...columns], ...rows].map((row) => `${row.join(",")}\r\n`).join("");
}

export class Pins {
  list = [];

  constructor(onChange) {
    this.onChange = onChange;
  }

  add(answer) {
    if (!answer?.position) return false;
    this.list.push(answer);
    this.onChange();
    return true;
  }

  show(panel, title) {
    panel.show(this.list.map(({ id, position }) => [id, position]), () => this.list.length === 0
      ? make("p", { text: "Click the picture, or press P and Enter, to pin a point." })
      : [listOf("pin", this.list, (pin, i) => this.#line(pin, this.list[i - 1], i), this.onChange),
         button("Download CSV", () => download(new Blob([csvOf(this.list)], { type: "text/csv" }),
                                               `${title}-pins.csv`), { id: "pins-csv" })]);
  }

  #line(pin, previous, i) {
    if (!previous) return probeText(pin);
    const step = fromPrevious(pin, previous), unit = pin.length_unit;
    const error = Number.isFinite(step.distance_error) ? ` ± ${withUnit(step.distance_error, unit, 2)}` : "";
    const apart = withUnit(step.distance_from_previous, unit);
    return `${probeText(pin)}; distance from pin ${i}: ${apart}${error}`;
  }

  /** Places a marker for each pin over the picture of a view. */
  place(view) {
    const { markers, size } = view;
    while (markers.length > this.list.length) markers.pop().remove();
    while (markers.length < this.list.length) {
      markers.push(make("span", { class: "marker", "aria-hidden": "true", text: markers.length + 1 }));
      view.overlay.append(markers.at(-1));
    }
    this.list.forEach(({ position }, i) => placeAt(markers[i], project(view.camera, size, position), size));
  }
}

// Vectors of three numbers, as arrays.
export const add = (a, b) => a.map((x, i) => x + b[i]);
export const subtract = (a, b) => a.map((x, i) => x - b[i]);
export const scale = (s, a) => a.map((x) => s * x);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(...a);
export const distance = (a, b) => length(subtract(a, b));
export const middle = (a, b) => scale(0.5, add(a, b));
export const clamp = (x, low, high) => Math.max(low, Math.min(high, x));

/** A vector of length 1 with the same direction; the zero vector stays as it is. */
export const unit = (a) => scale(1 / (length(a) || 1), a);

/** Turns a vector around an axis of length 1 by an angle in radians (Rodrigues' formula). */
export function turned(v, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(scale(c, v), scale(s, cross(axis, v))), scale((1 - c) * dot(axis, v), axis));
}

/** The eight corners of a box that is given by two of them. */
export function corners([low, high]) {
  return [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((axis) => (k >> axis & 1 ? high : low)[axis]));
}

export const rounded = (x, digits = 6) => Number(Number(x).toPrecision(digits));
/** At least so many digits; at large numbers as many as three decimals need. */
export const withDecimals = (x, digits = 6) =>
  rounded(x, clamp(Math.floor(Math.log10(Math.abs(x))) + 4, digits, 15));
/** With as many decimals as tell the number to within a millionth of an extent. */
export const roundedWithin = (extent, x) => Number(x.toFixed(clamp(Math.ceil(6 - Math.log10(extent)), 0, 100)));

// JSON Merge Patch (RFC 7386): a patch is a partial document; null in it removes a key.
const isObject = (x) => x !== null && typeof x === "object" && !Array.isArray(x);
export const equal = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** The document with the patch applied. Neither argument changes. */
export function merge(target, patch) {
  if (!isObject(patch)) return structuredClone(patch);
  const result = isObject(target) ? { ...target } : {};
  for (const [key, value] of Object.entries(patch)) {
    if (value === null) delete result[key];
    else result[key] = merge(result[key], value);
  }
  return result;
}

/** A patch that makes `to` from `from`, or undefined if they are equal. */
export function difference(from, to) {
  if (equal(from, to)) return undefined;
  if (!isObject(from) || !isObject(to)) return structuredClone(to);
  const patch = {};
  for (const key of Object.keys(from)) if (!(key in to)) patch[key] = null;
  for (const [key, value] of Object.entries(to)) {
    const change = difference(from[key], value);
    if (change !== undefined) patch[key] = change;
  }
  return patch;
}

export function at(object, path) {
  return path.reduce((value, key) => value?.[key], object);
}

/**
 * Sets the value at a path of keys. Undefined deletes the key, and objects that become empty by
 * that.
 */
export function put(object, path, value) {
  const [key, ...rest] = path;
  if (rest.length === 0) {
    if (value === undefined) delete object[key];
    else object[key] = value;
    return;
  }
  if (value === undefined && !isObject(object[key])) return;
  if (!isObject(object[key])) object[key] = {};
  put(object[key], rest, value);
  if (value === undefined && Object.keys(object[key]).length === 0) delete object[key];
}

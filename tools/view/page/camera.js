// Cameras: {position, target, up} with `fov` in degrees or `ortho_height` in world units.
// Functions return a new camera; the one that is given does not change.
import { add, clamp, cross, distance, dot, length, scale, subtract, turned, unit } from "./vectors.js";

const radians = Math.PI / 180, steepest = 0.02;

/** Directions of the picture: right, above, and back towards the eye; all of length 1. */
export function frameOf(camera) {
  const back = unit(subtract(camera.position, camera.target)), right = unit(cross(camera.up, back));
  return { right, above: cross(back, right), back };
}

/** Height of the picture at the target, in world units. */
export function extent(camera) {
  return camera.ortho_height ??
    2 * distance(camera.position, camera.target) * Math.tan(camera.fov * radians / 2);
}

/** A turntable: dx turns around `up`, dy around the picture's horizontal, both in radians. */
export function turn(camera, up, dx, dy) {
  let back = turned(subtract(camera.position, camera.target), up, -dx);
  const right = unit(cross(turned(camera.up, up, -dx), back));
  const steep = turned(back, right, -dy), angle = Math.acos(clamp(dot(unit(steep), up), -1, 1));
  if (angle > steepest && angle < Math.PI - steepest) back = steep;
  const isPole = length(cross(unit(back), up)) < steepest / 2;
  return { ...camera, position: add(camera.target, back), up: isPole ? turned(camera.up, up, -dx) : up };
}

/** Moves the camera so that the picture follows by dx and dy, in heights of the picture. */
export function pan(camera, dx, dy) {
  const { right, above } = frameOf(camera);
  const way = scale(extent(camera), add(scale(-dx, right), scale(dy, above)));
  return { ...camera, position: add(camera.position, way), target: add(camera.target, way) };
}

export function zoom(camera, factor) {
  if (camera.ortho_height) return { ...camera, ortho_height: camera.ortho_height / factor };
  const back = subtract(camera.position, camera.target);
  return { ...camera, position: add(camera.target, scale(1 / factor, back)) };
}

/** Looks from a direction, at the same distance. */
export function look(camera, direction, up) {
  const away = distance(camera.position, camera.target);
  return { ...camera, position: add(camera.target, scale(away, direction)), up };
}

export function lookAt(camera, target) {
  return { ...camera, target, position: add(target, subtract(camera.position, camera.target)) };
}

/**
 * Orthographic or with a field of view in degrees, with what is at the target as large as before.
 */
export function withProjection(camera, isOrthographic, fov = 30) {
  const { position, target, up } = camera, height = extent(camera);
  if (isOrthographic) return { position, target, up, ortho_height: height };
  const away = height / (2 * Math.tan(fov * radians / 2));
  return { position: add(target, scale(away, frameOf(camera).back)), target, up, fov };
}

/** Names, directions towards the eye, and up directions of the six standard views. */
export function standardViews({ up, ahead }) {
  const right = cross(ahead, up);
  return [["front", scale(-1, ahead), up], ["back", ahead, up], ["left", scale(-1, right), up],
          ["right", right, up], ["top", up, ahead], ["bottom", scale(-1, up), scale(-1, ahead)]];
}

/**
 * Azimuth and elevation in degrees: 0 and 0 look from the front, azimuth 90 looks from the right.
 */
export function anglesOf(camera, { up, ahead }) {
  const { back, above } = frameOf(camera), right = cross(ahead, up), height = clamp(dot(back, up), -1, 1);
  // At the poles the picture's upper side tells the azimuth.
  const side = Math.abs(height) > 1 - 1e-9 ? scale(-Math.sign(height), above) : back;
  return { az: Math.atan2(dot(side, right), -dot(side, ahead)) / radians, el: Math.asin(height) / radians };
}

/** The direction towards the eye and the up direction that belong to angles in degrees. */
export function fromAngles(az, el, { up, ahead }) {
  const right = cross(ahead, up);
  const side = add(scale(-Math.cos(az * radians), ahead), scale(Math.sin(az * radians), right));
  const direction = add(scale(Math.cos(el * radians), side), scale(Math.sin(el * radians), up));
  return { direction, up: Math.abs(el) > 89.99 ? scale(-Math.sign(el), side) : up };
}

/**
 * Where a point appears, in pixels of a picture of this size from its upper left; null behind the
 * eye.
 */
export function project(camera, [width, height], point) {
  const { right, above, back } = frameOf(camera), offset = subtract(point, camera.position);
  const depth = -dot(offset, back);
  if (!camera.ortho_height && !(depth > 0)) return null;
  const visible = camera.ortho_height ?? 2 * depth * Math.tan(camera.fov * radians / 2);
  const pixels = (direction) => dot(offset, direction) * height / visible;
  return [width / 2 + pixels(right), height / 2 - pixels(above)];
}

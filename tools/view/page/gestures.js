// Mouse, touch and wheel on a picture.
import { pan, turn, zoom } from "./camera.js";
import { clamp } from "./vectors.js";

const clickPixels = 4, doubleClickMs = 350, doubleClickPixels = 12;

/** Gestures move the view's camera, and call hover, click or doubleClick(view, pixel) of `acts`. */
export function connectGestures(view, acts) {
  const { canvas } = view, pointers = new Map();
  let press = null;      // of the first pointer, as long as it may become a click
  let lastClick = null;  // that may become a double click

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const isPress = pointers.size === 1 && event.button === 0 && !event.shiftKey;
    press = isPress ? [event.clientX, event.clientY] : null;
  });

  canvas.addEventListener("pointermove", (event) => {
    if (!view.camera) return;
    const before = pointers.get(event.pointerId), now = [event.clientX, event.clientY];
    if (!before) {
      if (event.buttons === 0 && view.isAtRest) acts.hover(view, pixelAt(canvas, event));
      return;
    }
    if (press && Math.hypot(now[0] - press[0], now[1] - press[1]) < clickPixels) return;
    press = null;
    drag(view, pointers, event, before, now);
    pointers.set(event.pointerId, now);
  });

  canvas.addEventListener("pointerup", (event) => {
    pointers.delete(event.pointerId);
    if (!press) return;
    press = null;
    const click = { at: performance.now(), x: event.clientX, y: event.clientY }, last = lastClick;
    const isDouble = last && click.at - last.at < doubleClickMs &&
      Math.hypot(click.x - last.x, click.y - last.y) < doubleClickPixels;
    clearTimeout(last?.timer);
    lastClick = isDouble ? null : click;
    const pixel = pixelAt(canvas, event);
    if (isDouble) acts.doubleClick(view, pixel);
    else click.timer = setTimeout(() => acts.click(view, pixel), doubleClickMs);
  });
  canvas.addEventListener("pointercancel", (event) => {
    pointers.delete(event.pointerId);
    press = null;
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    if (view.camera) view.setCamera(zoom(view.camera, Math.pow(0.85, wheelNotches(event))));
  }, { passive: false });
}

function drag(view, pointers, event, before, now) {
  const [dx, dy] = [0, 1].map((i) => (now[i] - before[i]) / view.size[1]);
  if (pointers.size === 2) {
    const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
    const apart = Math.hypot(now[0] - other[0], now[1] - other[1]);
    const apartBefore = Math.hypot(before[0] - other[0], before[1] - other[1]);
    view.setCamera(pan(zoom(view.camera, Math.max(1, apart) / Math.max(1, apartBefore)), dx / 2, dy / 2));
  } else if (event.shiftKey || event.buttons & 2 || event.buttons & 4) {
    view.setCamera(pan(view.camera, dx, dy));
  } else {
    view.setCamera(turn(view.camera, view.hello.up, dx * Math.PI, dy * Math.PI));
  }
}

/** A turn of the wheel in notches, whatever unit the browser reports. */
export function wheelNotches(event) {
  return event.deltaY / ([100, 3][event.deltaMode] ?? 1);
}

/** The pixel of the canvas below a pointer. */
function pixelAt(canvas, event) {
  const box = canvas.getBoundingClientRect();
  const index = (offset, length, count) => clamp(Math.floor(offset / length * count), 0, count - 1);
  return [index(event.clientX - box.left, box.width, canvas.width),
          index(event.clientY - box.top, box.height, canvas.height)];
}

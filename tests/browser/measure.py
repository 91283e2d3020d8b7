"""Latencies of the viewer in the browser, from the pointer's event to the drawn picture that contains it.

    measure.py FILE [OPTION...]      options as for `rhoray view`

The canvas has 1024 x 1024 pixels. Prints one line for each motion, as milliseconds at the 50th and 95th percentile,
and the CPU time of the server while the page is open and nobody touches it.
"""
import os
import pathlib
import sys
import tempfile
import time

from browser import BrowserTest, Viewer

SIDE, SECONDS = 1024, 5
CHECKING_S, IDLE_S = 15, 30  # the server checks the picture at rest; after that it has nothing to do

# Moves the pointer once in each frame of the display.
DRAG = """
const [id, dx, dy, seconds, done] = arguments;
const element = document.getElementById(id), box = element.getBoundingClientRect();
const at = {x: box.left + box.width / 2, y: box.top + box.height / 2};
const fire = (type, target = element) => target.dispatchEvent(new PointerEvent(type, {
  bubbles: true, cancelable: true, pointerId: 1, isPrimary: true, button: type === "pointermove" ? -1 : 0,
  buttons: type === "pointerup" ? 0 : 1, clientX: at.x, clientY: at.y}));
Element.prototype.setPointerCapture = () => {};
Element.prototype.hasPointerCapture = () => true;
Element.prototype.releasePointerCapture = () => {};
const eventAt = new Map(), latencies = [], spacings = [];
let pictures = 0, moved = 0, isOver = false;
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function(text) {
  const {n} = JSON.parse(text);
  if (n) eventAt.set(n, moved);
  return send.call(this, text);
};
const drawn = ({detail: {request, spacing}}) => {
  ++pictures;
  spacings.push(spacing);
  for (const [n, time] of eventAt) if (n <= request) {
    if (!isOver) latencies.push(performance.now() - time);
    eventAt.delete(n);
  }
};
document.addEventListener("drawn", drawn);
fire("pointerdown");
const begin = performance.now();
const step = () => {
  const now = performance.now();
  if (now - begin > 1000 * seconds) {
    isOver = true;
    fire("pointerup");
    document.removeEventListener("drawn", drawn);
    WebSocket.prototype.send = send;
    latencies.sort((a, b) => a - b);
    spacings.sort((a, b) => a - b);
    const quantile = (share) => latencies[Math.floor(share * (latencies.length - 1))];
    return done({p50: quantile(0.5), p95: quantile(0.95), rate: pictures / seconds,
                 spacing: spacings[spacings.length >> 1]});
  }
  moved = now;
  at.x += dx * Math.cos((now - begin) / 700);
  at.y += dy * Math.cos((now - begin) / 700);
  fire("pointermove");
  requestAnimationFrame(step);
};
requestAnimationFrame(step);
"""


def cpu_seconds(pid):
    """Of a process, all its threads."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Measurement(BrowserTest):
    def runTest(self):
        """Is called by main."""


def main(words):
    Measurement.setUpClass()
    page = Measurement()
    page.driver.set_window_size(SIDE + 400, SIDE + 200)
    with tempfile.TemporaryDirectory() as folder:
        viewer = Viewer(*[pathlib.Path(words[0]).resolve(), *words[1:]], folder=folder)
        page.open(viewer)
        size = "[rhoray.active.canvas.width, rhoray.active.canvas.height]"
        for _ in range(3):  # until the canvas has its size
            width, height = page.js(size)
            outer = page.driver.get_window_size()
            page.driver.set_window_size(outer["width"] + SIDE - width, outer["height"] + SIDE - height)
            page.wait(f"({size}).join() !== '{width},{height}' || {str(width == SIDE and height == SIDE).lower()}")
            page.settle()
        page.driver.get("about:blank")
        page.driver.get(viewer.url)
        page.settle()
        first = page.js("performance.getEntriesByName('first picture')[0]?.startTime - "
                        "performance.getEntriesByType('navigation')[0].domContentLoadedEventEnd")
        print(f"{words[0]}: canvas {page.js(size)}" + (f", first picture {first:.0f} ms after the page" if first else ""))
        for name, element, dx, dy in (("camera", "picture", 6, 2), ("isovalue", "layer-0-handle", 0.5, 0)):
            if not page.js(f"document.getElementById('{element}')"):
                continue
            found = page.driver.execute_async_script(DRAG, element, dx, dy, SECONDS)
            print(f"  {name}: p50 {found['p50']:.0f} ms, p95 {found['p95']:.0f} ms, {found['rate']:.0f} pictures/s, "
                  f"spacing {found['spacing']}")
            page.settle()
        time.sleep(CHECKING_S)
        before = cpu_seconds(viewer.process.pid)
        time.sleep(IDLE_S)
        share = (cpu_seconds(viewer.process.pid) - before) / IDLE_S
        print(f"  idle: {100 * share:.2f} % of a core")
        viewer.stop()
    Measurement.doClassCleanups()


if __name__ == "__main__":
    main(sys.argv[1:])

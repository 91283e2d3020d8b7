"""`rhoray view` and a headless Chromium that shows its page."""
import base64
import hashlib
import pathlib
import re
import subprocess
import tempfile
import time
import unittest

import numpy
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

ROOT = pathlib.Path(__file__).resolve().parents[2]
RHORAY = ROOT / "build/release/bin/rhoray"
PATIENCE_S = 60  # no test waits longer for one thing

# Counts the pixels of the settled canvas that differ from a PNG. Both are read as the browser shows
# them.
DIFFERENT_PIXELS = """
const [png, done] = arguments;
const bytes = Uint8Array.from(atob(png), (letter) => letter.charCodeAt(0));
createImageBitmap(new Blob([bytes], {type: "image/png"}), {colorSpaceConversion: "none", premultiplyAlpha: "none"})
  .then((bitmap) => {
    const canvas = rhoray.active.canvas, width = canvas.width, height = canvas.height;
    if (bitmap.width !== width || bitmap.height !== height) return done(`${bitmap.width} x ${bitmap.height} pixels`);
    const other = new OffscreenCanvas(width, height).getContext("2d", {alpha: false});
    other.drawImage(bitmap, 0, 0);
    const a = other.getImageData(0, 0, width, height).data;
    const b = canvas.getContext("2d").getImageData(0, 0, width, height).data;
    let count = 0;
    for (let i = 0; i < a.length; i += 4) if (a[i] !== b[i] || a[i + 1] !== b[i + 1] || a[i + 2] !== b[i + 2]) ++count;
    done(count);
  }, (error) => done(String(error)));
"""


def write_volume(path, side=64, wave=9):
    """A ball with waves: its values are 1 in the middle and fall to about 0 at the sides."""
    axis = numpy.linspace(-1, 1, side, dtype=numpy.float32)
    z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij")
    radius = numpy.sqrt(x * x + y * y + z * z)
    numpy.save(path, (1 - radius + 0.05 * numpy.sin(wave * x) * numpy.sin(wave * y) * numpy.sin(wave * z))
               .astype(numpy.float32))


def write_mesh(path, side=6):
    """A box of tetrahedra with two fields of points, as legacy VTK."""
    points = [(i, j, k) for k in range(side + 1) for j in range(side + 1) for i in range(side + 1)]
    number = {point: index for index, point in enumerate(points)}
    cells = []
    for i, j, k in ((i, j, k) for k in range(side) for j in range(side) for i in range(side)):
        corner = [number[i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)] for c in range(8)]
        # Six tetrahedra around the diagonal from corner 0 to corner 7.
        ring = [1, 3, 2, 6, 4, 5]
        cells += [(corner[0], corner[a], corner[b], corner[7]) for a, b in zip(ring, ring[1:] + ring[:1])]
    lines = ["# vtk DataFile Version 3.0", "box", "ASCII", "DATASET UNSTRUCTURED_GRID", f"POINTS {len(points)} float"]
    lines += [f"{x / side} {y / side} {z / side}" for x, y, z in points]
    lines += [f"CELLS {len(cells)} {5 * len(cells)}"] + ["4 %d %d %d %d" % cell for cell in cells]
    lines += [f"CELL_TYPES {len(cells)}"] + ["10"] * len(cells) + [f"POINT_DATA {len(points)}"]
    for name, value in (("height", lambda p: p[2]), ("distance", lambda p: sum(c * c for c in p) ** 0.5)):
        lines += [f"SCALARS {name} float 1", "LOOKUP_TABLE default"] + [f"{value(p) / side}" for p in points]
    path.write_text("\n".join(lines) + "\n")


class Viewer:
    """The running program. Its address stays the same when it is started again."""

    def __init__(self, *words, folder):
        self.words, self.folder, self.process, self.port, self.said = words, folder, None, None, ""
        self.start()

    def start(self):
        words = [str(word) for word in self.words] + ([] if self.port is None else ["--port", str(self.port)])
        self.process = subprocess.Popen([str(RHORAY), "view", "--no-browser", "--no-cache", *words], cwd=self.folder,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()
        if not self.url:
            raise AssertionError(self.process.stderr.read())
        self.port = int(re.match(r"http://127\.0\.0\.1:(\d+)/", self.url).group(1))

    def stop(self):
        """Its exit code. `said` is then what it wrote to stderr."""
        self.process.terminate()
        _, self.said = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode


class BrowserTest(unittest.TestCase):
    """Gives each test a folder, and all tests of a class one browser."""

    pixel_ratio = 1  # device pixels for each pixel of CSS
    window = (1100, 760)
    preferences = {}  # of the browser

    @classmethod
    def setUpClass(cls):
        options = webdriver.ChromeOptions()
        for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage",
                     f"--window-size={cls.window[0]},{cls.window[1]}",
                     f"--force-device-scale-factor={cls.pixel_ratio}"):
            options.add_argument(word)
        options.add_experimental_option("prefs", cls.preferences)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        cls.driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        cls.driver.set_script_timeout(PATIENCE_S)
        cls.addClassCleanup(cls.driver.quit)

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="rhoray-browser-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def view(self, *words, fragment=""):
        """Starts the program and opens its page."""
        viewer = Viewer(*words, folder=self.folder)
        self.addCleanup(lambda: viewer.process.poll() is None and viewer.stop())
        self.open(viewer, fragment)
        return viewer

    def open(self, viewer, fragment=""):
        self.driver.get("about:blank")  # a change of the fragment alone would not load the page
        self.driver.get_log("browser")
        self.driver.get_log("performance")
        self.driver.get(viewer.url + (f"&{fragment}" if fragment else ""))
        self.settle()

    def js(self, expression):
        return self.driver.execute_script(f"return {expression}")

    def wait(self, expression, why=None):
        end = time.time() + PATIENCE_S
        while time.time() < end:
            if self.js(expression):
                return
            time.sleep(0.02)
        self.fail(f"waited for {why or expression}; state '{self.js('document.getElementById(`state`).textContent')}', "
                  f"alert '{self.js('document.getElementById(`alert-text`).textContent')}'")

    def settle(self):
        """Waits for the lossless picture of all views."""
        self.wait("window.rhoray && rhoray.views.length > 0 && rhoray.views.every((view) => view.isAtRest && view.drawn.isLossless)",
                  "the lossless picture")

    def different_pixels(self, png):
        return self.driver.execute_async_script(DIFFERENT_PIXELS, base64.b64encode(png).decode())

    def pixels(self):
        """Of the active canvas, as a short text that changes with any of them."""
        return hashlib.sha256(self.js("rhoray.active.canvas.toDataURL('image/png')").encode()).hexdigest()

    def command(self):
        """The command of the current picture, without its program."""
        self.js("document.getElementById('copied').textContent = ''")
        self.driver.find_element("id", "command").click()
        self.wait("document.getElementById('copied').textContent.startsWith('rhoray render ')")
        return self.js("document.getElementById('copied').textContent")

    def rendered(self, command):
        """The PNG that a printed command draws."""
        picture = self.folder / "rendered.png"
        picture.unlink(missing_ok=True)
        done = subprocess.run(f"'{RHORAY}' {command.removeprefix('rhoray ')} --no-cache -o '{picture}'", shell=True,
                              cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return picture.read_bytes()

    def downloaded(self, name, act):
        """The file that the page saves when act() is called. It lies in a folder of its own."""
        folder = self.folder / "downloads"
        folder.mkdir(exist_ok=True)
        self.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(folder)})
        act()
        end = time.time() + PATIENCE_S
        while not (folder / name).exists() and time.time() < end:
            time.sleep(0.02)
        self.assertIn(name, [path.name for path in folder.iterdir()])
        return folder / name

    def check_against_command(self):
        self.assertEqual(self.different_pixels(self.rendered(self.command())), 0)

    def check_console(self):
        """No errors; our own reading of pixels makes warnings."""
        errors = [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]
        self.assertEqual(errors, [])

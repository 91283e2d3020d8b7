"""`rhoray.view` of the Python module, with its page in a browser."""
import contextlib
import functools
import http.server
import threading
import time
import unittest

import numpy
import rhoray as rr
from selenium.webdriver.common.keys import Keys

from browser import PATIENCE_S, BrowserTest, write_volume

ISOVALUE = "rhoray.views[0].document.layers[0].isovalue"


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *words):
        pass


@contextlib.contextmanager
def served(folder):
    """Serves a folder, as the server of a notebook on this machine does. Gives the address."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://localhost:{server.server_port}"
    server.shutdown()
    server.server_close()


class PythonView(BrowserTest):
    def setUp(self):
        super().setUp()
        write_volume(self.folder / "ball.npy")
        self.view_of_python = rr.view(rr.volume(numpy.load(self.folder / "ball.npy")), iso=0.5, browser=False)
        self.addCleanup(self.view_of_python.close)
        self.open(self.view_of_python)

    def until(self, is_so):
        end = time.monotonic() + PATIENCE_S
        while not is_so():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def shows_what_python_renders(self):
        self.settle()
        size = self.js("[rhoray.active.canvas.width, rhoray.active.canvas.height]")
        self.assertEqual(self.view_of_python.size, tuple(size))
        self.assertEqual(self.different_pixels(self.view_of_python.picture()._repr_png_()), 0)

    def test_python_moves_the_page(self):
        self.shows_what_python_renders()
        scene = self.view_of_python.scene
        scene["layers"][0]["isovalue"] = 0.3
        self.wait(f"{ISOVALUE} === 0.3")
        scene["layers"][0]["color"] = [0.8, 0.1, 0.1]
        scene["effects"] = {"fog": {"range": [50, 400]}}
        scene["camera"]["position"] = [80, 200, 90]
        self.wait("rhoray.active.camera.position[1] === 200")
        self.shows_what_python_renders()
        self.check_console()

    def test_a_key_and_a_link_in_the_page_are_seen_in_python(self):
        start = self.view_of_python.scene["camera"]["position"]
        self.driver.find_element("id", "picture").send_keys(Keys.ARROW_LEFT)
        self.until(lambda: self.view_of_python.scene["camera"]["position"] != start)
        self.settle()
        self.assertEqual(self.view_of_python.scene["camera"]["position"], self.js("rhoray.active.camera.position"))
        self.driver.execute_script("location.hash = 'iso=0.7&az=10'")
        self.until(lambda: self.view_of_python.scene["layers"][0]["isovalue"] == 0.7)
        self.shows_what_python_renders()
        self.check_console()

    def test_a_page_that_is_loaded_again_shows_the_same(self):
        self.view_of_python.scene["layers"][0]["isovalue"] = 0.2
        self.wait(f"{ISOVALUE} === 0.2")
        self.open(self.view_of_python)
        self.wait(f"{ISOVALUE} === 0.2")
        self.shows_what_python_renders()

    def test_a_wrong_change_is_told_on_both_sides(self):
        self.view_of_python.scene["layers"][0]["colour"] = "red"
        self.wait("document.getElementById('alert-text').textContent.includes('colour')")
        self.until(lambda: self.view_of_python.error is not None)
        self.assertIn("colour", self.view_of_python.error)

    def test_a_notebook_page_shows_it_in_a_frame(self):
        page = self.folder / "notebook.html"
        page.write_text(f"<!doctype html><title>n</title>{self.view_of_python._repr_mimebundle_()['text/html']}")
        with served(self.folder) as address:
            self.driver.get(f"{address}/notebook.html")
            self.driver.switch_to.frame(self.driver.find_element("tag name", "iframe"))
            self.addCleanup(self.driver.switch_to.default_content)
            self.settle()
            self.assertGreater(self.js("rhoray.active.canvas.width"), 100)
            self.wait("document.querySelector('#panel-layers canvas, #panel-layers svg')", "the histogram")
            self.view_of_python.scene["layers"][0]["isovalue"] = 0.4
            self.wait(f"{ISOVALUE} === 0.4")


if __name__ == "__main__":
    unittest.main()

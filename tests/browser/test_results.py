"""What the page saves: links, pictures, scenes, films, tables."""
import csv
import json
import math
import subprocess
import unittest

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from browser import RHORAY
from page import PageTest


class Results(PageTest):
    def test_link_restores_the_picture(self):
        viewer = self.volume()
        self.set_number("layer-0-isovalue", 0.4)
        self.drag(self.canvas(), (0, 0), [(6, 3)] * 10)
        self.settle()
        self.open_section("scene")
        self.click("ambient-occlusion")
        self.settle()
        self.wait("location.hash.includes('iso=')")
        link = self.js("location.hash.slice(1)")
        self.assertIn("iso=0.4", link)
        self.assertNotIn("token", link)
        self.assertLess(len(link), 300)
        self.click("copy-link")
        self.wait("document.getElementById('probe').textContent.includes('append the part after # to the URL')")
        picture = self.rendered(self.command())
        self.set_number("layer-0-isovalue", 0.6)  # the page that is left shows something else
        self.settle()
        self.open(viewer, fragment=link)
        # The link rounds the camera: a few pixels at edges may differ.
        width, height = self.js("[rhoray.active.canvas.width, rhoray.active.canvas.height]")
        self.assertLess(self.different_pixels(picture), 0.01 * width * height)
        self.assertEqual(self.js("rhoray.active.document.layers[0].isovalue"), 0.4)

    def test_a_page_without_a_link_has_the_state_of_the_start(self):
        viewer = self.volume()
        picture = self.pixels()
        self.set_number("layer-0-isovalue", 0.6)
        self.settle()
        self.open(viewer)
        self.assertEqual(self.js("rhoray.active.patch"), {})
        self.assertEqual(self.pixels(), picture)

    def test_saved_scene_and_picture_are_drawn_again_from_another_folder(self):
        self.volume("--iso", "0.5", "--style", "presentation")
        self.set_number("layer-0-isovalue", 0.45)
        for button, name in (("save-scene", "ball.npy.json"), ("save", "ball.npy.png")):
            saved = self.downloaded(name, lambda: self.click(button))
            self.assertEqual(self.different_pixels(self.rendered(f"rhoray render '{saved}'")), 0, name)
        self.assertEqual(self.different_pixels(saved.read_bytes()), 0)

    def test_bookmarks_become_a_film(self):
        self.volume("--iso", "0.5")
        self.open_section("bookmarks")
        self.click("bookmark-add")
        first = self.rendered(self.command())
        self.driver.find_element(By.XPATH, "//button[.='left']").click()
        self.settle()
        self.click("bookmark-add")
        saved = self.downloaded("ball.npy-path.json", lambda: self.click("bookmark-path"))
        scene = json.loads(saved.read_text())
        self.assertEqual([key["time"] for key in scene["camera"]["keyframes"]], [0, 1])
        subprocess.run([str(RHORAY), "render", str(saved), "--frames", "2", "-o", "film_%04d.png"], cwd=self.folder,
                       check=True, capture_output=True)
        self.settle()
        frames = sorted(self.folder.glob("film_*.png"))
        self.assertEqual(len(frames), 2)
        self.assertEqual(self.different_pixels(frames[1].read_bytes()), 0)
        self.click("bookmark-0-go")
        self.settle()
        self.assertEqual(self.different_pixels(frames[0].read_bytes()), 0)
        self.assertEqual(self.different_pixels(first), 0)

    def test_a_reload_keeps_views_pins_and_bookmarks(self):
        self.volume("--iso", "0.5", "--view", "front")
        ActionChains(self.driver).move_to_element_with_offset(self.canvas(), 40, 0).pause(0.2).click().perform()
        self.wait("rhoray.pins.length === 1")
        self.canvas().send_keys("b")
        self.click("compare")
        self.wait("rhoray.views.length === 2")
        self.settle()
        self.click("link-cameras")
        self.find("picture-2").send_keys(Keys.ARROW_LEFT)
        self.settle()
        self.set_number("layer-0-isovalue", 0.2)
        state = """JSON.stringify([rhoray.pins, rhoray.views.map(({ patch, camera }) => [patch, camera]),
                                   document.getElementById('link-cameras').checked,
                                   document.getElementById('bookmarks').textContent])"""
        before = self.js(state)
        self.wait("location.hash.includes('iso=0.2')")
        self.driver.refresh()
        self.wait("window.rhoray && rhoray.views.length === 2")
        self.settle()
        self.wait(f"document.getElementById('bookmarks') && {state} === {json.dumps(before)}", before)
        self.check_console()

    def test_orthographic_bookmarks_keep_their_zoom_in_a_film(self):
        self.volume("--iso", "0.5", "--view", "front")
        self.open_section("bookmarks")
        self.canvas().send_keys("b")  # perspective
        self.canvas().send_keys("o")
        self.settle()
        self.canvas().send_keys("b")
        self.canvas().send_keys("4++++")
        self.settle()
        self.canvas().send_keys("b")
        self.click("bookmark-path")
        self.wait("!document.getElementById('alert').hidden")
        self.assertIn("perspective or orthographic, and the saved views are both", self.find("alert-text").text)
        self.click("bookmark-0-remove")
        saved = self.downloaded("ball.npy-path.json", lambda: self.click("bookmark-path"))
        subprocess.run([str(RHORAY), "render", str(saved), "--frames", "2", "-o", "film_%04d.png"], cwd=self.folder,
                       check=True, capture_output=True)
        frames = sorted(self.folder.glob("film_*.png"))
        self.assertEqual(self.different_pixels(frames[1].read_bytes()), 0)
        self.click("bookmark-0-go")
        self.settle()
        self.assertEqual(self.different_pixels(frames[0].read_bytes()), 0)

    def test_pins_are_saved_as_a_table(self):
        self.volume("--iso", "0.5")
        for offset in (-40, 40):
            ActionChains(self.driver).move_to_element_with_offset(self.canvas(), offset, 0).pause(0.2).click().perform()
            self.wait(f"rhoray.pins.length === {1 if offset < 0 else 2}")
        saved = self.downloaded("ball.npy-pins.csv", lambda: self.click("pins-csv"))
        with saved.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        pins = self.js("rhoray.pins")
        self.assertEqual(len(rows), 2)
        for row, pin in zip(rows, pins):
            self.assertEqual([float(row[axis]) for axis in "xyz"], pin["position"])
            self.assertEqual((float(row["value"]), int(row["cell"])), (pin["value"], pin["cell"]))
        apart = math.dist(*(pin["position"] for pin in pins))
        self.assertAlmostEqual(float(rows[1]["distance_from_previous"]), apart, delta=1e-6 * apart)


if __name__ == "__main__":
    unittest.main()

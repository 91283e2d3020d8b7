"""Random use of the viewer, as many minutes as RHORAY_RANDOM_MINUTES says: the memory of the server must not grow.
RHORAY_RANDOM_SEED repeats the acts of an earlier run, though not their moments.

The real data are used if RHORAY_SHARED_DATA names their folder.
"""
import os
import pathlib
import random
import re
import statistics
import time
import unittest

from selenium.common.exceptions import (ElementClickInterceptedException, ElementNotInteractableException,
                                        MoveTargetOutOfBoundsException, StaleElementReferenceException)
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from browser import write_mesh, write_volume
from page import PageTest

MINUTES = float(os.environ.get("RHORAY_RANDOM_MINUTES", "0"))
DATA = os.environ.get("RHORAY_SHARED_DATA")
SAMPLES = 12  # of the memory
MOST_GROWTH = 8  # MiB
# Of selects with slow choices.
QUICK_CHOICES = {"accuracy": ("preview", "float", "double", "certified"), "show": ("color", "cost", "depth")}
KEYS = list("123456ro+-pbvh") + [Keys.ARROW_LEFT, Keys.ARROW_UP, Keys.ENTER]


@unittest.skipUnless(MINUTES, "RHORAY_RANDOM_MINUTES is not set")
class RandomUse(PageTest):
    def test_memory_does_not_grow_with_a_volume(self):
        self.use_randomly(pathlib.Path(DATA) / "volumes/vhf_ct_head/vhf_ct_head.nhdr" if DATA else "volume.npy")

    def test_memory_does_not_grow_with_a_mesh(self):
        self.use_randomly(pathlib.Path(DATA) / "unstructured/disk_out_ref.ex2" if DATA else "mesh.vtk")

    def use_randomly(self, path):
        write_volume(self.folder / "volume.npy", side=128)
        write_mesh(self.folder / "mesh.vtk", side=16)
        seed = int(os.environ.get("RHORAY_RANDOM_SEED", random.randrange(2**32)))
        print(f"\n  {path}, seed {seed}", flush=True)
        self.random = random.Random(seed)
        viewer = self.view(path, "--box")  # loads the library that draws annotations
        begin, samples, acts = time.time(), [self.memory_at_rest(viewer)], 0
        while time.time() < begin + 60 * MINUTES:
            self.act()
            acts += 1
            time.sleep(self.random.uniform(0, 1.5))
            self.assertIsNone(viewer.process.poll(), "the server lives")
            if time.time() > begin + 60 * MINUTES * len(samples) / SAMPLES:
                samples.append(self.memory_at_rest(viewer))
        print(f"  {acts} acts in {MINUTES:g} minutes", flush=True)
        # The first sample is left out: the program then keeps no data of earlier pictures.
        self.assertLessEqual(statistics.median(samples[-3:]) - statistics.median(samples[1:4]), MOST_GROWTH)

    def memory_at_rest(self, viewer):
        """Of the server, in MiB, with one page in the state of its start and nothing to do."""
        self.check_console()
        self.driver.set_window_size(1100, 760)
        self.open(viewer)
        self.wait("rhoray.active.check && rhoray.active.effects", "the work of idle time")
        time.sleep(1)
        mib = memory(viewer.process.pid)
        print(f"  {mib:.1f} MiB", flush=True)
        return mib

    def act(self):
        acts = (self.open_any_section, self.drag_somewhere, self.drag_handle, self.wheel, self.press_key,
                self.press_key, self.click_control, self.choose, self.slide)
        try:
            self.random.choice(acts)()
        except (ElementNotInteractableException, MoveTargetOutOfBoundsException, StaleElementReferenceException):
            pass  # the panel was built again meanwhile, the control is hidden or off, or the window small
        if self.js("document.getElementById('help').open"):
            self.driver.find_element(By.CSS_SELECTOR, "#help button").click()
        if self.js("!document.getElementById('alert').hidden"):
            try:
                self.click("alert-close")
            except (ElementNotInteractableException, ElementClickInterceptedException):
                pass  # the refusal was mended meanwhile, so the message goes by itself and the picture moves up
            self.wait("document.getElementById('alert').hidden")
        if self.random.random() < 0.02:
            self.driver.refresh()
            # If the user hid all layers, the page only says so.
            self.wait("window.rhoray && rhoray.active && "
                      "(rhoray.active.drawn || !document.getElementById('alert').hidden)")
        if self.random.random() < 0.03:
            self.driver.set_window_size(self.random.choice((700, 900, 1100)), self.random.choice((500, 760)))

    def open_any_section(self):
        self.open_section(self.random.choice(("scene", "clipping", "cost", "bookmarks")))

    def somewhere(self):
        return self.random.choice(self.driver.find_elements(By.CSS_SELECTOR, ".view canvas"))

    def drag_somewhere(self):
        way = [(self.random.randint(-6, 6), self.random.randint(-6, 6))] * self.random.randint(3, 15)
        self.drag(self.somewhere(), (self.random.randint(-20, 20), self.random.randint(-20, 20)), way)

    def drag_handle(self):
        handles = self.driver.find_elements(By.CSS_SELECTOR, ".handle, .face")
        if handles:
            self.drag(self.random.choice(handles), (0, 0), [(self.random.choice((-2, 2)), 0)] * 10)

    def wheel(self):
        ActionChains(self.driver).move_to_element(self.somewhere()).scroll_by_amount(
            0, self.random.choice((-100, 100))).perform()

    def press_key(self):
        self.somewhere().send_keys(self.random.choice(KEYS))

    def click_control(self):
        controls = self.driver.find_elements(By.CSS_SELECTOR, "aside input[type=checkbox], aside .buttons button, "
                                             "[id^=panel-] button")
        self.random.choice([each for each in controls if each.is_displayed()]).click()

    def choose(self):
        boxes = [each for each in self.driver.find_elements(By.CSS_SELECTOR, "aside select") if each.is_displayed()]
        box = self.random.choice(boxes)
        values = [option.get_attribute("value") for option in Select(box).options]
        allowed = QUICK_CHOICES.get(box.get_attribute("id"), values)
        Select(box).select_by_value(self.random.choice([value for value in values if value in allowed]))

    def slide(self):
        sliders = [each for each in self.driver.find_elements(By.CSS_SELECTOR, "aside input[type=range]")
                   if each.is_displayed()]
        if sliders:
            self.random.choice(sliders).send_keys(self.random.choice((Keys.ARROW_LEFT, Keys.ARROW_RIGHT)) * 3)


def memory(pid):
    """Memory of its own of a process, without mapped files, in MiB."""
    return int(re.search(r"RssAnon:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text()).group(1)) / 1024


if __name__ == "__main__":
    unittest.main()

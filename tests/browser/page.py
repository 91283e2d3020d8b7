"""What tests of the page of `rhoray view` have in common."""
import statistics

from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from browser import BrowserTest, write_mesh, write_volume


class PageTest(BrowserTest):
    def volume(self, *words, fragment=""):
        write_volume(self.folder / "ball.npy")
        return self.view("ball.npy", *words, fragment=fragment)

    def mesh(self, *words, fragment=""):
        write_mesh(self.folder / "box.vtk")
        return self.view("box.vtk", *words, fragment=fragment)

    def find(self, element):
        return self.driver.find_element(By.ID, element)

    def use(self, element, act):
        """Calls act() on the element of an id. The page builds a panel's controls anew in the frame after a change:
        if the control that was found is gone by then, selenium does nothing to it, and act() gets the new one."""
        while True:
            try:
                return act(self.find(element))
            except StaleElementReferenceException:
                continue

    def click(self, element):
        self.use(element, lambda control: control.click())

    def open_section(self, name):
        section = self.find(f"panel-{name}").find_element(By.XPATH, "..")
        if section.get_attribute("open") is None:
            section.find_element(By.TAG_NAME, "summary").click()

    def canvas(self):
        return self.find("picture")

    def drag(self, element, start, steps):
        """Presses on an element, at an offset from its middle, moves by steps, and releases."""
        actions = ActionChains(self.driver, duration=16).move_to_element_with_offset(element, *start).click_and_hold()
        for step in steps:
            actions.move_by_offset(*step)
        actions.release().perform()

    def set_number(self, element, value):
        self.use(element, lambda control: control.send_keys(Keys.CONTROL + "a", Keys.NULL, str(value), Keys.ENTER))
        self.settle()

    def say_latencies(self, what):
        times = sorted(self.js("latencies"))
        print(f"\n  {what}: {len(times)} requests, {self.js('drawnCount')} pictures, p50 {statistics.median(times):.0f} ms, "
              f"p95 {times[int(0.95 * (len(times) - 1))]:.0f} ms", end=" ", flush=True)
        self.assertGreater(len(times), 0)

"""Where the page is shown, and what goes wrong there."""
import math
import os
import subprocess
import time
import unittest

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from browser import RHORAY, write_volume
from page import PageTest
from proxy import PrefixProxy


class Places(PageTest):
    """Where the page is shown."""

    def test_below_a_prefix_of_a_proxy(self):
        viewer = self.volume("--iso", "0.5", "--allow-host", "127.0.0.1")
        picture = self.pixels()
        proxy = PrefixProxy("/user/ada/proxy/1", viewer.port)
        self.addCleanup(proxy.close)
        viewer.url = viewer.url.replace(f":{viewer.port}/", f":{proxy.port}/user/ada/proxy/1/")
        self.open(viewer)
        self.assertEqual(self.pixels(), picture)
        self.set_number("layer-0-isovalue", 0.4)
        self.assertNotEqual(self.pixels(), picture)
        self.wait("location.hash.includes('iso=0.4')")
        self.assertEqual(self.js("location.pathname"), "/user/ada/proxy/1/")
        self.driver.refresh()
        self.settle()
        self.assertEqual(self.js("rhoray.active.document.layers[0].isovalue"), 0.4)
        self.check_console()

    def test_on_a_phone_with_fingers(self):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True})
        self.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 5})
        self.addCleanup(self.driver.execute_cdp_cmd, "Emulation.clearDeviceMetricsOverride", {})
        self.addCleanup(self.driver.execute_cdp_cmd, "Emulation.setTouchEmulationEnabled", {"enabled": False})
        self.volume("--iso", "0.5")
        self.assertLessEqual(self.js("document.documentElement.scrollWidth"), 390)
        self.check_against_command()
        box = self.js("rhoray.active.canvas.getBoundingClientRect().toJSON()")
        middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)

        def touch(*fingers):
            """Each finger moves by 40 steps from a place beside the middle to another."""
            for step in range(41):
                points = [{"x": middle[0] + x0 + (x1 - x0) * step / 40,
                           "y": middle[1] + y0 + (y1 - y0) * step / 40, "id": i}
                          for i, ((x0, y0), (x1, y1)) in enumerate(fingers)]
                self.driver.execute_cdp_cmd("Input.dispatchTouchEvent",
                                            {"type": "touchMove" if step else "touchStart", "touchPoints": points})
            self.driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
            self.settle()

        def camera():
            now = self.js("rhoray.active.camera")
            return now["position"], now["target"], math.dist(now["position"], now["target"])

        before = camera()
        touch(((0, 0), (60, 30)))
        turned = camera()
        self.assertNotEqual(turned[0], before[0])
        self.assertAlmostEqual(turned[2], before[2], delta=1e-6 * before[2])
        touch(((-30, 0), (-60, 0)), ((30, 0), (60, 0)))
        nearer = camera()
        self.assertAlmostEqual(nearer[2], turned[2] / 2, delta=0.05 * turned[2])
        touch(((-30, 0), (0, 40)), ((30, 0), (60, 40)))
        moved = camera()
        self.assertNotEqual(moved[1], nearer[1])
        self.assertAlmostEqual(moved[2], nearer[2], delta=0.05 * nearer[2])
        self.check_console()


class SharpScreen(PageTest):
    pixel_ratio = 1.5

    def test_has_a_traced_pixel_for_each_of_its_own(self):
        self.volume("--iso", "0.5")
        for side in ("width", "height"):
            css = self.js(f"rhoray.active.canvas.getBoundingClientRect().{side}")
            self.assertAlmostEqual(self.js(f"rhoray.active.canvas.{side}"), 1.5 * css, delta=1)
        self.check_against_command()
        ActionChains(self.driver).move_to_element(self.canvas()).pause(0.2).click().perform()
        self.wait("rhoray.pins.length === 1")
        pixel = self.js("rhoray.pins[0].pixel")
        for x, side in zip(pixel, ("width", "height")):
            self.assertAlmostEqual(x, self.js(f"rhoray.active.canvas.{side}") / 2, delta=2)


class BlockedStorage(PageTest):
    preferences = {"profile.default_content_setting_values.cookies": 2}

    def test_the_page_needs_no_storage(self):
        self.volume("--iso", "0.5")
        self.driver.execute_script("rhoray.active.connection.socket.close()")
        self.wait("!rhoray.active.isOnline")
        self.wait("rhoray.active.isOnline", "the next connection, with the same token")
        self.settle()
        self.click("help-button")
        self.click("character-keys")
        self.check_console()


class LargeScreen(PageTest):
    window = (5000, 700)

    def test_a_picture_with_fewer_pixels_than_the_window_is_not_stretched(self):
        self.volume("--iso", "0.5", "--view", "front")
        canvas = "rhoray.active.canvas"
        width, height = self.js(f"[{canvas}.width, {canvas}.height]")
        self.assertEqual(width, 4096)
        self.assertAlmostEqual(width / height, self.js(f"{canvas}.clientWidth / {canvas}.clientHeight"), delta=0.01)
        # A pin is where it was clicked, and its marker, too.
        ActionChains(self.driver).move_to_element_with_offset(self.canvas(), 100, 50).pause(0.2).click().perform()
        self.wait("rhoray.pins.length === 1")
        marker = self.js("document.querySelector('.marker').getBoundingClientRect().toJSON()")
        box = self.js(f"{canvas}.getBoundingClientRect().toJSON()")
        for side, offset, extent in (("x", 100, "width"), ("y", 50, "height")):
            self.assertAlmostEqual(marker[side] + marker[extent] / 2, box[side] + box[extent] / 2 + offset, delta=2)


class Trouble(PageTest):
    def state(self):
        return self.find("state").text

    def test_the_page_reconnects_with_its_state(self):
        self.volume()
        self.set_number("layer-0-isovalue", 0.4)
        picture = self.pixels()
        self.driver.execute_script("""
          rhoray.active.canvas.getContext("2d").fillRect(0, 0, 300, 300);
          rhoray.active.connection.socket.close();""")
        self.wait("!rhoray.active.isOnline")
        self.wait("rhoray.active.isOnline", "the next connection")
        self.settle()
        self.assertEqual(self.pixels(), picture)
        self.assertEqual(self.js("rhoray.active.document.layers[0].isovalue"), 0.4)

    def test_the_page_says_that_a_server_is_gone_or_has_another_token(self):
        viewer = self.volume()
        self.assertEqual(viewer.stop(), 0)
        self.assertNotIn("interrupted", viewer.said)
        self.wait("document.getElementById('state').textContent.startsWith('no connection')")
        viewer.start()
        self.wait("document.getElementById('state').textContent.startsWith('not let in: open the URL')")
        self.assertEqual(self.js("document.getElementById('announcement').textContent"), self.state())
        for token in ("%", "()"):
            self.driver.get("about:blank")
            self.driver.get(f"{viewer.url.partition('#')[0]}#token={token}")
            self.wait("document.getElementById('state').textContent.startsWith('not let in: open the URL')", token)
        self.open(viewer)
        self.assertEqual(self.state(), "finished, lossless")

    def test_a_probe_that_waits_is_said_and_so_is_one_that_gets_no_answer(self):
        self.volume("--iso", "0.5", "--view", "front")
        # A server that answers late: the page keeps the probe.
        self.driver.execute_script("""
          const { prober } = rhoray.active, { send } = prober;
          prober.send = (message) => { window.held = () => send(message); return true; };""")
        self.canvas().send_keys("p")
        self.wait("document.getElementById('probe').textContent === 'The probe waits for an answer.'")
        time.sleep(3.5)  # the page once gave up after 3 s
        self.js("held()")
        self.wait("document.getElementById('probe').textContent.startsWith('Position')")
        self.canvas().send_keys("p")
        self.wait("document.getElementById('probe').textContent === 'The probe waits for an answer.'")
        self.driver.execute_script("rhoray.active.connection.socket.close()")
        self.wait("document.getElementById('probe').textContent.startsWith('The probe got no answer: ')")
        self.wait("rhoray.active.isOnline", "the next connection")

    def test_a_file_cut_short_is_said_and_the_server_lives(self):
        write_volume(self.folder / "ball.npy")
        subprocess.run([str(RHORAY), "pack", "ball.npy", "-o", "ball.rho"], cwd=self.folder, check=True,
                       capture_output=True)
        viewer = self.view("ball.rho", "--iso", "0.5")
        os.truncate(self.folder / "ball.rho", 4096)
        self.drag(self.canvas(), (0, 0), [(6, 3)] * 5)
        self.wait("!document.getElementById('alert').hidden", "a sentence about the damage")
        self.assertIn("ball.rho", self.find("alert-text").text)
        self.assertIsNone(viewer.process.poll(), "the server lives")
        self.driver.refresh()
        self.wait("window.rhoray && rhoray.active.hello")

    def test_bad_links_are_said_and_change_nothing(self):
        for fragment in ("iso=high", "patch=%7B", "patch=%7B%22data%22%3A%7B%22data%22%3A%7B%22file%22%3A%22x%22%7D%7D%7D",
                         "az=left", "zoom=0", "at=1,2"):
            with self.subTest(fragment):
                viewer = self.volume()
                before = self.pixels()
                self.open(viewer, fragment=fragment)
                self.wait("!document.getElementById('alert').hidden")
                self.assertRegex(self.find("alert-text").text, "^The link cannot be (read|shown): ")
                self.assertEqual(self.js("rhoray.active.patch"), {})
                self.assertEqual(self.pixels(), before)
                viewer.stop()

    def test_what_the_server_refuses_is_said_and_can_be_undone(self):
        self.volume("--iso", "0.5")
        before = self.pixels()
        self.click("layer-0-visible")
        self.wait("!document.getElementById('alert').hidden")
        self.assertIn("no layer is visible", self.find("alert-text").text)
        self.assertEqual(self.state(), "refused")
        self.click("layer-0-visible")
        self.settle()
        self.assertEqual(self.pixels(), before)
        self.wait("document.getElementById('alert').hidden")

    def test_each_of_two_views_has_its_own_state_and_its_own_errors(self):
        self.volume("--iso", "0.5")
        self.click("compare")
        self.wait("rhoray.views.length === 2")
        self.settle()
        self.find("picture-2").send_keys(Keys.NULL)
        self.click("layer-0-visible")
        self.wait("!document.getElementById('alert').hidden")
        self.assertRegex(self.find("alert-text").text, "^View B: .*no layer is visible")
        self.canvas().send_keys(Keys.ARROW_LEFT)  # another view's picture does not mend it
        self.wait("rhoray.views[0].isAtRest && rhoray.views[0].drawn.isLossless")
        labels = [label.text for label in self.driver.find_elements(By.CLASS_NAME, "view-label")]
        self.assertEqual(labels, ["View A, edited by the panels: finished, lossless", "View B: refused"])
        self.assertFalse(self.js("document.getElementById('alert').hidden"))
        self.find("picture-2").send_keys(Keys.NULL)
        self.click("layer-0-visible")
        self.wait("document.getElementById('alert').hidden")
        self.click("layer-0-visible")
        self.wait("!document.getElementById('alert').hidden")
        self.click("compare")  # the refusal goes with its view
        self.wait("document.getElementById('alert').hidden")


if __name__ == "__main__":
    unittest.main()

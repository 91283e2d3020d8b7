"""The page of `rhoray view`, driven as a user drives it."""
import csv
import json
import math
import os
import statistics
import subprocess
import unittest
import urllib.parse

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from browser import RHORAY, BrowserTest, write_mesh, write_volume
from proxy import PrefixProxy

# Notes when each request was sent and when its picture was drawn.
WATCH = """
window.sentAt = new Map(); window.latencies = []; window.drawnCount = 0;
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function(text) {
  const message = JSON.parse(text);
  if (message.n) sentAt.set(message.n, performance.now());
  return send.call(this, text);
};
document.addEventListener("drawn", (event) => {
  ++drawnCount;
  for (const [n, at] of sentAt) if (n <= event.detail.request) {
    latencies.push(performance.now() - at);
    sentAt.delete(n);
  }
});
"""


class PageTest(BrowserTest):
    def volume(self, *words, fragment=""):
        write_volume(self.folder / "ball.npy")
        return self.view("ball.npy", *words, fragment=fragment)

    def mesh(self, *words, fragment=""):
        write_mesh(self.folder / "box.vtk")
        return self.view("box.vtk", *words, fragment=fragment)

    def find(self, element):
        return self.driver.find_element(By.ID, element)

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
        self.find(element).send_keys(Keys.CONTROL + "a", Keys.NULL, str(value), Keys.ENTER)
        self.settle()

    def say_latencies(self, what):
        times = sorted(self.js("latencies"))
        print(f"\n  {what}: {len(times)} requests, {self.js('drawnCount')} pictures, p50 {statistics.median(times):.0f} ms, "
              f"p95 {times[int(0.95 * (len(times) - 1))]:.0f} ms", end=" ", flush=True)
        self.assertGreater(len(times), 0)


class Pictures(PageTest):
    def test_settled_picture_is_that_of_the_printed_command(self):
        self.volume()
        self.check_against_command()
        self.driver.find_element(By.XPATH, "//button[.='left']").click()
        self.settle()
        self.check_against_command()
        self.check_console()

    def test_mesh_with_colours_and_annotations_is_that_of_the_printed_command(self):
        self.mesh()
        self.check_against_command()
        self.open_section("scene")
        self.find("annotation-axes").click()
        self.settle()
        self.check_against_command()

    def test_page_asks_nobody_else(self):
        viewer = self.volume()
        names = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        urls = {name["params"]["request"]["url"] for name in names if name["method"] == "Network.requestWillBeSent"}
        urls |= {name["params"]["url"] for name in names if name["method"] == "Network.webSocketCreated"}
        self.assertGreater(len(urls), 3)
        for url in urls:
            self.assertIn(urllib.parse.urlsplit(url).netloc, (f"127.0.0.1:{viewer.port}", ""), url)
            self.assertNotIn("token", url.split("#")[0])


class Motion(PageTest):
    def test_drags_of_camera_and_isovalue(self):
        self.volume()
        self.driver.execute_script(WATCH)
        before = self.js("rhoray.active.camera.position")
        self.drag(self.canvas(), (0, 0), [(4, 2)] * 40)
        self.say_latencies("camera")
        self.settle()
        self.assertNotEqual(self.js("rhoray.active.camera.position"), before)
        self.driver.execute_script("latencies.length = 0; drawnCount = 0")
        before = self.js("rhoray.active.document.layers[0].isovalue")
        self.drag(self.find("layer-0-handle"), (0, 0), [(1, 0)] * 40)
        self.say_latencies("isovalue")
        self.settle()
        self.assertGreater(self.js("rhoray.active.document.layers[0].isovalue"), before)
        self.check_against_command()
        self.check_console()

    def test_wheel_zooms_and_a_double_click_moves_the_pivot(self):
        self.volume()
        distance = "Math.hypot(...rhoray.active.camera.position.map((x, i) => x - rhoray.active.camera.target[i]))"
        before = self.js(distance)
        ActionChains(self.driver).scroll_from_origin(ScrollOrigin.from_element(self.canvas()), 0, -300).perform()
        self.wait(f"{distance} < {0.9 * before}")
        self.settle()
        target = self.js("rhoray.active.camera.target")
        ActionChains(self.driver).move_to_element_with_offset(self.canvas(), 60, 40).double_click().perform()
        self.wait(f"JSON.stringify(rhoray.active.camera.target) !== JSON.stringify({json.dumps(target)})")
        self.settle()

    def test_everything_by_keyboard(self):
        self.volume()
        for _ in range(20):
            if self.js("document.activeElement.id") == "picture":
                break
            ActionChains(self.driver).send_keys(Keys.TAB).perform()
        self.assertEqual(self.js("document.activeElement.id"), "picture")
        outline = self.js("getComputedStyle(document.activeElement).outlineStyle")
        self.assertNotEqual(outline, "none", "the focus can be seen")
        for keys, changed in ((Keys.ARROW_LEFT, "position"), (Keys.ARROW_UP, "position"), ("+", "position"),
                              ("3", "position"), ("o", "ortho_height")):
            before = self.js(f"JSON.stringify(rhoray.active.camera.{changed} ?? null)")
            ActionChains(self.driver).send_keys(keys).perform()
            self.wait(f"JSON.stringify(rhoray.active.camera.{changed} ?? null) !== {json.dumps(before)}", keys)
        self.settle()
        ActionChains(self.driver).send_keys("p").perform()
        self.wait("rhoray.active.probe && rhoray.active.probe.position", "the probe of the centre")
        ActionChains(self.driver).send_keys(Keys.ENTER).perform()
        self.wait("rhoray.pins.length === 1")
        handle = self.find("layer-0-handle")
        before = self.js("rhoray.active.document.layers[0].isovalue")
        handle.send_keys(Keys.ARROW_RIGHT)
        self.wait(f"rhoray.active.document.layers[0].isovalue > {before}")
        ActionChains(self.driver).send_keys("h").perform()
        self.wait("document.getElementById('help').open")
        ActionChains(self.driver).send_keys(Keys.ESCAPE).perform()
        self.wait("!document.getElementById('help').open")


class Tools(PageTest):
    def test_probe_says_position_value_cell_and_proven_error(self):
        self.volume("--iso", "0.5", "--view", "front")
        ActionChains(self.driver).move_to_element(self.canvas()).perform()
        self.wait("rhoray.active.probe && rhoray.active.probe.position")
        probe = self.js("rhoray.active.probe")
        self.assertEqual(probe["value"], 0.5)
        self.assertLess(probe["error"], 1e-3)
        # The samples stand at 0 to 63; the ball's surface for 0.5 is 16 before the middle, give or
        # take the waves.
        self.assertAlmostEqual(probe["position"][0], 31.5, delta=1)
        self.assertAlmostEqual(probe["position"][1], 31.5 - 15.75, delta=3)
        self.assertIn("0.5", self.find("probe").text)
        for offset in (-40, 40):
            ActionChains(self.driver).move_to_element_with_offset(self.canvas(), offset, 0).pause(0.2).click().perform()
            self.wait(f"rhoray.pins.length === {1 if offset < 0 else 2}")
        self.assertIn("distance from pin 1", self.find("pins").text)

    def test_clipping_and_the_slice_on_the_cut(self):
        self.volume("--iso", "0.3")
        whole = self.pixels()
        self.open_section("clipping")
        self.find("clip-plane").click()
        self.settle()
        clipped = self.pixels()
        self.assertNotEqual(clipped, whole)
        self.find("clip-slice").click()
        self.settle()
        self.assertNotEqual(self.pixels(), clipped)
        self.check_against_command()
        before = self.js("rhoray.active.document.clip.planes[0].point[0]")
        handle = self.driver.find_element(By.CSS_SELECTOR, ".face[aria-label^='Clip plane']")
        for key, moves in ((Keys.ARROW_RIGHT, lambda now: now > before), (Keys.HOME, lambda now: now < before)):
            handle.send_keys(key)
            self.settle()
            self.assertTrue(moves(self.js("rhoray.active.document.clip.planes[0].point[0]")))
            self.assertEqual(self.js("rhoray.active.layers.at(-1).spec.normal"), [1, 0, 0])
            self.check_against_command()
        for switch in ("clip-slice", "clip-plane", "clip-box"):
            self.find(switch).click()
            self.settle()
        self.assertEqual(len(self.driver.find_elements(By.CSS_SELECTOR, ".face")), 6)
        handle = self.driver.find_element(By.CSS_SELECTOR, ".face:not([hidden])")
        self.drag(handle, (0, 0), [(8, 8)] * 5)
        self.settle()
        self.assertTrue(self.js("rhoray.active.document.clip.box"))
        self.find("clip-handles").click()
        self.wait("document.querySelectorAll('.face').length === 0")
        self.check_console()

    def test_layers_fields_colours_and_effects(self):
        self.mesh("--iso", "0.5", "--field", "height")
        seen = {self.pixels()}

        def changed(why):
            self.settle()
            now = self.pixels()
            self.assertNotIn(now, seen, why)
            seen.add(now)

        self.find("data-0-histogram-add").click()
        changed("another isovalue")
        self.assertEqual(self.js("rhoray.active.layers.filter(l => l.spec.type === 'isosurface').length"), 2)
        self.find("layer-0-visible").click()
        changed("a hidden layer")
        self.find("layer-0-visible").click()
        self.settle()
        Select(self.find("layer-0-color-by")).select_by_value("distance")
        changed("coloured by a field")
        self.open_section("scene")
        self.find("annotation-box").click()
        changed("box")
        self.check_against_command()
        Select(self.find("style")).select_by_value("paper")
        changed("style")
        Select(self.find("show")).select_by_value("cost")
        changed("heat map")
        self.check_console()

    def test_effects_cost_rays_only_where_they_are_used(self):
        self.volume("--iso", "0.5")
        plain = self.pixels()
        self.open_section("scene")
        for effect, rays in (("shadows", "shadow_rays"), ("ambient-occlusion", "occlusion_rays")):
            self.assertEqual(self.js(f"rhoray.active.finished.statistics.{rays}"), 0)
            self.find(effect).click()
            self.settle()
            self.assertGreater(self.js(f"rhoray.active.finished.statistics.{rays}"), 0)
            self.assertNotEqual(self.pixels(), plain)
        self.check_against_command()
        self.open_section("cost")
        self.wait("rhoray.active.effects", "the times of effects")
        for effect in ("antialiasing", "shadows", "ambient occlusion"):
            self.assertRegex(self.find("cost-effects").text, rf"{effect} -?[0-9.]+ ms")

    def test_accuracy_is_checked_in_idle_time(self):
        self.volume("--iso", "0.5")
        self.open_section("scene")
        for level in ("double", "certified", "float"):
            Select(self.find("accuracy")).select_by_value(level)
            self.settle()
            self.wait("rhoray.active.check", "the check against exact arithmetic")
            check = self.js("rhoray.active.check")
            self.assertEqual((check["missed"], check["false_hits"]), (0, 0))
            self.assertGreater(check["pixels"], 100)
        self.assertIn(" ms", self.js("document.querySelector('#accuracy option[value=double]').textContent"))
        self.open_section("cost")
        self.assertIn("0 false negatives, 0 false positives", self.find("cost-check").text)

    def test_a_method_instead_of_an_accuracy_level(self):
        self.volume("--iso", "0.5")
        self.open_section("scene")
        for method, command in (("sampled:0.5", "--method sampled:0.5"), ("double", "--accuracy double")):
            Select(self.find("accuracy")).select_by_value(method)
            self.settle()
            self.wait("rhoray.active.finished.n === rhoray.active.drawn.request")
            self.assertEqual(self.js("rhoray.active.method"), method)
            self.assertIn(command, self.command())
            self.check_against_command()
            self.wait(f"document.querySelector('#accuracy option[value=\"{method}\"]').textContent.endsWith(' ms')")

    def test_two_views_with_linked_cameras_and_a_wipe(self):
        self.volume("--iso", "0.5")
        self.find("compare").click()
        self.wait("rhoray.views.length === 2")
        self.settle()
        self.set_number("layer-0-isovalue", 0.2)
        values = self.js("rhoray.views.map((view) => view.document.layers[0].isovalue)")
        self.assertEqual(sorted(values), [0.2, 0.5])
        self.drag(self.canvas(), (0, 0), [(5, 0)] * 10)
        self.settle()
        cameras = self.js("rhoray.views.map((view) => JSON.stringify(view.camera))")
        self.assertEqual(*cameras)
        Select(self.find("layout")).select_by_value("wipe")
        self.settle()
        before = self.find("divider").get_attribute("aria-valuenow")
        self.find("divider").send_keys(Keys.ARROW_LEFT)
        self.assertNotEqual(self.find("divider").get_attribute("aria-valuenow"), before)
        self.find("compare").click()
        self.wait("rhoray.views.length === 1")
        self.check_console()


    def test_two_files_in_two_views(self):
        for name, wave in (("a", 9), ("b", 4)):
            write_volume(self.folder / f"{name}.npy", wave=wave)
        self.view("a.npy", "b.npy", "--iso", "0.5")
        self.find("compare").click()
        self.wait("rhoray.views.length === 2")
        for view, layer in ((1, 0), (0, 1)):
            self.activate(view)
            self.find(f"layer-{layer}-visible").click()
        self.settle()
        drawn = "rhoray.views.map(({ resolved }) => Object.values(resolved.document.layers).map(({ data }) => data))"
        self.assertEqual(self.js(drawn), [["data"], ["file 2"]])
        for view, name in enumerate("ab"):
            self.activate(view)
            self.check_against_command()
            self.assertIn(f"{name}.npy", self.command())
        self.check_console()

    def activate(self, view):
        self.find(("picture", "picture-2")[view]).send_keys(Keys.NULL)
        self.settle()
        self.assertEqual(self.js("rhoray.active.name"), "AB"[view])


class Directions(PageTest):
    def test_axes_and_scale_bar_follow_the_camera(self):
        self.volume("--iso", "0.5", "--view", "front")
        self.assertRegex(self.label(), "^-y faces the viewer; scale bar: [125]0* ?(at the pivot)?$")
        length, pixels = self.scale_bar()
        self.open_section("scene")
        self.find("orthographic").click()
        self.settle()
        self.assertNotIn("pivot", self.label())
        self.driver.find_element(By.ID, "standard-views").find_elements(By.TAG_NAME, "button")[4].click()
        self.settle()
        self.assertIn("+z faces the viewer", self.label())
        self.canvas().send_keys("++++++++++")
        self.settle()
        zoomed_length, zoomed_pixels = self.scale_bar()
        # In an orthographic picture the bar can be checked against the document: its height in the
        # world is known.
        height = self.js("rhoray.active.camera.ortho_height") / self.js("rhoray.active.canvas.clientHeight")
        self.assertAlmostEqual(zoomed_length / zoomed_pixels / height, 1, delta=0.02)  # borders of the bar: 2 pixels
        self.assertGreater(length / pixels, 2 * zoomed_length / zoomed_pixels)

    def test_letters_of_directions_in_a_body(self):
        (self.folder / "body.nrrd").write_bytes(
            b"NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 8 8 8\n"
            b"space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n" +
            bytes(range(256)) * 2)
        self.view("body.nrrd", "--iso", "100", "--view", "front")
        self.assertIn("A faces the viewer", self.label())
        self.assertEqual(sorted(each.text for each in self.driver.find_elements(By.CSS_SELECTOR, ".directions text")),
                         sorted("RLAPIS"))

    def label(self):
        return self.driver.find_element(By.CLASS_NAME, "orientation").get_attribute("aria-label").replace("\u2212", "-")

    def scale_bar(self):
        """Its length in the world, and in pixels."""
        return (float(self.label().split("scale bar: ")[1].split()[0]),
                self.driver.find_element(By.CLASS_NAME, "scale-bar").rect["width"])


class Results(PageTest):
    def test_link_restores_the_picture(self):
        viewer = self.volume()
        self.set_number("layer-0-isovalue", 0.4)
        self.drag(self.canvas(), (0, 0), [(6, 3)] * 10)
        self.settle()
        self.open_section("scene")
        self.find("ambient-occlusion").click()
        self.settle()
        self.wait("location.hash.includes('iso=')")
        link = self.js("location.hash.slice(1)")
        self.assertIn("iso=0.4", link)
        self.assertNotIn("token", link)
        self.assertLess(len(link), 300)
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
            saved = self.downloaded(name, lambda: self.find(button).click())
            self.assertEqual(self.different_pixels(self.rendered(f"rhoray render '{saved}'")), 0, name)
        self.assertEqual(self.different_pixels(saved.read_bytes()), 0)

    def test_bookmarks_become_a_film(self):
        self.volume("--iso", "0.5")
        self.open_section("bookmarks")
        self.find("bookmark-add").click()
        first = self.rendered(self.command())
        self.driver.find_element(By.XPATH, "//button[.='left']").click()
        self.settle()
        self.find("bookmark-add").click()
        saved = self.downloaded("ball.npy-path.json", lambda: self.find("bookmark-path").click())
        scene = json.loads(saved.read_text())
        self.assertEqual([key["time"] for key in scene["camera"]["keyframes"]], [0, 1])
        subprocess.run([str(RHORAY), "render", str(saved), "--frames", "2", "-o", "film_%04d.png"], cwd=self.folder,
                       check=True, capture_output=True)
        self.settle()
        frames = sorted(self.folder.glob("film_*.png"))
        self.assertEqual(len(frames), 2)
        self.assertEqual(self.different_pixels(frames[1].read_bytes()), 0)
        self.find("bookmark-0-go").click()
        self.settle()
        self.assertEqual(self.different_pixels(frames[0].read_bytes()), 0)
        self.assertEqual(self.different_pixels(first), 0)

    def test_pins_are_saved_as_a_table(self):
        self.volume("--iso", "0.5")
        for offset in (-40, 40):
            ActionChains(self.driver).move_to_element_with_offset(self.canvas(), offset, 0).pause(0.2).click().perform()
            self.wait(f"rhoray.pins.length === {1 if offset < 0 else 2}")
        saved = self.downloaded("ball.npy-pins.csv", lambda: self.find("pins-csv").click())
        with saved.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        pins = self.js("rhoray.pins")
        self.assertEqual(len(rows), 2)
        for row, pin in zip(rows, pins):
            self.assertEqual([float(row[axis]) for axis in "xyz"], pin["position"])
            self.assertEqual((float(row["value"]), int(row["cell"])), (pin["value"], pin["cell"]))
        apart = math.dist(*(pin["position"] for pin in pins))
        self.assertAlmostEqual(float(rows[1]["distance_from_previous"]), apart, delta=1e-6 * apart)


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
        self.wait("document.getElementById('state').textContent.startsWith('no connection')")
        viewer.start()
        self.wait("document.getElementById('state').textContent.startsWith('not let in: open the URL')")
        self.assertEqual(self.js("document.getElementById('announcement').textContent"), self.state())
        self.open(viewer)
        self.assertEqual(self.state(), "finished, lossless")

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
        self.find("layer-0-visible").click()
        self.wait("!document.getElementById('alert').hidden")
        self.assertIn("no layer is visible", self.find("alert-text").text)
        self.assertEqual(self.state(), "refused")
        self.find("layer-0-visible").click()
        self.settle()
        self.assertEqual(self.pixels(), before)


if __name__ == "__main__":
    unittest.main()

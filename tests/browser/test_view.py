"""The controls of the page of `rhoray view`, used as a user uses them."""
import json
import unittest
import urllib.parse

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from browser import write_volume
from page import PageTest

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
        self.click("annotation-axes")
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
        ActionChains(self.driver).send_keys("t").perform()
        self.wait("`${rhoray.active.camera.target}` === `${rhoray.pins[0].position}`", "the pivot")
        handle = self.find("layer-0-handle")
        before = self.js("rhoray.active.document.layers[0].isovalue")
        handle.send_keys(Keys.ARROW_RIGHT)
        self.wait(f"rhoray.active.document.layers[0].isovalue > {before}")
        for key in "h?":
            ActionChains(self.driver).send_keys(key).perform()
            self.wait("document.getElementById('help').open")
            ActionChains(self.driver).send_keys(Keys.ESCAPE).perform()
            self.wait("!document.getElementById('help').open")

    def test_the_middle_becomes_the_pivot_where_no_point_is_known(self):
        self.volume("--iso", "0.5", "--view", "front")
        target = "`${rhoray.active.camera.target}`"
        before = self.js(target)
        self.canvas().send_keys("t")
        self.wait(f"{target} !== '{before}'")
        self.wait("document.getElementById('probe').textContent.startsWith('The view turns around this point')")
        self.assertEqual(self.js("rhoray.active.camera.target"), self.js("rhoray.active.probe.position"))

    def test_keys_of_one_character_can_be_switched_off(self):
        viewer = self.volume()

        def switch():
            self.click("help-button")
            self.click("character-keys")
            ActionChains(self.driver).send_keys(Keys.ESCAPE).perform()
            self.wait("!document.getElementById('help').open")

        def press(keys):
            self.canvas().click()
            ActionChains(self.driver).send_keys(keys).perform()

        switch()
        self.open(viewer)  # the browser remembers it
        camera = "JSON.stringify(rhoray.active.camera)"
        before = self.js(camera)
        press("o3")
        self.assertEqual(self.js(camera), before)
        press(Keys.ARROW_LEFT)  # the other keys stay
        self.wait(f"{camera} !== {json.dumps(before)}")
        switch()
        press("o")
        self.wait("rhoray.active.camera.ortho_height")


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

    def test_a_click_is_answered_while_a_picture_takes_long(self):
        self.driver.set_window_size(2200, 1500)
        self.addCleanup(self.driver.set_window_size, *self.window)
        self.volume("--iso", "0.5", "--view", "front", "--style", "presentation")
        self.driver.execute_script("""rhoray.active.set(["effects", "ambient_occlusion"], { samples: 64 });
          rhoray.active.set(["image", "antialias"], 16);""")
        self.wait("rhoray.active.drawn.request === rhoray.active.requestNumber", "the first pass")
        ActionChains(self.driver).move_to_element(self.canvas()).click().perform()
        self.wait("rhoray.pins.length === 1")
        self.assertNotEqual(self.js("rhoray.active.finished.n"), self.js("rhoray.active.requestNumber"),
                            "the picture no longer takes long: is this case still the hard one?")

    def test_clipping_and_the_slice_on_the_cut(self):
        self.volume("--iso", "0.3")
        whole = self.pixels()
        self.open_section("clipping")
        self.click("clip-add")
        self.settle()
        clipped = self.pixels()
        self.assertNotEqual(clipped, whole)
        self.click("clip-0-slice")
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
        for switch in ("clip-0-slice", "clip-0-remove", "clip-box"):
            self.click(switch)
            self.settle()
        self.assertEqual(len(self.driver.find_elements(By.CSS_SELECTOR, ".face")), 6)
        faces = "Object.fromEntries(rhoray.active.clipHandles.map(({ name, value }) => [name, value()]))"
        before = self.js(faces)
        handle = self.driver.find_element(By.CSS_SELECTOR, ".face:not([hidden])")
        name = handle.get_attribute("aria-label").removesuffix(", view A")
        picture, place = self.canvas().rect, handle.rect
        inward = [int((picture[side] + picture[extent] / 2 - place[side]) / 10)
                  for side, extent in (("x", "width"), ("y", "height"))]
        self.drag(handle, (0, 0), [inward] * 5)
        self.settle()
        moved = self.js(faces).items() - before.items()
        self.assertEqual([face for face, _ in moved], [name], "the other faces stay")
        self.assertGreater(abs(dict(moved)[name] - before[name]), 1)
        self.click("clip-handles")
        self.wait("document.querySelectorAll('.face').length === 0")
        self.check_console()

    def test_several_clip_planes(self):
        write_volume(self.folder / "ball.npy")
        planes = [{"point": [20, 31, 31], "normal": [1, 0, 0]}, {"point": [31, 31, 40], "normal": [0, 0, -1]}]
        (self.folder / "ball.json").write_text(json.dumps({
            "data": {"ball": {"file": "ball.npy"}}, "layers": [{"type": "isosurface", "data": "ball", "isovalue": 0.3}],
            "clip": {"planes": planes}}))
        self.view("ball.json")
        self.open_section("clipping")
        self.assertEqual(len(self.driver.find_elements(By.CSS_SELECTOR, ".face")), 2)
        self.click("clip-add")
        self.settle()
        self.assertEqual(len(self.driver.find_elements(By.CSS_SELECTOR, ".face")), 3)
        self.click("clip-add")  # planes 3 and 4 both go through the middle of the data
        places = "[...document.querySelectorAll('.face')].map(({ style }) => `${style.left} ${style.top}`)"
        self.wait(f"{places}.length === 4")
        self.settle()
        self.assertEqual(len(set(self.js(places))), 4, "no handle covers another")
        self.click("clip-3-remove")
        self.settle()
        now = "rhoray.active.document.clip.planes"
        for index in (1, 2):
            self.click(f"clip-{index}-slice")
        self.settle()
        third = self.js(f"{now}[2]")
        self.driver.find_element(By.CSS_SELECTOR, ".face[aria-label^='Clip plane 2']").send_keys(Keys.ARROW_LEFT)
        self.settle()
        moved = self.js(now)
        self.assertEqual((moved[0], moved[2]), (planes[0], third))
        self.assertGreater(moved[1]["point"][2], 40)
        slices = "rhoray.active.layers.filter(({ spec }) => spec.type === 'slice').map(({ spec }) => spec.normal)"
        self.assertEqual(self.js(slices), [[0, 0, -1], third["normal"]])
        self.check_against_command()
        self.click("clip-1-remove")  # its slice goes with it
        self.settle()
        self.assertEqual(self.js(now), [planes[0], third])
        self.assertEqual(self.js(slices), [third["normal"]])
        self.click("clip-0-remove")
        self.settle()
        self.assertEqual(self.js(now), [third])
        self.check_against_command()
        self.check_console()

    def test_effects_cost_rays_only_where_they_are_used(self):
        self.volume("--iso", "0.5")
        plain = self.pixels()
        self.open_section("scene")
        for effect, rays in (("shadows", "shadow_rays"), ("ambient-occlusion", "occlusion_rays")):
            self.assertEqual(self.js(f"rhoray.active.finished.statistics.{rays}"), 0)
            self.click(effect)
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
        self.click("compare")
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
        self.click("compare")
        self.wait("rhoray.views.length === 1")
        self.check_console()

    def test_two_views_with_two_fields_two_methods_and_cameras_of_their_own(self):
        self.mesh("--iso", "0.5", "--field", "height")
        self.click("compare")
        self.wait("rhoray.views.length === 2")
        self.settle()
        self.click("link-cameras")
        self.open_section("scene")
        first = self.js("JSON.stringify(rhoray.views[0].camera)")
        self.activate(1)
        Select(self.find("data-0-field")).select_by_value("distance")
        self.settle()
        Select(self.find("accuracy")).select_by_value("certified")
        self.settle()
        self.drag(self.find("picture-2"), (0, 0), [(5, 0)] * 10)
        self.settle()
        self.assertEqual(self.js("JSON.stringify(rhoray.views[0].camera)"), first)
        self.assertNotEqual(self.js("JSON.stringify(rhoray.views[1].camera)"), first)
        fields = "rhoray.views.map((view) => view.layers[0].info[0].field.name)"
        self.assertEqual(self.js(fields), ["height", "distance"])
        self.assertEqual(self.js("rhoray.views.map((view) => view.method)"), ["float", "certified"])
        for view in range(2):
            self.activate(view)
            self.check_against_command()
        self.click("link-cameras")
        self.settle()
        self.assertEqual(*self.js("rhoray.views.map((view) => JSON.stringify(view.camera))"))
        self.check_console()

    def test_two_files_in_two_views(self):
        for name, wave in (("a", 9), ("b", 4)):
            write_volume(self.folder / f"{name}.npy", wave=wave)
        self.view("a.npy", "b.npy", "--iso", "0.5")
        self.click("compare")
        self.wait("rhoray.views.length === 2")
        for view, layer in ((1, 0), (0, 1)):
            self.activate(view)
            self.click(f"layer-{layer}-visible")
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
        self.click("orthographic")
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


if __name__ == "__main__":
    unittest.main()

"""Layers, fields, isovalues, colours and heat maps in the page of `rhoray view`."""
import unittest

from selenium.webdriver.support.ui import Select

from page import PageTest


class Layers(PageTest):
    def test_layers_fields_colours_and_effects(self):
        self.mesh("--iso", "0.5", "--field", "height")
        seen = {self.pixels()}

        def changed(why):
            self.settle()
            now = self.pixels()
            self.assertNotIn(now, seen, why)
            seen.add(now)

        self.click("data-0-histogram-add")
        changed("another isovalue")
        self.assertEqual(self.js("rhoray.active.layers.filter(l => l.spec.type === 'isosurface').length"), 2)
        self.click("layer-0-visible")
        changed("a hidden layer")
        self.click("layer-0-visible")
        self.settle()
        Select(self.find("layer-0-color-by")).select_by_value("distance")
        changed("coloured by a field")
        self.open_section("scene")
        self.click("annotation-box")
        changed("box")
        self.check_against_command()
        Select(self.find("style")).select_by_value("paper")
        changed("style")
        self.check_console()

    def test_each_of_several_handles_moves_its_own_isovalue(self):
        self.volume("--iso", "0.3,0.6")
        values = "rhoray.active.layers.flatMap((layer) => rhoray.active.isovalues(layer))"
        first, second = self.js(values)
        self.assertEqual(self.js("rhoray.active.layers.map((layer) => layer.info.length)"), [1, 1])
        self.drag(self.find("layer-1-handle"), (0, 0), [(1, 0)] * 20)
        self.settle()
        moved = self.js(values)
        self.assertEqual(moved[0], first)
        self.assertGreater(moved[1], second)
        self.drag(self.find("layer-0-handle"), (0, 0), [(-1, 0)] * 10)
        self.settle()
        self.assertLess(self.js(values)[0], first)
        self.assertEqual(self.js(values)[1], moved[1])
        self.check_against_command()

    def test_counts_are_logarithmic_or_linear(self):
        self.volume("--iso", "0.5")
        counts = "document.querySelector('.histogram-counts').toDataURL()"
        logarithmic = self.js(counts)
        self.click("data-0-histogram-log")
        self.wait(f"{counts} !== '{logarithmic}'")
        self.click("data-0-histogram-log")
        self.wait(f"{counts} === '{logarithmic}'")

    def test_another_field_has_its_own_range_and_isovalue(self):
        self.mesh("--iso", "0.05", "--field", "height")
        ends = self.driver.find_element("class name", "ends").text
        Select(self.find("data-0-field")).select_by_value("distance")
        self.settle()
        self.assertEqual(self.js("rhoray.active.layers[0].info[0].field.name"), "distance")
        self.assertNotEqual(self.driver.find_element("class name", "ends").text, ends)
        self.assertIn("distance", self.driver.find_element("class name", "ends").text)
        self.check_against_command()

    def test_colour_map_and_range(self):
        self.mesh("--iso", "0.5", "--field", "height")
        Select(self.find("layer-0-color-by")).select_by_value("distance")
        self.settle()
        self.find("layer-0-colors").find_element("tag name", "summary").click()
        seen = {self.pixels()}
        default = self.js("rhoray.active.layers[0].info[0].spec.range")
        for act, key, value in (
                (lambda: Select(self.find("layer-0-colormap")).select_by_value("plasma"), "colormap", "plasma"),
                (lambda: self.set_number("layer-0-range-first", 0.25), "range", [0.25, default[1]]),
                (lambda: self.set_number("layer-0-range-last", 1), "range", [0.25, 1]),
                (lambda: Select(self.find("layer-0-scale")).select_by_value("log"), "scale", "log")):
            act()
            self.settle()
            self.assertEqual(self.js(f"rhoray.active.layers[0].spec.{key}"), value)
            self.assertNotIn(self.pixels(), seen, key)
            seen.add(self.pixels())
            self.check_against_command()
        self.set_number("layer-0-range-first", 2)
        self.assertIn("must be below", self.find("alert-text").text)
        self.assertEqual(self.js("rhoray.active.layers[0].spec.range"), [0.25, 1])
        self.click("layer-0-range-default")
        self.settle()
        self.assertIsNone(self.js("rhoray.active.layers[0].spec.range"))
        self.check_against_command()

    def test_heat_maps_are_those_of_the_command(self):
        self.volume("--iso", "0.5")
        self.open_section("scene")
        Select(self.find("accuracy")).select_by_value("certified")
        self.settle()
        colors = self.pixels()
        maps = self.js("rhoray.active.hello.words.show")
        self.assertLessEqual({"error", "roots", "cost"}, set(maps))
        for word in (each for each in maps if each != "color"):
            Select(self.find("show")).select_by_value(word)
            self.settle()
            self.assertNotEqual(self.pixels(), colors, word)
            self.assertIn(f"--show {word}", self.command())
            self.check_against_command()
        Select(self.find("show")).select_by_value("color")
        self.settle()
        self.assertEqual(self.pixels(), colors)
        self.check_console()


if __name__ == "__main__":
    unittest.main()

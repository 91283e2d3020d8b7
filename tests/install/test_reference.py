"""Builds the reference of the library's headers with warnings as errors, and looks for gaps."""
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/release"


class Reference(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        done = subprocess.run(["cmake", "--build", BUILD, "--target", "reference"], capture_output=True, text=True,
                              check=False)
        if done.returncode != 0:
            raise AssertionError(done.stdout + done.stderr)
        cls.pages = {path.name: path.read_text(encoding="utf-8") for path in (BUILD / "reference").glob("*.html")}

    def test_every_type_and_function_says_what_it_is(self):
        """Members may speak for themselves. An overload may follow one that is described."""
        with tempfile.TemporaryDirectory(prefix="rhoray-reference-") as folder:
            settings = (BUILD / "tools/library/Doxyfile").read_text()
            settings += f"\nOUTPUT_DIRECTORY = {folder}\nGENERATE_HTML = NO\nGENERATE_XML = YES\n"
            subprocess.run(["doxygen", "-"], input=settings, text=True, check=True)
            described, bare = set(), set()
            for path in pathlib.Path(folder, "xml").glob("*.xml"):
                tree = xml.etree.ElementTree.parse(path)
                for entry in [*tree.iter("compounddef"), *tree.iter("memberdef")]:
                    inside = entry.tag == "memberdef" and not path.name.startswith("namespace")
                    if entry.get("kind") not in ("class", "struct", "enum", "function", "typedef") or inside:
                        continue
                    name = entry.findtext("compoundname") or "rhoray::" + entry.findtext("name")
                    texts = [entry.find("briefdescription"), entry.find("detaileddescription")]
                    (described if "".join("".join(text.itertext()) for text in texts).strip() else bare).add(name)
        self.assertGreater(len(described), 50)
        self.assertEqual(bare - described, set())

    def test_has_a_main_page_with_every_example(self):
        for words in ("rhoray::RayCaster", "Rhoray::rhoray", "find_package", "RayScratch mine"):
            self.assertIn(words, re.sub(r"<[^>]*>", "", self.pages["index.html"]))
        for example in (ROOT / "tools/library/examples").glob("*.cpp"):
            usage = re.search(r'usage: (.*?)"', example.read_text()).group(1)
            self.assertIn(usage, self.pages["index.html"], example)
        # Every type in the table of tasks is a link.
        table = self.pages["index.html"].split("<table", 1)[1].split("</table>")[0]
        self.assertEqual(re.findall(r"rhoray::\w+", re.sub(r"<a [^>]*>.*?</a>", "", table)), [])

    def test_shows_what_callers_write(self):
        for name, page in self.pages.items():
            for inside in ("RHORAY_ABI", "RHORAY_API", "v0_1", "Implementation", "RHORAY_INSIDE"):
                self.assertFalse(inside in page, (name, inside))

    def test_is_the_same_again_and_needs_no_network(self):
        with tempfile.TemporaryDirectory(prefix="rhoray-reference-") as folder:
            before = pathlib.Path(folder, "before")
            shutil.copytree(BUILD / "reference", before)
            self.setUpClass()
            files = {path.relative_to(before): path.read_bytes() for path in before.rglob("*") if path.is_file()}
            again = {path.relative_to(BUILD / "reference"): path.read_bytes()
                     for path in (BUILD / "reference").rglob("*") if path.is_file()}
            self.assertEqual(again.keys(), files.keys())
            for path, content in files.items():
                self.assertEqual(again[path], content, path)
                self.assertNotIn(str(ROOT).encode(), content, path)
        for name, page in self.pages.items():
            requested = re.findall(r'(?:src|<link[^>]*href)="(\w+:)?//', page)
            self.assertEqual(requested, [], name)


if __name__ == "__main__":
    unittest.main()

"""Builds the user's guide with the built program, and checks its pages."""
import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "data/guide/build"
RHORAY = ROOT / "build/release/bin/rhoray"
PAGES = 15
SCRIPTS = sorted(path.stem for path in (ROOT / "data/guide/tutorial").glob("*.py"))
LOADING = {"src", "srcset", "poster", "background"}  # attributes by which a page loads something, in any element


def build(output, *options):
    return subprocess.run([BUILD, output, "--rhoray", RHORAY, *options], cwd=output.parent,
                          capture_output=True, text=True, check=False, timeout=900)


class Read(html.parser.HTMLParser):
    """Links, loaded addresses, ids and images without text of a page."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loaded, self.ids, self.without_text, self.styles_and_scripts = [], [], set(), [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if "id" in given:
            self.ids.add(given["id"])
        self.loaded += [given[name] for name in LOADING if name in given]
        if tag == "link":
            self.loaded.append(given["href"])
        if tag == "a":
            self.links.append(given["href"])
        if tag == "img" and not given.get("alt"):
            self.without_text.append(given["src"])
        if tag in ("script", "style", "iframe", "object", "embed"):
            self.styles_and_scripts.append(tag)


class Guide(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="rhoray-guide-test-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.guide = cls.folder / "guide"
        cls.done = build(cls.guide)
        cls.pages = sorted(cls.guide.glob("*.html"))

    def test_is_built_in_silence(self):
        self.assertEqual((self.done.returncode, self.done.stdout, self.done.stderr), (0, "", ""))

    def test_has_all_pages_and_an_index_that_names_them(self):
        names = [path.name for path in self.pages]
        self.assertEqual(len(names), PAGES + 1)
        links = Read(self.guide / "index.html").links
        self.assertEqual(sorted({*links, "index.html"}), names)

    def test_every_link_and_image_is_inside_the_folder(self):
        for path in self.pages:
            page = Read(path)
            for target in page.links + page.loaded:
                address = urllib.parse.urlsplit(target)
                self.assertEqual((address.scheme, address.netloc), ("", ""), f"{path.name}: {target}")
                file = (self.guide / urllib.parse.unquote(address.path)).resolve() if address.path else path
                self.assertTrue(file.is_relative_to(self.guide.resolve()) and file.is_file(), f"{path.name}: {target}")
                if address.fragment:
                    self.assertIn(address.fragment, Read(file).ids, f"{path.name}: {target}")

    def test_loads_nothing_from_elsewhere(self):
        for path in self.pages:
            self.assertEqual(Read(path).styles_and_scripts, [], path.name)
        style = (self.guide / "style.css").read_text()
        self.assertEqual(re.findall(r"url\(|@import|https?:", style), [])

    def test_each_script_is_there_as_a_page_a_script_and_a_notebook(self):
        self.assertEqual(len(SCRIPTS), 5)
        for name in SCRIPTS:
            page = (self.guide / f"{name}.html").read_text(encoding="utf-8")
            self.assertRegex(page, r'<pre class="output"><code>\S')
            self.assertIn("<figure>", page)
            given = ROOT / f"data/guide/tutorial/{name}.py"
            self.assertEqual((self.guide / f"scripts/{name}.py").read_bytes(), given.read_bytes())
            notebook = json.loads((self.guide / f"scripts/{name}.ipynb").read_text(encoding="utf-8"))
            code = "\n".join(cell["source"] for cell in notebook["cells"] if cell["cell_type"] == "code")
            compile(code, name, "exec")
            self.assertIn("import rhoray as rr", code)
            self.assertNotIn("# %%", code)

    def test_every_image_has_a_text_and_is_shown(self):
        shown = set()
        for path in self.pages:
            page = Read(path)
            self.assertEqual(page.without_text, [], path.name)
            shown |= set(page.loaded)
        self.assertGreater(len(shown), 30)
        self.assertEqual({f"images/{path.name}" for path in (self.guide / "images").iterdir()}, shown - {"style.css"})

    def test_no_page_shows_a_traceback_or_a_folder_of_the_build(self):
        for path in self.pages:
            text = path.read_text(encoding="utf-8")
            for unwanted in ("Traceback", "@@", str(ROOT), "/tmp/", "internal error"):
                self.assertNotIn(unwanted, text, path.name)

    def test_a_second_build_writes_the_same_bytes(self):
        again = self.folder / "again"
        self.assertEqual(build(again).returncode, 0)
        first, second = ({str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*")
                          if path.is_file()} for folder in (self.guide, again))
        self.assertEqual(sorted(first), sorted(second))
        for name, content in first.items():
            self.assertEqual(content, second[name], name)


class Scripts(unittest.TestCase):
    """A guide of one page and one script."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="rhoray-guide-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "tutorial").mkdir()
        (self.folder / "01-page.md").write_text("# Page\n\nA page.\n")

    def build(self, cells, *options):
        (self.folder / "tutorial/02-script.py").write_text(f'"""Script\n\nA script.\n"""\n{cells}\n')
        return build(self.folder / "out", "--pages", self.folder, *options)

    def page(self):
        path = self.folder / "out/02-script.html"
        return path.read_text() if path.exists() else None

    def test_cells_share_names_and_show_their_output(self):
        done = self.build("# %% First\n# *Text*, and\n# more.\n#\n# End.\na = 1 < 2\n\n# %%\nprint('is', a)\n")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for part in ('<h2 id="first">First</h2>\n<p><em>Text</em>, and\nmore.</p>\n<p>End.</p>',
                     '<pre class="cell"><code>a = 1 &lt; 2</code></pre></div>',
                     '<pre class="output"><code>is True</code></pre>'):
            self.assertIn(part, self.page())

    def test_a_cell_that_fails_is_named_with_its_line(self):
        done = self.build("# %% First\na = 1\n\n# %%\n# Text.\nb = 2\nassert a == b, 'differ'")
        self.assertEqual((done.returncode, done.stderr),
                         (1, "build: tutorial/02-script.py:11: AssertionError: differ\n"))

    def test_a_picture_that_is_not_saved(self):
        done = self.build("# %%\nif False:\n    picture.save(\"a.png\")  # a picture")
        self.assertIn("the picture 'a.png' was not drawn", done.stderr)

    def test_is_left_out_where_a_library_is_missing(self):
        done = self.build("# %%\nimport no_such_library")
        self.assertEqual(done.returncode, 0)
        self.assertEqual(done.stderr, "build: note: tutorial/02-script.py is left out: Python has no module "
                                      "no_such_library\n")
        self.assertIsNone(self.page())

    def test_is_left_out_where_the_module_is_not_built(self):
        done = self.build("# %%\nimport rhoray", "--python", self.folder)
        self.assertEqual(done.returncode, 0)
        self.assertEqual(done.stderr, f"build: note: {self.folder}: no Python module rhoray; its pages are left out\n")
        self.assertIsNone(self.page())


class Refusals(unittest.TestCase):
    """Pages with one mistake each, and the line that ends the build."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="rhoray-guide-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def refused(self, text):
        (self.folder / "01-page.md").write_text(f"# Page\n\nA page.\n\n{text}\n")
        output = self.folder / "out"
        done = build(output, "--pages", self.folder)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertFalse(output.exists())
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        return done.stderr

    def test_a_command_that_fails_is_named_with_line_exit_code_and_message(self):
        line = self.refused("```sh\ntrue\nrhoray info nothere.rho\n```")
        self.assertEqual(line, "build: 01-page.md:7: exit code 3, expected 0: rhoray info nothere.rho: "
                               "rhoray info: nothere.rho: no such file\n")

    def test_a_command_that_should_fail_and_does_not(self):
        self.assertIn("01-page.md:6: exit code 0, expected 2: true", self.refused("```sh exit=2\ntrue\n```"))

    def test_only_the_last_command_of_a_block_may_fail(self):
        self.assertIn("01-page.md:6: exit code 1, expected 0", self.refused("```sh exit=1\nfalse\nfalse\n```"))

    def test_a_command_that_fails_before_a_pipe(self):
        self.assertIn("01-page.md:6: exit code 3", self.refused("```sh\nrhoray info nothere.rho 2>&1 | cat\n```"))

    def test_a_picture_that_was_not_drawn(self):
        self.assertIn("01-page.md:5: the picture 'torso.png' was not drawn", self.refused("![A torso](torso.png)"))

    def test_a_picture_without_a_text(self):
        self.assertIn("01-page.md:5: the picture 'torso.png' has no alternative text", self.refused("![](torso.png)"))

    def test_a_link_to_no_page_or_no_heading(self):
        self.assertIn("the link to '99-other.md' leads to no page", self.refused("[other](99-other.md)"))
        self.assertIn("the link to '01-page.md#other' leads to no heading", self.refused("[other](01-page.md#other)"))

    def test_a_block_with_an_unknown_word_or_without_an_end(self):
        self.assertIn("01-page.md:5: unknown word 'exits'", self.refused("```sh exits=2\ntrue\n```"))
        self.assertIn("01-page.md:5: the block that begins here has no end", self.refused("```sh\ntrue"))

    def test_a_folder_that_holds_something_else_is_kept(self):
        output = self.folder / "out"
        output.mkdir()
        (output / "thesis.txt").write_text("kept")
        done = build(output)
        self.assertEqual(done.returncode, 2)
        self.assertIn("is not empty and holds no guide", done.stderr)
        self.assertEqual((output / "thesis.txt").read_text(), "kept")


class Command(unittest.TestCase):
    def test_help_has_an_example(self):
        done = subprocess.run([BUILD, "--help"], capture_output=True, text=True, check=True)
        self.assertIn("data/guide/build guide --rhoray build/release/bin/rhoray", done.stdout)

    def test_needs_the_recipes(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copy("/bin/true", pathlib.Path(folder) / "rhoray")
            done = subprocess.run([BUILD, os.path.join(folder, "out"), "--rhoray", os.path.join(folder, "rhoray")],
                                  capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--recipes", done.stderr)


if __name__ == "__main__":
    unittest.main()

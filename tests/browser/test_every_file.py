"""The settled canvas of every file of the real data against the PNG of the printed command."""
import os
import pathlib
import subprocess
import unittest

from browser import RHORAY, BrowserTest, Viewer

DATA = os.environ.get("RHORAY_SHARED_DATA")


def files():
    """What `rhoray render FILE` draws: files, and folders of slices."""
    names = sorted(pathlib.Path(DATA).rglob("*"))
    return [path for path in names if path.suffix not in (".md", ".txt", ".jpg", ".png") and
            subprocess.run([str(RHORAY), "info", str(path), "--json"], capture_output=True, check=False).returncode == 0]


@unittest.skipUnless(DATA, "RHORAY_SHARED_DATA names no folder")
class EveryFile(BrowserTest):
    def test_settled_canvas_is_the_picture_of_the_command(self):
        paths = files()
        self.assertTrue(paths, f"{DATA}: no file that `rhoray info` reads")
        for path in paths:
            with self.subTest(str(path)):
                try:
                    viewer = Viewer(path, folder=self.folder)
                except AssertionError:  # what `render` refuses, too
                    drawn = subprocess.run([str(RHORAY), "render", str(path), "--no-cache", "-o", "refused.png"],
                                           cwd=self.folder, capture_output=True, check=False)
                    self.assertNotEqual(drawn.returncode, 0)
                    continue
                self.addCleanup(lambda process=viewer.process: process.poll() is None and process.kill())
                self.open(viewer)
                self.check_against_command()
                viewer.stop()


if __name__ == "__main__":
    unittest.main()

"""The settled canvas of every file of the real data against the PNG of the printed command."""
import os
import pathlib
import subprocess
import unittest

from browser import RHORAY, BrowserTest

DATA = os.environ.get("RHORAY_SHARED_DATA")


def files():
    """What `rhoray render FILE` draws."""
    names = (path for path in sorted(pathlib.Path(DATA).rglob("*")) if path.is_file())
    return [path for path in names if path.suffix not in (".md", ".txt", ".jpg", ".png") and
            subprocess.run([str(RHORAY), "info", str(path), "--json"], capture_output=True, check=False).returncode == 0]


@unittest.skipUnless(DATA, "RHORAY_SHARED_DATA names no folder")
class EveryFile(BrowserTest):
    def test_settled_canvas_is_the_picture_of_the_command(self):
        for path in files():
            with self.subTest(str(path)):
                viewer = self.view(path)
                self.check_against_command()
                viewer.stop()


if __name__ == "__main__":
    unittest.main()

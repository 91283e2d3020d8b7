"""axe-core finds nothing wrong with the page."""
import os
import pathlib
import unittest

from browser import BrowserTest, write_mesh, write_volume

AXE = os.environ.get("AXE")


@unittest.skipUnless(AXE, "AXE names no file")
class Accessibility(BrowserTest):
    def test_axe_finds_no_violation(self):
        write_volume(self.folder / "ball.npy")
        write_mesh(self.folder / "box.vtk")
        for words in (["ball.npy"], ["box.vtk", "--iso", "0.5"]):
            self.view(*words)
            for scheme in ("light", "dark"):
                self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                                            {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
                for state in ("", "document.querySelectorAll('aside details').forEach((each) => { each.open = true; })",
                              "document.getElementById('clip-box')?.click()", "document.getElementById('compare').click()",
                              "document.getElementById('help').showModal()"):
                    if state:
                        self.driver.execute_script(state)
                        self.wait("rhoray.views.every((view) => view.drawn)")
                    with self.subTest(f"{words} {scheme} {state}"):
                        # The protocol's evaluation is not bound by the page's content security
                        # policy.
                        self.driver.execute_cdp_cmd("Runtime.evaluate",
                                                    {"expression": pathlib.Path(AXE).read_text(encoding="utf-8")})
                        found = self.driver.execute_async_script(
                            "const done = arguments[0]; axe.run(document).then((result) => done(result.violations.map("
                            "(one) => one.id + ': ' + one.nodes.map((node) => node.target.join(' ')).join(', '))))")
                        self.assertEqual(found, [])
                self.driver.refresh()
                self.settle()


if __name__ == "__main__":
    unittest.main()

"""Screenshots of a minute of use of the viewer, on one sheet: data/gallery/viewer/one_minute.jpg.

    RHORAY_SHARED_DATA=FOLDER contact_sheet.py [SHEET]
"""
import base64
import os
import pathlib
import sys
import tempfile

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.support.ui import Select

from browser import ROOT
from page import PageTest

DATA = pathlib.Path(os.environ.get("RHORAY_SHARED_DATA", ""))
ACROSS, GAP = 3, 8


class Minute(PageTest):
    shots = []

    def runTest(self):
        """Is called by main."""

    def shot(self):
        self.settle()
        if self.js("!!rhoray.active.finished"):
            self.wait("rhoray.active.check")  # so that the panel of costs is whole
        self.shots.append(self.driver.get_screenshot_as_base64())
        self.check_console()

    def show_end_of_panels(self):
        self.driver.execute_script("document.querySelector('aside').scrollTo(0, 1e6)")

    def press(self, *elements):
        for element in elements:
            self.click(element)
            self.settle()

    def ct(self):
        self.view(DATA / "volumes/vhf_ct_head/vhf_ct_head.nhdr")
        self.shot()
        self.set_number("layer-0-isovalue", 110)
        self.drag(self.canvas(), (0, 0), [(8, 2)] * 20)
        self.shot()
        self.open_section("clipping")
        self.press("clip-add", "clip-0-slice")
        self.show_end_of_panels()
        for offset in ((-60, 30), (20, -60)):
            ActionChains(self.driver).move_to_element_with_offset(self.canvas(), *offset).pause(0.3).click().perform()
            self.wait(f"rhoray.pins.length === {1 if offset[0] < 0 else 2}")
        self.shot()

    def torso(self):
        self.view(DATA / "unstructured/utahtorso/utahtorso-lowres.vtu")
        self.shot()
        self.press("add-isosurface")
        self.click("compare")
        self.wait("rhoray.views.length === 2")
        self.settle()
        self.set_number("layer-1-isovalue", 60)
        Select(self.find("layout")).select_by_value("wipe")
        self.shot()

    def pet(self):
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                                    {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        self.view(DATA / "volumes/pet_dicom_299slices.zip", "--mode", "mip")
        self.open_section("cost")
        self.show_end_of_panels()
        self.shot()

    def sheet(self):
        """The screenshots in rows, as a JPEG."""
        return base64.b64decode(self.driver.execute_async_script("""
            const [shots, across, gap, done] = arguments;
            Promise.all(shots.map((shot) => {
              const bytes = Uint8Array.from(atob(shot), (letter) => letter.charCodeAt(0));
              return createImageBitmap(new Blob([bytes], {type: "image/png"}));
            })).then((bitmaps) => {
              const [width, height] = [bitmaps[0].width, bitmaps[0].height], down = Math.ceil(bitmaps.length / across);
              const canvas = document.createElement("canvas");
              canvas.width = across * (width + gap) - gap;
              canvas.height = down * (height + gap) - gap;
              const pen = canvas.getContext("2d");
              pen.fillStyle = "white";
              pen.fillRect(0, 0, canvas.width, canvas.height);
              bitmaps.forEach((each, i) =>
                pen.drawImage(each, i % across * (width + gap), Math.floor(i / across) * (height + gap)));
              done(canvas.toDataURL("image/jpeg", 0.8).split(",")[1]);
            });""", self.shots, ACROSS, GAP))


def main(words):
    Minute.setUpClass()
    with tempfile.TemporaryDirectory() as folder:
        page = Minute()
        page.folder = pathlib.Path(folder)
        for use in (page.ct, page.torso, page.pet):
            use()
        sheet = pathlib.Path(words[0]) if words else ROOT / "data/gallery/viewer/one_minute.jpg"
        sheet.parent.mkdir(exist_ok=True)
        sheet.write_bytes(page.sheet())
        page.doCleanups()
    Minute.doClassCleanups()


if __name__ == "__main__":
    main(sys.argv[1:])

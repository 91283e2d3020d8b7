"""A CT as an array: skin and bone, a projection, and the picture again from its own scene."""
import sys

import numpy
import rhoray as rr


def head() -> rr.Data:
    """A made-up head, in Hounsfield units: tissue in a skull in skin, samples of 0.9 x 0.9 x 1.5 mm."""
    k, j, i = numpy.mgrid[0:110, 0:180, 0:180]
    x, y, z = 0.9 * i - 81, 0.9 * j - 81, 1.5 * k - 82
    radius = numpy.sqrt((x / 62) ** 2 + (y / 75) ** 2 + (z / 72) ** 2)
    eyes = sum(numpy.exp(-((x - side) ** 2 + (y + 58) ** 2 + (z - 5) ** 2) / 160) for side in (-25, 25))
    skull = 1400 * numpy.exp(-((radius - 0.88) / 0.035) ** 2) * (1 - 0.95 * numpy.clip(eyes, 0, 1))
    tissue = 1040 / (1 + numpy.exp((radius - 1) * 60)) - 1000
    return rr.volume((skull + tissue).astype(numpy.int16), spacing=(0.9, 0.9, 1.5), origin=(-81, -81, -82),
                     length_unit="mm", units={"values": "HU"})


def main(folder: str = ".") -> None:
    data = head()
    picture = rr.render(data, iso=[-300, 600], size=(640, 640))
    picture.save(f"{folder}/head.png", replace=True)
    rr.render(data, mode="mip", range=(0, 2500), size=(640, 640)).save(f"{folder}/head_mip.png", replace=True)
    again = rr.render(picture.scene, data={"data": data})
    print("the scene makes the same picture:", numpy.array_equal(picture.color, again.color))


if __name__ == "__main__":
    main(*sys.argv[1:])

"""Python: a CT

An array becomes pictures of a head, a view into it, and lengths with a proven error.

This page and the next four are scripts. They run in a terminal; editors such as VS Code and Spyder
also run them cell by cell. The module `rhoray` is in the Debian package `python3-rhoray`.
"""
# %% A scan as an array
# The scan is made here, in Hounsfield units (HU): air is -1000, soft tissue 40, bone 1140. All
# parts of the head are ellipsoids that blend. The array is `hounsfield[k, j, i]`, so x is its last
# axis, as in arrays of tifffile, scikit-image and SimpleITK.
#
# For a scan of your own, `data = rr.open("scan.nrrd")` takes the place of this cell. `rr.open`
# reads all types that `rhoray formats` lists, also a folder of DICOM files.
import numpy
import rhoray as rr

spacing = (1.25, 1.25, 1.5)  # mm along x, y and z: to the left, to the back and to the top
x, y, z = (numpy.arange(-105, 105, step, dtype=numpy.float32) for step in spacing)


def ellipsoid(centre, radii):
    """About the distance in mm, negative inside. It is mirrored to the other side of the head."""
    at = [((axis - c) / r) ** 2 for axis, c, r in zip((abs(x), y, z), centre, radii)]
    return min(radii) * (numpy.sqrt(at[0] + at[1][:, None] + at[2][:, None, None]) - 1)


def blend(*parts, width=5):
    return -width * numpy.logaddexp.reduce([-part / width for part in parts])


cranium = ellipsoid((0, 8, 24), (70, 90, 70))
face, chin = ellipsoid((0, -34, -32), (54, 56, 66)), ellipsoid((0, -68, -80), (24, 20, 13))
nose, lips = ellipsoid((0, -88, -24), (8, 16, 15)), ellipsoid((0, -82, -54), (16, 8, 6))
ears, neck = ellipsoid((73, 14, -4), (5, 13, 20)), ellipsoid((0, 24, -160), (58, 56, 150))
skin = blend(cranium, face, chin, nose, lips, ears, neck)

cheeks, brows = ellipsoid((30, -60, -30), (15, 14, 7)), ellipsoid((0, -66, 10), (38, 10, 6))
sockets, nostrils = ellipsoid((25, -86, -6), (17, 34, 14)), ellipsoid((0, -86, -28), (10, 34, 14))
temples, throat = ellipsoid((60, -26, -40), (16, 26, 18)), ellipsoid((0, 12, -88), (36, 72, 56))
skull = blend(cranium + 8, face + 9, chin + 5, cheeks, brows)
hollow = blend(cranium + 15, sockets, nostrils, temples, throat, width=2)
spine = ellipsoid((0, 30, -110), (13, 14, 72))
bone = blend(-blend(-skull, hollow, width=2), spine, width=2)

hounsfield = 520 * (1 - numpy.tanh(skin / 2)) + 550 * (1 - numpy.tanh(bone / 2)) - 1000
data = rr.volume({"CT": hounsfield.astype(numpy.int16)}, spacing=spacing,
                 origin=(x[0], y[0], z[0]), units={"CT": "HU"}, length_unit="mm")
print(data)

# %% Skin and skull
# Two isosurfaces: the skin, halfway between air and tissue, and the bone. The outer one is
# transparent. A notebook shows a picture if the last line of a cell is its name.
picture = rr.render(data, iso=[-480, 600], color="#f4ead6", azimuth=30, elevation=8,
                    size=(480, 480))
picture.save("head.png", replace=True)  # a head with transparent skin over its skull
picture

# %% A head that is cut open
# `picture.scene` holds every choice that `render` made, as a [scene document](06-scenes.md) in a
# dict. It can be changed, and drawn again. Here a quarter of the skin is clipped away, and two
# slices close the cut.
scene = picture.scene
skin_layer, skull_layer = scene["layers"]
skin_layer.update(color="#e0a684", opacity=1)
skull_layer.update(clip=False)
gray = {"type": "slice", "data": "data", "colormap": "gray", "range": [-200, 300],
        "threshold": [-480, 2000]}
scene["layers"] += [{**gray, "axis": "x", "position": 0}, {**gray, "axis": "z", "position": 20}]
scene["clip"] = {"box": [[0, -200, 20], [200, 200, 200]], "keep": "outside"}
opened = rr.render(scene, data={"data": data})
opened.save("head_open.png", replace=True)  # a head without a quarter of its skin
opened

# %% Lengths
# Two rays meet the skin: one falls on the top of the head, one comes from behind. `certified`
# proves how far each distance along its ray may be off.
hits = rr.trace(data, [[0, 8, 200], [0, 200, 24]], [[0, 0, -1], [0, -1, 0]], iso=-480,
                accuracy="certified")
top, back = 200 - hits.t
bound = numpy.max(hits.error)
print(f"the skin is at z = {top:.4f} mm and y = {back:.4f} mm, proven to {bound:.0e} mm")

# %% What this script claims
# The ellipsoid of the cranium ends at 94 and 98 mm. The rest is the error of sampling, a hundredth
# of the spacing: the bound is that of the isosurface between the samples.
assert abs(top - 94) < 0.02 and abs(back - 98) < 0.02 and bound < 1e-4
assert numpy.array_equal(rr.render(picture.scene, data={"data": data}).rgba, picture.rgba)

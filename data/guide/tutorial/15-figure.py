"""Python: the accuracy of a figure

How far a surface in a figure may be off, which method to take, and what to write in a paper.
"""
# %% A figure
# The signal of Marschner and Lobb (1994) is a test for volume renderers: its rings are nearly as
# narrow as the samples. `certified` proves every hit and every miss. The channel `error` holds the
# bound of each pixel's depth.
import importlib.util

import numpy
import rhoray as rr


def signal(count):
    axis = numpy.linspace(-1, 1, count)
    z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij", sparse=True)
    rings = numpy.cos(12 * numpy.pi * numpy.cos(numpy.pi / 2 * numpy.hypot(x, y)))
    values = (1 - numpy.sin(numpy.pi / 2 * z) + 0.25 * (1 + rings)) / 2.5
    return rr.volume({"signal": values}, spacing=[2 / (count - 1)] * 3, origin=(-1, -1, -1))


data, spacing = signal(61), 2 / 60
figure = rr.render(data, iso=0.5, accuracy="certified", elevation=50, size=(480, 400),
                   channels=["depth", "error"])
figure.save("signal.png", replace=True)  # rings of waves on a square, ragged towards its corners
figure

# %% The bound
# Depth and bound are lengths in the unit of the data. `verify` compares the picture with exact
# arithmetic at 300 random pixels, and at 300 pixels on edges.
depth, bounds = numpy.asarray(figure.depth), numpy.asarray(figure.error)
is_shown = numpy.isfinite(depth)
bound = bounds[is_shown].max() / spacing
check = figure.verify(300)
print(f"depths are proven to {bound:.1e} of the spacing")
print(f"promise: {check['promise']}; broken: {check['broken'] or 'no'}")

# %% What the bound does not cover
# The bound is that of the surface between these samples. Three times as many samples on each axis
# give another surface. This is an error of the samples, not of the figure; no renderer knows it.
finer = rr.render(signal(181), iso=0.5, accuracy="certified", camera=figure.scene["camera"],
                  size=(480, 400), channels=["depth"])
finer.save("signal_finer.png", replace=True)  # the same rings, smooth everywhere
finer_depth = numpy.asarray(finer.depth)
both = is_shown & numpy.isfinite(finer_depth)
moved = numpy.median(abs(depth[both] - finer_depth[both])) / spacing
print(f"more samples move half of the surface by more than {moved:.1e} of the spacing")
finer

# %% All methods
# `accuracy` draws a small picture with each method, and compares it with exact arithmetic. The
# columns of its table are arrays: errors in cells, and CPU times in ms. `time_limit` and `repeat`
# keep this example short; leave them out for a paper.
table = rr.accuracy(data, iso=0.5, size=(100, 100), time_limit=10, repeat=1)
columns = table.columns
for row in numpy.flatnonzero(columns["group"] == "level"):
    print("{}: {:.0f} false pixels, 99 % of the others within {:.1g} cells, {:.1f} ms".format(
        columns["variant"][row], columns["missed"][row] + columns["false_hits"][row],
        columns["depth_p99_cells"][row], columns["cpu_ms"][row]))

# %% Error against time
# This cell needs matplotlib. An error of 0 is drawn at 1e-16. The guide does not show the plot:
# times differ in each run.
if importlib.util.find_spec("matplotlib"):
    from matplotlib.figure import Figure

    axes = Figure(figsize=(6, 4), layout="constrained").add_subplot(
        xscale="log", yscale="log", xlabel="CPU time, ms", ylabel="median error of depth, cells")
    for group in ("level", "published methods", "sampled, linear", "sampled, bisection"):
        rows = numpy.flatnonzero(columns["group"] == group)
        errors = numpy.maximum(columns["depth_median_cells"][rows], 1e-16)
        axes.plot(columns["cpu_ms"][rows], errors, "o", label=group)
    axes.legend()
    axes.figure.savefig("signal_accuracy.png")

# %% What this script claims, and a sentence for the paper
certified = numpy.flatnonzero(columns["variant"] == "certified")[0]
assert columns["missed"][certified] == columns["false_hits"][certified] == 0
assert check["broken"] == "" and bound < 0.01 < moved
rounded_up = numpy.ceil(1e4 * bound) / 1e4
print(f"The isosurface was ray traced by Rhoray {rr.version} (accuracy certified): every hit and\n"
      f"every miss is proven, and depths are within {rounded_up:g} of the sample distance.")

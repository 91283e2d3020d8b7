"""Python: a million certified rays

Each ray gets its first hit and a proven bound of its error. A closed formula tests all of them.
"""
# %% A field with a closed formula
# The field x y z is trilinear: interpolation between its samples gives x y z again. Its isosurface
# at 1000 meets a ray from (0, 0, 0) in the direction (a, b, c) at t = 10 / cbrt(a b c), if that is
# inside the data.
import time

import numpy
import rhoray as rr

axis = numpy.arange(64.0)
data = rr.volume({"xyz": axis[:, None, None] * axis[:, None] * axis})
picture = rr.render(data, iso=1000, azimuth=135, accuracy="certified", size=(360, 360))
picture.save("xyz.png", replace=True)  # a surface that follows three faces of a cube
picture

# %% A million rays
# Origins and directions are arrays with a row for each ray. `certified` proves which rays hit, and
# how far each t may be off. For a ray that misses, t is infinite.
count = 1_000_000
directions = numpy.random.default_rng(1).uniform(0, 1, (count, 3))
directions /= numpy.linalg.norm(directions, axis=1, keepdims=True)  # so that t is a distance
begun = time.perf_counter()
hits = rr.trace(data, numpy.zeros((count, 3)), directions, iso=1000, accuracy="certified")
took_ms = 1000 * (time.perf_counter() - begun)
print(f"{hits.is_hit.sum():,} of {count:,} rays hit; traced in {took_ms:.0f} ms")

# %% The formula
# A bound holds in the worst case, so most errors are much smaller than their bounds.
formula = 10 / numpy.cbrt(directions.prod(axis=1))
farthest = (formula[:, None] * directions).max(axis=1)  # largest coordinate on the isosurface
error = abs(hits.t - formula)[hits.is_hit]
bound = numpy.asarray(hits.error)[hits.is_hit]
for name, values in (("errors", error), ("bounds", bound)):
    print(f"{name}: median {numpy.median(values):.1e}, largest {values.max():.1e} cells")

# %% What this script claims
# Every hit and every miss is that of the formula, and no error is above its bound. The formula is
# rounded, too: it could not judge a ray that leaves the data within 1e-9 cells of the isosurface.
# No ray does.
assert numpy.array_equal(hits.is_hit, farthest <= axis[-1])
assert (error <= bound).all()
assert abs(farthest - axis[-1]).min() > 1e-9

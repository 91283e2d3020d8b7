"""Ray tracing of packed volumes and tetrahedra.

    import rhoray as rr
    v = rr.open("torso.rho")                 # or rr.volume(array), rr.mesh(points, tets, ...)
    p = rr.render(v, iso=0.25, size=(1024, 768), channels=["depth"])
    p.rgba, p.depth                          # numpy views of the picture
    h = rr.trace(v, origins, directions, iso=0.25, accuracy="certified")
    values, cells = rr.sample(v, points)

open, pack, info, resample, tetrahedralize, validate, accuracy and view start the program `rhoray` where
they need it, and take its options as keyword arguments.

Lengths are in the data's unit and in world axes, x, y, z. Arrays of volumes are values[k, j, i]
(`axes="zyx"`, numpy's C order) unless `axes="xyz"` is said. NaN means that there is no data.
Every error is a `rhoray.Error`; its text says what was found and what was expected.
"""
from rhoray import _core
from rhoray._accuracy import Accuracy, accuracy
from rhoray._commands import info, resample, tetrahedralize, validate
from rhoray._data import Data, Field, mesh, open, pack, surface, volume  # noqa: A004  (the command's name)
from rhoray._errors import Error, FileError, ResourceError, UsageError
from rhoray._pictures import Picture, render
from rhoray._rays import AllHits, Hits, sample, trace
from rhoray._view import View, view

__all__ = ["Accuracy", "AllHits", "Data", "Error", "Field", "FileError", "Hits", "Picture", "ResourceError",
           "UsageError", "View", "accuracy", "info", "mesh", "open", "pack", "render", "resample", "sample", "surface",
           "tetrahedralize", "trace", "validate", "version", "view", "volume"]

version = _core.version

for _public in (Accuracy, AllHits, Data, Error, Field, FileError, Hits, Picture, ResourceError, UsageError, View):
    _public.__module__ = "rhoray"  # the name that tracebacks and pickles say
del _public

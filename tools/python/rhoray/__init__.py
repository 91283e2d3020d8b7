"""Ray tracing of packed volumes and tetrahedra.

    import rhoray as rr
    v = rr.open("torso.rho")                 # or rr.volume(array), rr.mesh(points, tets, ...)
    p = rr.render(v, iso=0.25, size=(1024, 768), channels=["depth"])
    p.rgba, p.depth                          # numpy views of the picture
    h = rr.trace(v, origins, directions, iso=0.25, accuracy="certified")
    values, cells = rr.sample(v, points)

Lengths are in the data's unit and in world axes, x, y, z. Arrays of volumes are values[k, j, i]
(`axes="zyx"`, numpy's C order) unless `axes="xyz"` is said. NaN means that there is no data.
Every error is a `rhoray.Error`; its text says what was found and what was expected.
"""
from rhoray import _core
from rhoray._data import Data, Field, mesh, open, pack, surface, volume  # noqa: A004  (the command's name)
from rhoray._errors import Error, FileError, ResourceError, UsageError
from rhoray._pictures import Picture, render
from rhoray._rays import AllHits, Hits, sample, trace

__all__ = ["AllHits", "Data", "Error", "Field", "FileError", "Hits", "Picture", "ResourceError", "UsageError", "mesh",
           "open", "pack", "render", "sample", "surface", "trace", "version", "volume"]

version = _core.version

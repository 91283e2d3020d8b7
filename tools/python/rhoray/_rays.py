"""Rays and points in data."""
import dataclasses

import numpy

from rhoray import _core
from rhoray._contexts import Context
from rhoray._errors import UsageError


def _floats(values):
    """An array of floats. Other numbers are converted, unless that would copy more than 64 MiB."""
    array = numpy.asarray(values)
    return array if array.dtype.kind == "f" or array.nbytes > 64 << 20 else array.astype(float)


@dataclasses.dataclass(frozen=True)
class Hits:
    """One row per ray. t is infinity, value NaN and cell 2**64 - 1 for a miss.

    error is None unless the accuracy is certified or exact; gradient is None for largest values.
    """
    t: numpy.ndarray
    value: numpy.ndarray
    cell: numpy.ndarray
    error: numpy.ndarray | None
    gradient: numpy.ndarray | None

    @property
    def is_hit(self):
        return numpy.isfinite(self.t)


@dataclasses.dataclass(frozen=True)
class AllHits:
    """All crossings: ray r has the rows first[r] to first[r + 1] - 1 of t, error, cell and enters."""
    first: numpy.ndarray
    t: numpy.ndarray
    error: numpy.ndarray
    cell: numpy.ndarray
    enters: numpy.ndarray
    truncated: numpy.ndarray


def trace(data, origins, directions, *, iso=None, query="first", accuracy="double", field=None, t_min=None, t_max=None,
          max_hits=4096):
    """Traces rays origin + t * direction, arrays of the shape [rays, 3], world axes.

    query: "first" (Hits), "any" (an array of bool), "all" (AllHits, always exact), "largest" (Hits).
    iso: the isovalue of a grid or a mesh; surfaces have none.

    Two rays along x. One meets the sphere of radius 1 around (2, 2, 2), one misses it:

    >>> import numpy, rhoray as rr
    >>> k, j, i = numpy.mgrid[0:5, 0:5, 0:5]
    >>> data = rr.volume(numpy.sqrt((i - 2.) ** 2 + (j - 2.) ** 2 + (k - 2.) ** 2))
    >>> hits = rr.trace(data, [[0, 2, 2], [0, 4, 4]], [[1, 0, 0], [1, 0, 0]], iso=1, accuracy="certified")
    >>> hits.t
    array([ 1., inf])
    >>> hits.is_hit
    array([ True, False])
    """
    origins, directions = _floats(origins), _floats(directions)
    limits = [None if limit is None else _floats(limit) for limit in (t_min, t_max)]
    name = field or data._name
    if query == "largest":
        if iso is not None:
            raise UsageError("trace: iso has no effect on the query 'largest'")
        with Context() as context:
            return Hits(**_core.FieldSampler(data._core, name, accuracy).largest_values(context, accuracy, origins,
                                                                                        directions, *limits))
    if query not in ("first", "any", "all"):
        raise UsageError(f"trace: query {query!r}; expected 'first', 'any', 'all' or 'largest'")
    if iso is None and data.kind != "triangles":
        raise UsageError("trace: no isovalue; expected iso=...")
    caster = _core.RayCaster(data._core, None if iso is None else float(iso), accuracy, name)
    with Context() as context:
        if query == "first":
            return Hits(**caster.first_hits(context, accuracy, origins, directions, *limits))
        if query == "any":
            return caster.any_hits(context, origins, directions, *limits).view(bool)
        found = caster.all_hits(context, origins, directions, *limits, max_hits)
        return AllHits(**{**found, "enters": found["enters"].view(bool), "truncated": found["truncated"].view(bool)})


def sample(data, points, *, field=None):
    """Evaluates a field at points [n, 3], world axes. Returns (values, cells); NaN: no data there.

    cells: ids of the cells, 2**64 - 1 for none. Those of a mesh count the cells that were packed; the packed
    file holds them in another order, and its array "cell_ids" tells which.

    >>> import numpy, rhoray as rr
    >>> values, cells = rr.sample(rr.volume(numpy.arange(27.).reshape(3, 3, 3)), [[0.5, 0, 0], [0, 0, 3]])
    >>> values
    array([0.5, nan])
    """
    return _core.FieldSampler(data._core, field or data._name, "double").sample(_floats(points))

"""Rays and points in data."""
import dataclasses

import numpy

from rhoray import _core
from rhoray._arrays import floats_of
from rhoray._contexts import Context
from rhoray._errors import UsageError


@dataclasses.dataclass(frozen=True, eq=False)
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


@dataclasses.dataclass(frozen=True, eq=False)
class AllHits:
    """All crossings: ray r has the rows first[r] to first[r + 1] - 1 of t, error, cell and enters."""
    first: numpy.ndarray
    t: numpy.ndarray
    error: numpy.ndarray
    cell: numpy.ndarray
    enters: numpy.ndarray
    truncated: numpy.ndarray


def _require_room(name, array, dtype, shape, used):
    """Refuses an array of the caller that answers cannot be written into. Adds it to `used`.

    used: arrays by name with which it may not share memory; None: not given.
    """
    if not isinstance(array, numpy.ndarray) or hasattr(array, "mask"):
        raise TypeError(f"{name}: found {'None' if array is None else type(array).__name__}; expected a numpy.ndarray")
    if array.dtype != dtype:
        raise TypeError(f"{name}: elements of the type {array.dtype}; expected {numpy.dtype(dtype)}")
    if array.shape != shape:
        raise UsageError(f"{name}: an array of the shape {array.shape}; expected {shape}")
    if not array.flags.writeable:
        raise UsageError(f"{name}: a read-only array; expected one that can be written")
    if not array.flags.carray:
        raise UsageError(f"{name}: an array that is not contiguous in C order, or not aligned; expected one such as "
                         "numpy.empty makes")
    for other, memory in used.items():
        if memory is not None and numpy.may_share_memory(array, memory):
            raise UsageError(f"{name}: shares memory with {other}; expected memory of its own")
    used[name] = array


def _hits(out, rows, names, used):
    """Returns Hits with room for the named answers: new ones, or `out`, which must fit."""
    kinds = {name: (numpy.uint64 if name == "cell" else numpy.float64, (*rows, 3) if name == "gradient" else rows)
             for name in names}
    if out is None:
        return Hits(**{"error": None, "gradient": None,
                       **{name: numpy.empty(shape, dtype) for name, (dtype, shape) in kinds.items()}})
    if not isinstance(out, Hits):
        raise TypeError(f"out: found {type(out).__name__}; expected Hits")
    for name, array in vars(out).items():
        if name in kinds:
            _require_room(f"out.{name}", array, *kinds[name], used)
        elif array is not None:
            raise UsageError(f"out.{name}: found an array; expected None, because this call has no {name}")
    return out


def trace(data, origins, directions, *, iso=None, query="first", accuracy="double", field=None, t_min=None, t_max=None,
          max_hits=4096, out=None):
    """Traces rays origin + t * direction, arrays of the shape [rays, 3], world axes.

    query: "first" (Hits), "any" (an array of bool), "all" (AllHits, always exact), "largest" (Hits).
    iso: the isovalue of a grid or a mesh; surfaces have none.
    t_min, t_max: arrays of the shape [rays], in lengths of the direction; None: 0 and infinity.
    max_hits: of a ray, for "all".
    out: Hits for as many rays, of an earlier call with the same query and an accuracy that also proves errors, or
    also proves none; or with arrays of your own. The answers overwrite it, and it is returned: this saves the time
    that new memory takes. After an interrupt it holds old and new answers. The arrays are contiguous and share no
    memory with each other or with the rays. "any" and "all" have no such argument.

    Two rays along x. One meets the sphere of radius 1 around (2, 2, 2), one misses it:

    >>> import numpy, rhoray as rr
    >>> k, j, i = numpy.mgrid[0:5, 0:5, 0:5]
    >>> data = rr.volume(numpy.sqrt((i - 2.) ** 2 + (j - 2.) ** 2 + (k - 2.) ** 2))
    >>> hits = rr.trace(data, [[0, 2, 2], [0, 4, 4]], [[1, 0, 0], [1, 0, 0]], iso=1, accuracy="certified")
    >>> hits.t
    array([ 1., inf])
    >>> hits.is_hit
    array([ True, False])

    Other rays, into the same memory:

    >>> rr.trace(data, [[0, 2, 2], [2, 4, 2]], [[2, 0, 0], [0, -1, 0]], iso=1, accuracy="certified", out=hits) is hits
    True
    >>> hits.t
    array([0.5, 1. ])
    """
    origins, directions = floats_of(origins), floats_of(directions)
    limits = [None if limit is None else floats_of(limit) for limit in (t_min, t_max)]
    arrays = (origins, directions, *limits)
    rows = origins.shape[:1]
    used = dict(zip(("origins", "directions", "t_min", "t_max"), arrays, strict=True))
    names = ["t", "value", "cell", *(["error"] if accuracy in ("certified", "exact") else [])]
    name = field or data._name
    if query == "largest":
        if iso is not None:
            raise UsageError("trace: iso has no effect on the query 'largest'")
        sampler = _core.FieldSampler(data._core, name, accuracy)
        hits = _hits(out, rows, names, used)
        with Context() as context:
            sampler.largest_values(context, *arrays, hits)
        return hits
    if query not in ("first", "any", "all"):
        raise UsageError(f"trace: query {query!r}; expected 'first', 'any', 'all' or 'largest'")
    if iso is None and data.kind != "triangles":
        raise UsageError("trace: no isovalue; expected iso=...")
    if out is not None and query != "first":
        raise UsageError(f"trace: out has no effect on the query {query!r}")
    caster = _core.RayCaster(data._core, None if iso is None else float(iso), accuracy, name)
    if query == "first":
        hits = _hits(out, rows, [*names, "gradient"], used)
        with Context() as context:
            caster.first_hits(context, *arrays, hits)
        return hits
    with Context() as context:
        if query == "any":
            is_hit = numpy.empty(rows, bool)
            caster.any_hits(context, *arrays, is_hit)
            return is_hit
        found = caster.all_hits(context, *arrays, max_hits)
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
    points = floats_of(points)
    values, cells = numpy.empty(points.shape[:1]), numpy.empty(points.shape[:1], numpy.uint64)
    _core.FieldSampler(data._core, field or data._name, "double").sample(points, values, cells)
    return values, cells

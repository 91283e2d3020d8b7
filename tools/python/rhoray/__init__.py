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
import builtins
import dataclasses
import json
import os
import threading

import numpy

__all__ = ["Data", "Error", "Field", "Hits", "AllHits", "Picture", "mesh", "open", "pack", "render", "sample",
           "surface", "trace", "volume", "version"]


class Error(Exception):
    """What every function raises. `code` is the exit code of the program; `hint` says what to do."""

    def __init__(self, fact, code=2, hint=""):
        super().__init__(fact + (f"\nhint: {hint}" if hint else ""))
        self.fact = fact
        self.code = code
        self.hint = hint


class UsageError(Error, ValueError):
    """The call makes no sense: a wrong shape, an unknown field, a number out of range."""


class FileError(Error, OSError):
    """A file is missing, cannot be read, or is damaged."""


class ResourceError(Error, MemoryError):
    """There is no memory, disk space or thread left."""


def _error(code, fact, hint):
    classes = {2: UsageError, 3: FileError, 4: FileError, 5: ResourceError, 7: UsageError}
    return classes.get(code, Error)(fact, code, hint)


from rhoray import _core, _objects  # noqa: E402  (it raises the exceptions above)

version = _core.version
_open_file = builtins.open
_process = os.getpid()
_contexts = []
_contexts_guard = threading.Lock()


class _Context:
    """Threads to render with: one set for each call that runs at the same time."""

    def __enter__(self):
        if os.getpid() != _process:
            raise UsageError("rhoray was imported before this process was forked: its threads are gone",
                             hint="start processes by multiprocessing.get_context('spawn')")
        with _contexts_guard:
            self.context = _contexts.pop() if _contexts else _core.RenderContext(0)
        return self.context

    def __exit__(self, kind, error, trace):
        if kind is None:  # after an error, another one is made
            with _contexts_guard:
                _contexts.append(self.context)


@dataclasses.dataclass(frozen=True)
class Field:
    """A scalar field. `range` is None where no value is finite."""
    name: str
    unit: str
    of_cells: bool
    range: tuple | None
    no_data_count: int
    histogram: numpy.ndarray
    labels: dict


class Data:
    """A packed file, mapped or in memory, with all its fields. It cannot be changed.

    Its arrays stay valid while any of them, or a picture of it, is in use.
    """

    def __init__(self, core, field=None):
        self._core = core
        self._name = core.field_name(field or "") if core.kind != "triangles" else ""

    @property
    def kind(self):
        """"grid", "tetrahedra" or "triangles"."""
        return self._core.kind

    @property
    def fields(self):
        """All fields, by name."""
        return {facts["name"]: Field(**facts) for facts in self._core.fields()}

    @property
    def field(self):
        """The field that is shown: the one that was named, or the first that is not constant."""
        return self.fields.get(self._name)

    @property
    def bounds(self):
        """(lowest, highest) corner, world axes."""
        return self._core.bounds

    @property
    def length_unit(self):
        return self._core.length_unit

    @property
    def notes(self):
        """Changes made while packing or loading, one sentence each."""
        return self._core.notes

    def with_field(self, name):
        """The same data, showing another field."""
        return Data(self._core, name)

    @property
    def array_names(self):
        """Names of the arrays of the packed file (formats/SPEC.md describes them)."""
        return self._core.array_names()

    def array(self, name):
        """A read-only view of an array of the packed file; nothing is copied."""
        return self._core.array(name)

    def boundary(self, field=None, label=None):
        """The outside of a mesh, or the surface of the cells with a label of a field of cells."""
        if (field is None) != (label is None):
            raise UsageError("boundary: found one of field and label; expected both or none")
        return Data(self._core.boundary() if field is None else self._core.boundary(field, label))

    def damaged_blocks(self):
        """(first byte, byte count) of each block whose checksum does not match."""
        return self._core.damaged_blocks()

    def save(self, path, replace=False):
        """Writes data that are in memory to a packed file."""
        self._core.save(os.fspath(path), replace)

    def __repr__(self):
        field = f", field {self._name!r}" if self._name else ""
        return f"<rhoray.Data: {self.kind}, bounds {self.bounds}{field}>"


def open(path, field=None):  # noqa: A001  (the command's name)
    """Maps a packed file (.rho). The program packs other files: `rhoray pack`."""
    return Data(_core.Dataset.open(os.fspath(path)), field)


def _floats(values):
    """An array of floats. Other numbers are converted, unless that would copy more than 64 MiB."""
    array = numpy.asarray(values)
    return array if array.dtype.kind == "f" or array.nbytes > 64 << 20 else array.astype(float)


# ---- arrays to data ------------------------------------------------------------------------------

def _field(name, values, unit="", labels=None):
    return _core.Field(str(name), numpy.asarray(values) if not isinstance(values, numpy.ndarray) else values,
                       unit, labels or {})


def _fields(values, default_name, units):
    named = values if isinstance(values, dict) else {default_name: values}
    units = units or {}
    return [_field(name, array, units.get(name, "")) for name, array in named.items()]


def volume(values, *, axes="zyx", spacing=(1, 1, 1), origin=(0, 0, 0), affine=None, positions=None, units=None,
           length_unit="", path="", replace=False, progress=None):
    """Packs samples on a lattice, in memory or, with `path`, into a file.

    values: an array of three axes, or a dict of arrays of one shape by field name.
    axes: "zyx" for values[k, j, i], "xyz" for values[i, j, k].
    spacing, origin: along x, y, z, whatever the axes.
    affine: 4 x 4, world from index (x, y, z, 1), instead of spacing and origin.
    positions: three rising arrays along x, y, z, instead of spacing and origin.
    progress: called with (phase, done, total).
    """
    if axes not in ("zyx", "xyz"):
        raise UsageError(f"axes: {axes!r}; expected 'zyx' or 'xyz'")
    columns = None
    if affine is not None:
        matrix = numpy.asarray(affine, dtype=float)
        if matrix.shape != (4, 4) or not numpy.array_equal(matrix[3], (0, 0, 0, 1)):
            raise UsageError(f"affine: an array of the shape {matrix.shape}; expected 4 x 4 with the last row 0 0 0 1")
        columns = [tuple(matrix[:3, column]) for column in range(4)]
    along = [numpy.asarray(axis, dtype=float).tolist() for axis in positions] if positions is not None else [[], [], []]
    if len(along) != 3:
        raise UsageError(f"positions: {len(along)} arrays; expected three, along x, y and z")
    return Data(_core.pack_grid(_fields(values, "values", units), axes == "xyz", tuple(spacing), tuple(origin), columns,
                                along, length_unit, os.fspath(path), replace, progress))


def mesh(points, tetrahedra, point_fields=None, cell_fields=None, *, units=None, length_unit="", path="",
         replace=False, progress=None):
    """Packs tetrahedra. points: [n, 3]; tetrahedra: [m, 4] indices; fields: dicts of arrays by name."""
    return Data(_core.pack_mesh(points, tetrahedra, _fields(point_fields or {}, "", units),
                                _fields(cell_fields or {}, "", units), length_unit, os.fspath(path), replace,
                                progress))


def surface(points, triangles, *, path="", replace=False, progress=None):
    """Packs a surface. points: [n, 3]; triangles: [m, 3] indices."""
    return Data(_core.pack_surface(points, triangles, os.fspath(path), replace, progress))


def pack(what, *arrays, path="", **options):
    """Packs arrays, or an object of another library, in memory or, with `path`, into a file.

    pack(values, spacing=(0.5, 0.5, 2)); pack(points, tetrahedra, {"u": u}); pack(points, triangles)
    Objects: xarray.DataArray with the dimensions x, y, z; nibabel and SimpleITK images (world axes
    become RAS); meshio.Mesh; image data, rectilinear grids, tetrahedra and triangles of VTK and pyvista.
    Options are those of `volume`, `mesh` and `surface`.
    """
    makers = {"volume": volume, "mesh": mesh, "surface": surface}
    if arrays:
        corners = numpy.asarray(arrays[0]).shape[-1:]
        return makers["surface" if corners == (3,) else "mesh"](what, *arrays, path=path, **options)
    if isinstance(what, (numpy.ndarray, dict)):
        return volume(what, path=path, **options)
    known = _objects.arrays_of(what, UsageError)
    if known is None:
        raise UsageError(f"pack: a {type(what).__name__}; expected arrays, or an object that is described in its help")
    name, values, found = known
    return makers[name](*values, path=path, **{**found, **options})


# ---- pictures ------------------------------------------------------------------------------------

class Picture:
    """A picture, with the scene that makes it again. Its arrays are views of its memory."""

    def __init__(self, core):
        self._core = core

    size = property(lambda self: self._core.size, doc="(width, height)")
    color = property(lambda self: self._core.color, doc="[height, width, 4]: linear RGB and alpha, float32")
    depth = property(lambda self: self._core.depth, doc="[height, width]: distance from the eye; None: not asked for")
    normal = property(lambda self: self._core.normal, doc="[height, width, 3]: towards the eye, world axes")
    cell = property(lambda self: self._core.cell, doc="[height, width]: id of the cell, 2**64 - 1: none")
    value = property(lambda self: self._core.value, doc="[height, width]: of the field; NaN: none")
    error = property(lambda self: self._core.error, doc="[height, width]: proven bound of depth, or of value")
    cost = property(lambda self: self._core.cost, doc="[height, width]: cells that were visited")
    stats = property(lambda self: self._core.statistics, doc="counts and times, by name")
    notes = property(lambda self: self._core.notes, doc="what was chosen otherwise than asked, one sentence each")

    @property
    def rgba(self):
        """[height, width, 3], or 4 without a background: 8-bit sRGB, as PNG files hold it."""
        return self._core.srgb8()

    @property
    def scene(self):
        """The scene document that says every choice, as a dict; `render` makes the same picture of it."""
        return json.loads(self._core.document)

    def verify(self, pixels=500, seed=1):
        """Compares random pixels, and pixels at edges, with exact arithmetic. Needs the channel depth, or value."""
        return self._core.verify(pixels, seed)

    def save(self, path, replace=False):
        """Writes a PNG file."""
        self._core.save_png(os.fspath(path), replace)

    def _repr_png_(self):
        import tempfile
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "picture.png")
            self.save(path)
            with _open_file(path, "rb") as file:
                return file.read()

    def __repr__(self):
        return f"<rhoray.Picture: {self.size[0]} x {self.size[1]}, {self.stats['hits']} pixels show something>"


def _without_none(**keys):
    return {key: value for key, value in keys.items() if value is not None}


def _layer(data, iso, mode, **keys):
    kinds = {"iso": "isosurface", "mip": "mip", "triangles": "triangles", "boundary": "boundary"}
    if mode is None:
        by_kind = {"grid": "iso", "tetrahedra": "boundary", "triangles": "triangles"}
        mode = "iso" if iso is not None else by_kind[data.kind]
    if mode not in kinds:
        raise UsageError(f"mode: {mode!r}; expected 'iso', 'mip', 'boundary' or 'triangles'")
    layer = {"data": "data", "type": kinds[mode]}
    layer.update(_without_none(**keys))
    if iso is not None:
        layer["isovalue"] = list(iso) if isinstance(iso, (list, tuple, numpy.ndarray)) else iso
    return layer


def _document(data, iso=None, mode=None, size=None, accuracy=None, view=None, azimuth=None, elevation=None, zoom=None,
              camera=None, color=None, color_by=None, colormap=None, range=None, opacity=None, normals=None,  # noqa: A002
              style=None, lights=None, effects=None, clip=None, background=None, antialias=None):
    """The scene document that the options of `render` say, for one dataset named "data"."""
    document = {"data": {"data": _without_none(file="data", field=data._name or None)},
                "layers": [_layer(data, iso, mode, color=color, color_by=color_by, colormap=colormap,
                                  range=list(range) if range is not None else None, opacity=opacity,
                                  normals=normals)],
                "camera": {**_without_none(view=view, azimuth=azimuth, elevation=elevation, zoom=zoom),
                           **(camera or {})},
                "image": _without_none(size=list(size) if size is not None else None, background=background,
                                       antialias=antialias)}
    document.update(_without_none(accuracy=accuracy, style=style, lights=lights, effects=effects, clip=clip))
    return document


def _by_file(scene, data):
    """The data that a scene names by files, each with the name of its file."""
    given = data or {}
    opened = {}
    for name, spec in scene.get("data", {}).items():
        file = spec.get("file", name)
        known = given.get(name, given.get(file))
        opened[file] = (known if known is not None else open(file))._core
    return opened


def _text_of(document):
    """JSON; numpy's numbers and arrays are taken as those of Python."""
    try:
        return json.dumps(document, allow_nan=False, default=lambda value: value.tolist())
    except ValueError:
        raise UsageError("render: a number of the scene is NaN or infinite; expected finite numbers") from None
    except AttributeError as error:
        raise UsageError(f"render: {error}; expected what JSON can say") from None


def render(what, *, data=None, channels=(), **options):
    """Renders data or a scene, and returns a Picture.

    what: Data with the options below, or a scene document: a dict, or the path of a .json file.
    data: of a scene: Data by the names in its "data"; others are opened by their files.
    channels: "depth", "normal", "cell", "value", "error" (certified or exact), "cost".

    Options are the keys of scene documents (data/scenes/README.md): iso (a number, "auto", "p95", or a
    list), mode ("iso", "mip", "boundary", "triangles"), size (width, height), accuracy, view, azimuth,
    elevation, zoom, camera (a dict), color, color_by, colormap, range, opacity, normals, style, lights,
    effects, clip, background, antialias. What is not given is chosen as `rhoray render` does.
    """
    if isinstance(what, Data):
        document, datasets = _document(what, **options), {"data": what._core}
    else:
        if options:
            raise UsageError(f"render: a scene has its own {', '.join(options)}; expected keys in its document")
        if not isinstance(what, dict):
            with _open_file(what, encoding="utf-8") as file:
                document = json.load(file)
        else:
            document = what
        datasets = _by_file(document, data)
    text = _text_of(document)
    with _Context() as context:
        try:
            return Picture(_core.render(context, text, datasets, list(channels)))
        except FileError as error:
            if not error.fact.startswith("scene:"):
                raise
            raise UsageError(error.fact, error.code, error.hint) from None


# ---- rays ----------------------------------------------------------------------------------------

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
    """
    origins, directions = _floats(origins), _floats(directions)
    limits = [None if limit is None else _floats(limit) for limit in (t_min, t_max)]
    name = field or data._name
    if query == "largest":
        if iso is not None:
            raise UsageError("trace: iso has no effect on the query 'largest'")
        with _Context() as context:
            return Hits(**_core.FieldSampler(data._core, name, accuracy).largest_values(context, accuracy, origins,
                                                                                        directions, *limits))
    if query not in ("first", "any", "all"):
        raise UsageError(f"trace: query {query!r}; expected 'first', 'any', 'all' or 'largest'")
    if iso is None and data.kind != "triangles":
        raise UsageError("trace: no isovalue; expected iso=...")
    caster = _core.RayCaster(data._core, None if iso is None else float(iso), accuracy, name)
    with _Context() as context:
        if query == "first":
            return Hits(**caster.first_hits(context, accuracy, origins, directions, *limits))
        if query == "any":
            return caster.any_hits(context, origins, directions, *limits).view(bool)
        found = caster.all_hits(context, origins, directions, *limits, max_hits)
        return AllHits(**{**found, "enters": found["enters"].view(bool), "truncated": found["truncated"].view(bool)})


def sample(data, points, *, field=None):
    """Evaluates a field at points [n, 3], world axes. Returns (values, cells); NaN: no data there."""
    return _core.FieldSampler(data._core, field or data._name, "double").sample(_floats(points))

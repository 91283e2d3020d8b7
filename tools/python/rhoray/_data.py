"""Packed data, and what makes them of arrays."""
import copy
import dataclasses
import os
import pathlib
import shutil
import tempfile
import weakref

import numpy

from rhoray import _core, _objects, _program, _progress
from rhoray._arrays import array_of, floats_of
from rhoray._errors import UsageError


@dataclasses.dataclass(frozen=True, eq=False)
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

    Its arrays stay valid while any of them, or a picture of it, is in use. `report` is the JSON summary
    of the command that made the data, as a dict; None: no command did.
    """

    def __init__(self, core, field=None, report=None, is_boundary=False):
        self._core = core
        self._name = core.field_name(field or "") if core.kind != "triangles" else ""
        self._is_boundary = is_boundary
        self.report = report

    @property
    def kind(self):
        """"grid", "tetrahedra" or "triangles"."""
        return self._core.kind

    @property
    def path(self):
        """The packed file. Data in memory have a name, too, by which other programs can open them."""
        if self._is_boundary:
            raise UsageError("path: this is the boundary of a mesh, which is in no file; expected the mesh itself")
        return self._core.path

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
        other = copy.copy(self)
        other._name = self._core.field_name(name)
        return other

    @property
    def array_names(self):
        """Names of the arrays of the packed file (formats/SPEC.md describes them)."""
        return self._core.array_names()

    def array(self, name):
        """A read-only view of an array of the packed file; nothing is copied."""
        return self._core.array(name)

    def unpack(self):
        """Copies what `volume`, `mesh` or `surface` would pack again, as a tuple of their arguments.

        A grid: ({field: values[k, j, i]},), in the types of the fields. Tetrahedra: (points [n, 3], indices
        [m, 4], fields of points, fields of cells), in the order of the source, in world axes, so that the
        cells of `sample` and `trace` are rows where the source had tetrahedra. Triangles: (points, indices).
        """
        if self.kind == "grid":
            return {name: self._core.unpack_grid(name) for name in self.fields},
        if self.kind == "tetrahedra":
            return self._core.unpack_mesh()
        self.path  # noqa: B018  (refuses the boundary of a mesh)
        return self.array("points").copy(), self.array("triangles").copy()

    def boundary(self, field=None, label=None):
        """The outside of a mesh, or the surface of the cells with a label of a field of cells."""
        if (field is None) != (label is None):
            raise UsageError("boundary: found one of field and label; expected both or none")
        core = self._core.boundary() if field is None else self._core.boundary(field, label)
        return Data(core, is_boundary=True)

    def damaged_blocks(self):
        """(first byte, byte count) of each block whose checksum does not match."""
        return self._core.damaged_blocks()

    def save(self, path, replace=False):
        """Writes the data to a packed file, which is complete or absent."""
        self._core.save(os.fspath(path), replace)

    def __repr__(self):
        field = f", field {self._name!r}" if self._name else ""
        return f"<rhoray.Data: {self.kind}, bounds {self.bounds}{field}>"


def open(path, field=None, *, raw=None, spacing=None, origin=None, time=None, progress=None):  # noqa: A001
    """Maps a packed file (.rho), or packs any file or folder that `rhoray pack` reads, and maps that.

    The packed copy is a temporary file that lives as long as the data; `pack` with a path keeps one.
    field: shown at first; of a file that is not packed, only this field is kept.
    raw, spacing, origin, time: as for `rhoray pack`, such as raw="512x512x275:uint16", spacing=(1, 1, 2).
    progress: True for a bar, or a function that is called with (phase, done, total).
    """
    reading = {"raw": raw, "spacing": spacing, "origin": origin, "time": time}
    if all(value is None for value in reading.values()) and _is_packed(path):
        return Data(_core.Dataset.open(os.path.abspath(path)), field)
    return _pack_file(path, progress=progress, field=field, **reading)


def _is_packed(path):
    """Whether a file begins as packed files do (formats/SPEC.md), or has their name."""
    start = b'{"__metadata__":{"format":"rhoray"'
    if os.path.splitext(path)[1] == ".rho":
        return True
    if not os.path.isfile(path) or not os.access(path, os.R_OK):
        return False
    with pathlib.Path(path).open("rb") as file:
        return file.read(8 + len(start))[8:] == start


# ---- files that the program makes ----------------------------------------------------------------

def made(make, path, name, field=None):
    """Data of the packed file that make(path) writes; `report` is what it returns.

    Without a path, the file lies in a temporary folder, with this name, and lives as long as the data.
    """
    if path:
        report = make(os.fspath(path))
        return Data(_core.Dataset.open(os.path.abspath(path)), field, report)
    folder = tempfile.mkdtemp(prefix="rhoray-")
    try:
        report = make(os.path.join(folder, name))
        core = _core.Dataset.open(os.path.join(folder, name))
    except BaseException:
        remove(folder)
        raise
    weakref.finalize(core, remove, folder, os.getpid())
    return Data(core, field, report)


def remove(folder, process=None):
    """Removes a temporary folder. process: the only one that does it, not those that it forked."""
    if process in (None, os.getpid()):
        shutil.rmtree(folder, ignore_errors=True)


def _pack_file(file, *, path="", replace=False, progress=None, field=None, **options):
    file = os.fspath(file)
    words = _program.option_words({"field": field, **options})

    def make(output):
        force = ["--force"] if replace else []
        return _program.run("pack", [file], [f"--output={output}", *force, *words], progress)
    if options.get("color"):
        if not path:
            raise UsageError("pack: color=True makes a texture, which needs a file; expected path=...")
        make(os.fspath(path))
        return None
    return made(make, path, pathlib.Path(os.path.abspath(file)).stem + ".rho", first_of(field))


def first_of(field):
    """The first name of an option `field`: "a,b" or ["a", "b"]; None: there is none."""
    names = field.split(",") if isinstance(field, str) else field
    return names[0] if names else None


# ---- arrays to data ------------------------------------------------------------------------------

def _field(name, values, unit="", labels=None):
    return _core.Field(str(name), array_of(values), unit, labels or {})


def _fields(values, units):
    units = units or {}
    return [_field(name, array, units.get(name, "")) for name, array in values.items()]


def _fields_of_mesh(values, argument, units):
    if values is not None and not isinstance(values, dict):
        raise UsageError(f"{argument}: found {type(values).__name__}; expected a dict of arrays by name")
    return _fields(values or {}, units)


def _absolute(path):
    return os.path.abspath(path) if path else ""


def volume(values, *, axes="zyx", spacing=None, origin=None, affine=None, positions=None, units=None,
           length_unit="", path="", replace=False, progress=None):
    """Packs samples on a lattice, in memory or, with `path`, into a file.

    values: an array of three axes, or a dict of arrays of one shape by field name.
    axes: "zyx" for values[k, j, i], "xyz" for values[i, j, k].
    spacing, origin: along x, y, z, whatever the axes; default 1 and 0.
    affine: 4 x 4, world from index (x, y, z, 1), instead of spacing and origin.
    positions: three rising arrays along x, y, z, instead of spacing and origin.
    progress: True for a bar, or a function that is called with (phase, done, total).
    """
    if axes not in ("zyx", "xyz"):
        raise UsageError(f"axes: {axes!r}; expected 'zyx' or 'xyz'")
    places = {"affine": affine, "positions": positions, "spacing": spacing, "origin": origin}
    given = [name for name, value in places.items() if value is not None]
    if len(given) > 1 and given != ["spacing", "origin"]:
        raise UsageError(f"{given[0]}: found {given[1]}, too; expected one of them")
    columns = None
    if affine is not None:
        matrix = numpy.asarray(affine, dtype=float)
        if matrix.shape != (4, 4) or not numpy.array_equal(matrix[3], (0, 0, 0, 1)):
            raise UsageError(f"affine: an array of the shape {matrix.shape}; expected 4 x 4 with the last row 0 0 0 1")
        columns = [tuple(matrix[:3, column]) for column in range(4)]
    along = [numpy.asarray(axis, dtype=float).tolist() for axis in positions] if positions is not None else [[], [], []]
    if len(along) != 3:
        raise UsageError(f"positions: {len(along)} arrays; expected three, along x, y and z")
    fields = _fields(values if isinstance(values, dict) else {"values": values}, units)
    with _progress.shown(progress) as show:
        return Data(_core.pack_grid(fields, axes == "xyz", (1, 1, 1) if spacing is None else tuple(spacing),
                                    (0, 0, 0) if origin is None else tuple(origin), columns, along, length_unit,
                                    _absolute(path), replace, show))


def mesh(points, tetrahedra, point_fields=None, cell_fields=None, *, units=None, length_unit="", path="",
         replace=False, progress=None):
    """Packs tetrahedra. points: [n, 3]; tetrahedra: [m, 4] indices; fields: dicts of arrays by name."""
    with _progress.shown(progress) as show:
        return Data(_core.pack_mesh(floats_of(points), array_of(tetrahedra),
                                    _fields_of_mesh(point_fields, "point_fields", units),
                                    _fields_of_mesh(cell_fields, "cell_fields", units), length_unit, _absolute(path),
                                    replace, show))


def surface(points, triangles, *, path="", replace=False, progress=None):
    """Packs a surface. points: [n, 3]; triangles: [m, 3] indices."""
    with _progress.shown(progress) as show:
        return Data(_core.pack_surface(floats_of(points), array_of(triangles), _absolute(path), replace, show))


def pack(what, *arrays, path="", **options):
    """Packs arrays, an object of another library, or a file, in memory or, with `path`, into a file.

    pack(values, spacing=(0.5, 0.5, 2)); pack(points, tetrahedra, {"u": u}); pack(points, triangles)
    pack("head.nrrd", path="head.rho"): the options are those of `rhoray pack`, with underscores, such as
    field=["u", "v"], cell_data=True or max_error=0.001; replace=True is --force, and without a path the
    file is temporary. color=True makes a texture: it returns None.
    Objects: xarray.DataArray with the dimensions x, y, z; nibabel and SimpleITK images (world axes
    become RAS); meshio.Mesh; image data, rectilinear grids, tetrahedra and triangles of VTK and pyvista.
    Options of arrays and objects are those of `volume`, `mesh` and `surface`.
    """
    makers = {"volume": volume, "mesh": mesh, "surface": surface}
    if arrays:
        corners = numpy.asarray(arrays[0]).shape[-1:]
        return makers["surface" if corners == (3,) else "mesh"](what, *arrays, path=path, **options)
    if isinstance(what, (str, os.PathLike)):
        return _pack_file(what, path=path, **options)
    if isinstance(what, (numpy.ndarray, dict)):
        return volume(what, path=path, **options)
    known = _objects.arrays_of(what, UsageError)
    if known is None:
        raise UsageError(f"pack: found the type {type(what).__name__}; expected arrays, a file, or an object that its "
                         "help describes")
    name, values, found = known
    return makers[name](*values, path=path, **{**found, **options})

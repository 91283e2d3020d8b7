"""Packed data, and what makes them of arrays."""
import dataclasses
import os

import numpy

from rhoray import _core, _objects
from rhoray._errors import UsageError


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

"""Files for tests of the ParaView reader, and access to its output. Needs the Python modules of ParaView 5.11."""
import inspect
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

inspect.getargspec = inspect.getfullargspec  # ParaView 5.11 imports it; Python 3.11 no longer has it
ROOT = pathlib.Path(__file__).resolve().parents[2]
RHORAY = ROOT / "build/release/bin/rhoray"
PLUGIN = ROOT / "tools/paraview/rhoray_reader.py"
RELEASED = ROOT / "tests/formats/released"
sys.path.insert(0, str(PLUGIN.parent))

from rhoray_reader import RhorayReader
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLogger
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes

PATIENCE_S = 60
HIDDEN = vtkDataSetAttributes.HIDDENCELL
vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # the pipeline says there that the reader failed
BOX = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]  # around the diagonal 0 7


# ---- Writers -------------------------------------------------------------------------------------


def numbered(x, y, z, dtype="f4"):
    """Samples [z, y, x]; all are different where the type allows it."""
    return np.arange(x * y * z).reshape(z, y, x).astype(dtype)


def write_nrrd(path, values, axes=np.eye(3), origin=(0, 0, 0), unit=""):
    types = {"f4": "float", "i2": "short", "u1": "uchar"}
    vectors = ["(" + ",".join(repr(float(x)) for x in vector) + ")" for vector in [*axes, origin]]
    header = ["NRRD0005", f"type: {types[values.dtype.str[1:]]}", "dimension: 3",
              "sizes: " + " ".join(map(str, values.shape[::-1])), "endian: little", "encoding: raw",
              "space: left-posterior-superior", 'space units: "mm" "mm" "mm"', f'sample units: "{unit}"',
              "space directions: " + " ".join(vectors[:3]), "space origin: " + vectors[3], "", ""]
    path.write_bytes("\n".join(header).encode() + values.tobytes())


def write_legacy(path, dataset, arrays, point_data, cell_data=()):
    """Legacy VTK, big-endian. `arrays`: pairs of a line and numbers."""
    def section(name, count, fields):
        blocks = [(f"{name} {count}", np.zeros(0))] if fields else []
        for field, values in fields:
            kind = {"f4": "float", "f8": "double"}[values.dtype.str[1:]]
            blocks.append((f"SCALARS {field} {kind} 1\nLOOKUP_TABLE default", values))
        return blocks
    blocks = [*arrays, *section("POINT_DATA", len(point_data[0][1]), point_data)]
    blocks += section("CELL_DATA", len(cell_data[0][1]) if cell_data else 0, cell_data)
    with open(path, "wb") as file:
        file.write(f"# vtk DataFile Version 3.0\nmade\nBINARY\nDATASET {dataset}\n".encode())
        for line, numbers in blocks:
            big_endian = numbers.astype(numbers.dtype.newbyteorder(">")).tobytes()
            file.write(line.encode() + b"\n" + big_endian + b"\n" * (len(big_endian) > 0))


def write_rectilinear(path, x, y, z, fields):
    axes = [(f"{name}_COORDINATES {len(axis)} double", np.asarray(axis, "f8")) for name, axis in zip("XYZ", (x, y, z))]
    write_legacy(path, "RECTILINEAR_GRID", [(f"DIMENSIONS {len(x)} {len(y)} {len(z)}", np.zeros(0)), *axes],
                 [(name, values.ravel()) for name, values in fields])


def box_of_tetrahedra(side):
    """Points and cells; the points are moved a little, so that all coordinates are different."""
    index = np.arange((side + 1)**3).reshape((side + 1,) * 3)
    lows = index[:-1, :-1, :-1].ravel()
    steps = [i * (side + 1)**2 + j * (side + 1) + k for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    cells = (lows[:, None, None] + np.array(steps)[np.array(BOX)]).reshape(-1, 4)
    points = np.stack(np.unravel_index(np.arange(index.size), index.shape), 1)[:, ::-1].astype(float)
    points += np.random.default_rng(7).uniform(-0.1, 0.1, points.shape)
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    cells[np.linalg.det(edges) < 0] = cells[np.linalg.det(edges) < 0][:, [0, 2, 1, 3]]
    return points, cells


def write_tetrahedra(path, points, cells, point_data, cell_data=()):
    counts = np.hstack([np.full((len(cells), 1), 4), cells]).astype("i4")
    write_legacy(path, "UNSTRUCTURED_GRID", [
        (f"POINTS {len(points)} double", points), (f"CELLS {len(cells)} {counts.size}", counts),
        (f"CELL_TYPES {len(cells)}", np.full(len(cells), 10, "i4"))], point_data, cell_data)


def write_ply(path, points, triangles):
    kind = {"f4": "float", "f8": "double"}[points.dtype.str[1:]]
    path.write_text("\n".join([
        "ply", "format ascii 1.0", f"element vertex {len(points)}", *[f"property {kind} {axis}" for axis in "xyz"],
        f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header",
        *[" ".join(repr(float(x)) for x in point) for point in points],
        *["3 %d %d %d" % tuple(triangle) for triangle in triangles], ""]))


# ---- Readers -------------------------------------------------------------------------------------


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(done.stderr)


def read(path, chosen=None, ids=False):
    """The data set of the reader, with all fields or the chosen ones."""
    reader = RhorayReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    if chosen is not None:
        for selection in (reader.GetPointArraySelection(), reader.GetCellArraySelection()):
            selection.DisableAllArrays()
            for name in chosen:
                if selection.ArrayExists(name):
                    selection.EnableArray(name)
    if ids:
        reader.GetCellArraySelection().EnableAllArrays()
    reader.Update()
    return reader.GetOutputDataObject(0)


def names(attributes):
    return [attributes.GetAbstractArray(i).GetName() for i in range(attributes.GetNumberOfArrays())]


def values(attributes, name):
    return vtk_to_numpy(attributes.GetArray(name))


def points_of(data):
    if data.IsA("vtkPointSet"):
        return vtk_to_numpy(data.GetPoints().GetData())
    return np.array([data.GetPoint(i) for i in range(data.GetNumberOfPoints())])


def cells_of(data):
    cells = data.GetPolys() if data.IsA("vtkPolyData") else data.GetCells()
    return vtk_to_numpy(cells.GetConnectivityArray()).reshape(data.GetNumberOfCells(), -1)


def texts(data):
    fields = data.GetFieldData()
    return {name: fields.GetAbstractArray(name).GetValue(0) for name in names(fields)}


# ---- The bytes of packed files -------------------------------------------------------------------


def opened(path):
    """Header, details and a function that gives arrays, as SPEC.md shows it."""
    data = np.fromfile(path, np.uint8)
    n = int(data[:8].view("<u8")[0])
    header = json.loads(bytes(data[8:8 + n]))

    def array(name):
        entry = header[name]
        begin, end = (8 + n + offset for offset in entry["data_offsets"])
        return data[begin:end].view("<" + entry["dtype"][0].lower() + str(int(entry["dtype"][1:]) // 8)).reshape(
            entry["shape"])
    return header, json.loads(header["__metadata__"]["details"]), array


def edited(path, output, edit):
    """Writes a copy and edits its header by `edit(header, details)`. The checksums stay those of the original."""
    data = path.read_bytes()
    n = int.from_bytes(data[:8], "little")
    header = json.loads(data[8:8 + n])
    details = json.loads(header["__metadata__"]["details"])
    text = header["__metadata__"]["details"]
    edit(header, details)
    if header["__metadata__"].get("details") == text:
        header["__metadata__"]["details"] = json.dumps(details)
    return with_header(data, json.dumps(header, separators=(",", ":")).encode(), output)


def with_header(data, text, output):
    """A file of other header text, with the data and the seal of `data`."""
    text += b" " * (-(8 + len(text)) % 4096)
    whole = len(text).to_bytes(8, "little") + text + data[8 + int.from_bytes(data[:8], "little"):]
    output.write_bytes(whole[:-56] + len(whole).to_bytes(8, "little") + whole[-48:])
    return output


def rename(array, name):
    """An edit of a header."""
    def edit(header, details):
        items = [(name if key == array else key, value) for key, value in header.items()]
        header.clear()
        header.update(items)
    return edit


class Packed(unittest.TestCase):
    """Tests with a folder in which they make files."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)

    def pack(self, source, *words, name="packed.rho"):
        run(RHORAY, "pack", source, "-o", self.folder / name, "--force", "--quiet", *words)
        return self.folder / name

    def assert_same(self, found, expected):
        found, expected = np.asarray(found), np.asarray(expected)
        self.assertEqual(found.dtype, expected.dtype)
        np.testing.assert_array_equal(found, expected)

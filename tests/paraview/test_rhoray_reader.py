"""The ParaView reader, on files that `rhoray pack` makes here. Needs the Python modules of ParaView 5.11."""
import gc
import inspect
import json
import os
import pathlib
import resource
import socket
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest
from unittest import mock

import numpy as np

inspect.getargspec = inspect.getfullargspec  # ParaView 5.11 imports it; Python 3.11 no longer has it
ROOT = pathlib.Path(__file__).resolve().parents[2]
RHORAY = ROOT / "build/release/bin/rhoray"
PLUGIN = ROOT / "tools/paraview/rhoray_reader.py"
RELEASED = ROOT / "tests/formats/released"
sys.path.insert(0, str(PLUGIN.parent))

import rho_file
from rhoray_reader import RhorayReader
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkDataSetAttributes
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersCore import vtkContourFilter, vtkThreshold
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLUnstructuredGridReader

PATIENCE_S = 60
HIDDEN = vtkDataSetAttributes.HIDDENCELL
vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # the pipeline says there that the reader failed
BOX = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]  # around the diagonal 0 7


# ---- Writers ----------------------------------------------------------------------------------------------------


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


# ---- Readers ----------------------------------------------------------------------------------------------------


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


class Grids(Packed):
    def assert_in_place(self, data, name, count, axes, origin):
        """Numbered samples tell where they must stand."""
        sample = np.stack(np.unravel_index(values(data.GetPointData(), name).astype(int), count[::-1]), 1)[:, ::-1]
        self.assertEqual(len(np.unique(sample, axis=0)), np.prod(count))
        np.testing.assert_allclose(points_of(data), origin + sample @ np.array(axes, float), rtol=0, atol=1e-12)

    def test_samples_of_every_type_and_layout_are_read(self):
        layouts = [[], ["--layout", "linear"], ["--brick-edge", "3"], ["--brick-edge", "2"], ["--brick-edge", "64"]]
        rng = np.random.default_rng(1)
        for dtype in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
            info = np.iinfo(dtype) if dtype[0] in "ui" else np.finfo(dtype)
            made = rng.uniform(float(info.min) / 2, float(info.max) / 2, (6, 35, 13)).astype(dtype)
            np.save(self.folder / "made.npy", made)
            for layout in layouts:
                with self.subTest(dtype=dtype, layout=layout):
                    data = read(self.pack(self.folder / "made.npy", "--spacing", "0.5,2,3", "--origin", "-1,20,1e3",
                                          *layout))
                    self.assertEqual(data.GetClassName(), "vtkImageData")
                    self.assertEqual(data.GetDimensions(), (13, 35, 6))
                    self.assertEqual(data.GetSpacing(), (0.5, 2, 3))
                    self.assertEqual(data.GetOrigin(), (-1, 20, 1000))
                    self.assertEqual(names(data.GetPointData()), ["made"])
                    self.assertEqual(names(data.GetCellData()), [])
                    self.assert_same(values(data.GetPointData(), "made"), made.ravel())

    def test_the_pipeline_knows_an_image_before_its_samples_are_read(self):
        np.save(self.folder / "made.npy", numbered(4, 5, 6))
        reader = RhorayReader()
        reader.SetFileName(str(self.pack(self.folder / "made.npy", "--spacing", "0.5,2,3", "--origin", "-1,20,1e3")))
        reader.UpdateInformation()
        info = reader.GetOutputInformation(0)
        self.assertEqual(info.Get(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT()), (0, 3, 0, 4, 0, 5))
        self.assertEqual(info.Get(vtkDataObject.SPACING()), (0.5, 2, 3))
        self.assertEqual(info.Get(vtkDataObject.ORIGIN()), (-1, 20, 1000))
        self.assertEqual(reader.GetOutputDataObject(0).GetPointData().GetNumberOfArrays(), 0)

    def test_axes_along_those_of_the_world_give_an_image_in_any_order_and_sense(self):
        count = (7, 5, 4)
        for axes in ([[2, 0, 0], [0, 3, 0], [0, 0, 0.5]], [[-2, 0, 0], [0, -3, 0], [0, 0, 0.5]],
                     [[0, 0, 2], [3, 0, 0], [0, -0.5, 0]], [[0, -2, 0], [0, 0, -3], [-0.5, 0, 0]]):
            with self.subTest(axes=axes):
                write_nrrd(self.folder / "made.nrrd", numbered(*count), axes, (10, 20, 30))
                data = read(self.pack(self.folder / "made.nrrd"))
                self.assertEqual(data.GetClassName(), "vtkImageData")
                self.assert_in_place(data, "made", count, axes, (10, 20, 30))
                self.assertTrue(np.isclose(np.abs(axes).sum(0), data.GetSpacing()).all())

    def test_rotated_and_sheared_axes_give_a_structured_grid(self):
        count, c, s = (7, 5, 4), np.cos(0.5), np.sin(0.5)
        for axes in ([[2 * c, 2 * s, 0], [-3 * s, 3 * c, 0], [0, 0, 4]], [[1, 0, 0], [0.25, 1, 0], [0, 0, 1]],
                     [[1, 0, 0], [1e-5, 1, 0], [0, 0, 1]]):
            with self.subTest(axes=axes):
                write_nrrd(self.folder / "made.nrrd", numbered(*count), axes, (1, 2, 3))
                data = read(self.pack(self.folder / "made.nrrd"))
                self.assertEqual(data.GetClassName(), "vtkStructuredGrid")
                self.assertEqual(data.GetExtent()[1::2], tuple(n - 1 for n in count))
                self.assert_in_place(data, "made", count, axes, (1, 2, 3))

    def test_a_contour_of_a_rotated_grid_stands_where_the_samples_stand(self):
        z, y, x = np.mgrid[:12, :12, :12] - 5.5
        axes = np.array([[np.cos(0.5), np.sin(0.5), 0], [-np.sin(0.5), np.cos(0.5), 0], [0, 0, 1]])
        write_nrrd(self.folder / "made.nrrd", np.sqrt(x * x + y * y + z * z).astype("f4"), axes, (10, 20, 30))
        contour = vtkContourFilter()
        contour.SetInputData(read(self.pack(self.folder / "made.nrrd")))
        contour.SetValue(0, 4)
        contour.Update()
        centre = np.array([10, 20, 30]) + np.full(3, 5.5) @ axes
        radii = np.linalg.norm(points_of(contour.GetOutput()) - centre, axis=1)
        self.assertGreater(len(radii), 100)
        np.testing.assert_allclose(radii, 4, atol=0.1)

    def test_positions_along_axes_give_a_rectilinear_grid(self):
        x, y, z = [0, 1, 3, 7, 8], [-1, 2, 2.5], [10, 11, 12, 13.5]
        fields = [("first", numbered(5, 3, 4)), ("second", -0.5 * numbered(5, 3, 4, "f8"))]
        write_rectilinear(self.folder / "made.vtk", x, y, z, fields)
        packed = self.pack(self.folder / "made.vtk", "--field", "first,second")
        data = read(packed)
        self.assertEqual(data.GetClassName(), "vtkRectilinearGrid")
        for found, expected in zip((data.GetXCoordinates(), data.GetYCoordinates(), data.GetZCoordinates()), (x, y, z)):
            self.assert_same(vtk_to_numpy(found), np.array(expected, float))
        self.assertEqual(names(data.GetPointData()), ["first", "second"])
        for name, made in fields:
            self.assert_same(values(data.GetPointData(), name), made.ravel())
        # The same with axes that pack never gives such grids.
        for axes, expected in (([[0, 0, -2], [-1, 0, 0], [0, 3, 0]], "vtkRectilinearGrid"),
                               ([[1, 0, 0], [0.5, 1, 0], [0, 0, 1]], "vtkStructuredGrid")):
            turned = edited(packed, self.folder / "turned.rho", lambda header, details: details.update(world_from_grid={
                "x_axis": axes[0], "y_axis": axes[1], "z_axis": axes[2], "origin": [1, 2, 3]}))
            data = read(turned)
            self.assertEqual(data.GetClassName(), expected)
            index = np.stack(np.unravel_index(values(data.GetPointData(), "first").astype(int), (4, 3, 5)), 1)
            positions = np.stack([np.array(x)[index[:, 2]], np.array(y)[index[:, 1]], np.array(z)[index[:, 0]]], 1)
            np.testing.assert_allclose(points_of(data), [1, 2, 3] + positions @ np.array(axes, float), atol=1e-12)

    def test_samples_without_data_stay_and_their_cells_are_hidden(self):
        made = numbered(20, 11, 9)
        made[:, :, :9] = np.nan
        made[4, 5, 15] = np.inf
        np.save(self.folder / "made.npy", made)
        absent = np.zeros((8, 10, 19), bool)
        for corner in np.ndindex(2, 2, 2):
            absent |= ~np.isfinite(made)[tuple(slice(c, c + n) for c, n in zip(corner, absent.shape))]
        for words in ([], ["--layout", "sparse"], ["--layout", "sparse", "--brick-edge", "4"]):
            with self.subTest(words=words):
                data = read(self.pack(self.folder / "made.npy", *words))
                self.assert_same(values(data.GetPointData(), "made"), made.ravel())
                self.assert_same(values(data.GetCellData(), "vtkGhostType"), absent.ravel() * np.uint8(HIDDEN))
                kept = vtkThreshold()
                kept.SetInputData(data)
                kept.SetLowerThreshold(-1)
                kept.SetUpperThreshold(1e9)
                kept.Update()
                self.assertEqual(kept.GetOutput().GetNumberOfCells(), (~absent).sum())

    def test_cells_with_data_in_one_chosen_field_are_shown(self):
        first, second = numbered(5, 4, 3), numbered(5, 4, 3)
        first[:, :, :2], second[:, :, 3:] = np.nan, np.nan
        fields = [("first", first), ("second", second)]
        write_rectilinear(self.folder / "made.vtk", range(5), range(4), range(3), fields)
        packed = self.pack(self.folder / "made.vtk", "--field", "first,second")
        for chosen, shown in ((["first"], [2, 3]), (["second"], [0, 1]), (["first", "second"], [0, 1, 2, 3]),
                              ([], [0, 1, 2, 3])):
            with self.subTest(chosen=chosen):
                data = read(packed, chosen)
                self.assertEqual(names(data.GetPointData()), chosen)
                flags = values(data.GetCellData(), "vtkGhostType") if names(data.GetCellData()) else np.zeros(24)
                self.assertEqual(list(np.flatnonzero((flags.reshape(2, 3, 4) == 0).all((0, 1)))), shown)

    def test_units_are_field_data(self):
        write_nrrd(self.folder / "made.nrrd", numbered(3, 3, 3, "i2"), unit="HU")
        self.assertEqual(texts(read(self.pack(self.folder / "made.nrrd"))), {"made_units": "HU", "length_units": "mm"})

    def test_letters_that_cannot_be_printed_are_replaced(self):
        write_nrrd(self.folder / "made.nrrd", numbered(3, 3, 3, "i2"), unit="HU")
        def edit(header, details):
            details.update(length_unit="\ud800m")
            details["field"].update(name="a\0\nb\u00b0", unit="\x7f")
        data = read(edited(self.pack(self.folder / "made.nrrd"), self.folder / "odd.rho", edit))
        self.assertEqual(names(data.GetPointData()), ["a??b\u00b0"])
        self.assertEqual(texts(data), {"length_units": "?m", "a??b\u00b0_units": "?"})

    def test_colors_have_components(self):
        made = np.random.default_rng(2).integers(0, 256, (5, 6, 7, 4)).astype("u1")
        np.save(self.folder / "made.npy", made)
        data = read(self.pack(self.folder / "made.npy", "--color"))
        self.assertEqual((data.GetClassName(), data.GetDimensions()), ("vtkImageData", (7, 6, 5)))
        self.assert_same(values(data.GetPointData(), "color"), made.reshape(-1, 4))
        turned = edited(self.folder / "packed.rho", self.folder / "turned.rho", lambda header, details: details.update(
            world_from_grid={"x_axis": [0, -2, 0], "y_axis": [0, 0, 3], "z_axis": [4, 0, 0], "origin": [0, 0, 0]}))
        data = read(turned)
        z, y, x = (points_of(data)[:, [0, 2, 1]] / [4, 3, -2]).astype(int).T
        self.assert_same(values(data.GetPointData(), "color"), made[z, y, x])

    def test_export_and_vtk_read_the_same_grid(self):
        z, y, x = np.mgrid[:9, :10, :11]
        made = (100 * np.sin(x) + 10 * y - z * z).astype("i2")
        write_nrrd(self.folder / "made.nrrd", made, [[0.5, 0, 0], [0, 0.25, 0], [0, 0, 2]], (1, 2, 3))
        data = read(self.pack(self.folder / "made.nrrd"))
        run(RHORAY, "export", self.folder / "packed.rho", "-o", self.folder / "made.vti", "--quiet")
        reader = vtkXMLImageDataReader()
        reader.SetFileName(str(self.folder / "made.vti"))
        reader.Update()
        exported = reader.GetOutput()
        self.assertEqual((data.GetExtent(), data.GetSpacing(), data.GetOrigin()),
                         (exported.GetExtent(), exported.GetSpacing(), exported.GetOrigin()))
        self.assertEqual(names(data.GetPointData()), names(exported.GetPointData()))
        self.assert_same(values(data.GetPointData(), "made"), values(exported.GetPointData(), "made"))
        self.assertEqual(data.GetPointData().GetScalars().GetName(), exported.GetPointData().GetScalars().GetName())


class Meshes(Packed):
    def assert_same_mesh(self, data, points, cells, ids):
        """Cells have the points of their source cells, in any order of the points and cells."""
        found = points_of(data)[cells_of(data)]
        expected = points[cells[ids]]
        order = np.lexsort(np.moveaxis(found, 2, 0), axis=1), np.lexsort(np.moveaxis(expected, 2, 0), axis=1)
        self.assert_same(np.take_along_axis(found, order[0][..., None], 1),
                         np.take_along_axis(expected, order[1][..., None], 1))
        edges = found[:, 1:] - found[:, :1]
        self.assertTrue((np.linalg.det(edges) > 0).all())
        return np.take_along_axis(cells_of(data), order[0], 1), np.take_along_axis(cells[ids], order[1], 1)

    def test_tetrahedra_of_both_structures_with_their_fields_are_read(self):
        points, cells = box_of_tetrahedra(5)
        fields = [("height", points[:, 2].astype("f4")), ("square", (points**2).sum(1))]
        regions = [("region", np.arange(len(cells)).astype("f4"))]
        write_tetrahedra(self.folder / "made.vtk", points, cells, fields, regions)
        for structure, cells_at_once in (("clusters", 10**6), ("clusters", 100), ("leaves", 100)):
            with self.subTest(structure=structure), mock.patch.object(rho_file, "CELLS_AT_ONCE", cells_at_once):
                data = read(self.pack(self.folder / "made.vtk", "--structure", structure), ids=True)
                self.assertEqual(data.GetClassName(), "vtkUnstructuredGrid")
                self.assertEqual((data.GetNumberOfPoints(), data.GetNumberOfCells()), (len(points), len(cells)))
                self.assertEqual({data.GetCellType(i) for i in range(len(cells))}, {10})
                self.assertEqual(sorted(names(data.GetPointData())), ["height", "square"])
                order = values(data.GetCellData(), "region").astype(int)
                self.assertEqual(sorted(order), list(range(len(cells))))
                if "cell_id" in names(data.GetCellData()):
                    self.assert_same(values(data.GetCellData(), "cell_id"), order.astype("u4"))
                numbers, source_numbers = self.assert_same_mesh(data, points, cells, order)
                for name, made in fields:
                    self.assert_same(values(data.GetPointData(), name)[numbers], made[source_numbers])
                self.assertEqual(texts(data), {})

    def test_ids_of_cells_are_read_only_on_request(self):
        points, cells = box_of_tetrahedra(2)
        write_tetrahedra(self.folder / "made.vtk", points, cells, [("height", points[:, 2])],
                         [("region", np.arange(len(cells)) + 0.5)])
        packed = self.pack(self.folder / "made.vtk")
        self.assertEqual(names(read(packed).GetCellData()), ["region"])
        self.assertEqual(names(read(packed, {"cell_id"}).GetCellData()), ["cell_id"])
        self.assertEqual(names(read(packed, {"cell_id"}).GetPointData()), [])

    def test_cells_without_data_are_hidden(self):
        points, cells = box_of_tetrahedra(3)
        made = points[:, 2].astype("f4")
        made[[0, 20, 21]] = np.nan
        write_tetrahedra(self.folder / "made.vtk", points, cells, [("height", made)],
                         [("region", np.arange(len(cells)).astype("f4"))])
        data = read(self.pack(self.folder / "made.vtk"))
        order = values(data.GetCellData(), "region").astype(int)
        self.assert_same(values(data.GetCellData(), "vtkGhostType"),
                         np.isnan(made)[cells[order]].any(1) * np.uint8(HIDDEN))
        self.assertEqual(np.isnan(values(data.GetPointData(), "height")).sum(), 3)

    def test_points_far_from_zero_keep_their_digits(self):
        points, cells = box_of_tetrahedra(2)
        points = points / 1024 + [8.5e6, -3e6, 100]
        write_tetrahedra(self.folder / "made.vtk", points, cells, [("height", points[:, 2])])
        found = points_of(read(self.pack(self.folder / "made.vtk")))
        np.testing.assert_allclose(np.sort(found, 0), np.sort(points, 0), rtol=0, atol=2e-9)

    def test_export_and_vtk_read_the_same_mesh(self):
        points, cells = box_of_tetrahedra(4)
        write_tetrahedra(self.folder / "made.vtk", points, cells, [("height", points[:, 2])],
                         [("region", np.arange(len(cells)).astype("f4"))])
        data = read(self.pack(self.folder / "made.vtk"), ids=True)
        run(RHORAY, "export", self.folder / "packed.rho", "-o", self.folder / "made.vtu", "--quiet")
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(self.folder / "made.vtu"))
        reader.Update()
        exported = reader.GetOutput()
        ids = values(data.GetCellData(), "cell_id").astype(int)
        self.assert_same(values(exported.GetCellData(), "cell_id").astype(int), np.arange(len(cells)))
        numbers, exported_numbers = self.assert_same_mesh(data, points_of(exported), cells_of(exported), ids)
        self.assert_same(values(data.GetPointData(), "height")[numbers],
                         values(exported.GetPointData(), "height")[exported_numbers])

    def test_surfaces_are_read(self):
        z, y, x = np.mgrid[:1, :6, :7]
        for dtype in ("f4", "f8"):
            with self.subTest(dtype=dtype):
                points = np.stack([x, y, np.sin(x) + 1 / 3], -1).reshape(-1, 3).astype(dtype)
                lows = (np.arange(5)[:, None] * 7 + np.arange(6)).ravel()
                triangles = (lows[:, None, None] + np.array([[0, 1, 8], [0, 8, 7]])).reshape(-1, 3)
                write_ply(self.folder / "made.ply", points, triangles)
                data = read(self.pack(self.folder / "made.ply"))
                self.assertEqual(data.GetClassName(), "vtkPolyData")
                self.assert_same(points_of(data)[cells_of(data)], points[triangles])
                self.assertEqual(names(data.GetCellData()), [])


    def test_the_data_need_neither_the_reader_nor_the_file(self):
        points, cells = box_of_tetrahedra(4)
        write_tetrahedra(self.folder / "made.vtk", points, cells, [("height", points[:, 2])])
        packed = self.pack(self.folder / "made.vtk")
        data = read(packed)
        before = points_of(data)[cells_of(data)].copy(), values(data.GetPointData(), "height").copy()
        arrays = [data.GetPoints().GetData(), data.GetCells().GetConnectivityArray(), data.GetPointData().GetArray(0)]
        # Filters of VTK make such arrays, which share the memory.
        shared = [array.NewInstance() for array in arrays]
        for copy, array in zip(shared, arrays):
            copy.ShallowCopy(array)
        os.truncate(packed, 0)
        del data, arrays, array
        gc.collect()
        rubbish = [np.full(size, 255, np.uint8) for size in range(1000, 30000, 10)]
        corners = vtk_to_numpy(shared[1]).reshape(-1, 4)
        self.assert_same(vtk_to_numpy(shared[0])[corners], before[0])
        self.assert_same(vtk_to_numpy(shared[2]), before[1])
        del rubbish


class ReleasedFiles(unittest.TestCase):
    """Files of all versions. The formulas of SPEC.md, written out, give the samples by another road."""

    def test_every_kind_and_version_is_read(self):
        found = {path.name: read(path).GetClassName() for path in RELEASED.glob("*.rho")}
        self.assertGreaterEqual(len(found), 10)
        kinds = {"grid": ("vtkImageData", "vtkRectilinearGrid"), "tets": ("vtkUnstructuredGrid",),
                 "surface": ("vtkPolyData",), "colors": ("vtkImageData",)}
        for name, vtk_class in found.items():
            self.assertIn(vtk_class, kinds[name.removesuffix(".rho").split("-")[-1]], name)

    def test_samples_stand_where_the_formula_says(self):
        for path in RELEASED.glob("*grid.rho"):
            with self.subTest(path=path.name):
                header, details, array = opened(path)
                count, n, (mx, my, mz) = details["sample_count"], details["brick_edge"], details["superbrick_edge"]
                sx, sy, sz = (-(-c // (n * m)) for c, m in zip(count, (mx, my, mz)))
                samples, world = array("samples").ravel(), {}
                affine = [np.array(details["world_from_grid"][key]) for key in ("x_axis", "y_axis", "z_axis", "origin")]
                positions = [array(f"axis.{a}") if f"axis.{a}" in header else np.arange(c) for a, c in enumerate(count)]
                for i, j, k in np.ndindex(*count):
                    if "bricks" in header:
                        slot = int(array("bricks")[k // n, j // n, i // n])
                        address = slot * n**3 + k % n * n * n + j % n * n + i % n
                    else:
                        brick = ((k // n % mz) * my + j // n % my) * mx + i // n % mx
                        superbrick = ((k // n // mz) * sy + j // n // my) * sx + i // n // mx
                        address = (superbrick * mx * my * mz + brick) * n**3 + (k % n * n + j % n) * n + i % n
                        slot = 0
                    place = affine[3] + sum(p[n] * vector for p, n, vector in zip(positions, (i, j, k), affine))
                    world[tuple(np.round(place, 9) + 0.0)] = np.nan if slot == 2**32 - 1 else samples[address]
                data = read(path)
                expected = [world[tuple(np.round(point, 9) + 0.0)] for point in points_of(data)]
                found = values(data.GetPointData(), details["field"]["name"])
                np.testing.assert_array_equal(found, np.array(expected).astype(found.dtype))
                self.assertEqual(len(world), data.GetNumberOfPoints())


# ---- Bad files --------------------------------------------------------------------------------------------------


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
    """A copy whose header was edited: `edit(header, details)`. Checksums are not those of the copy."""
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


class BadFiles(Packed):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.bad = cls.folder / "bad.rho"
        np.save(cls.folder / "made.npy", numbered(9, 8, 7))
        points, cells = box_of_tetrahedra(3)
        write_tetrahedra(cls.folder / "made.vtk", points, cells, [("height", points[:, 2])])
        write_ply(cls.folder / "made.ply", points[:, :3], cells[:, :3])
        write_rectilinear(cls.folder / "rectilinear.vtk", [0, 1, 3], [0, 2], [0, 1], [("made", numbered(3, 2, 2))])
        for name, source, *words in (("grid", "made.npy"), ("sparse", "made.npy", "--layout", "sparse"),
                                     ("clusters", "made.vtk"), ("leaves", "made.vtk", "--structure", "leaves"),
                                     ("surface", "made.ply"), ("rectilinear", "rectilinear.vtk")):
            run(RHORAY, "pack", cls.folder / source, "-o", cls.folder / f"{name}.rho", "--quiet", *words)
        cls.names = ("grid", "sparse", "clusters", "leaves", "surface", "rectilinear")

    def messages(self, path):
        """What the reader says in a pipeline."""
        window, before = vtkStringOutputWindow(), vtkOutputWindow.GetInstance()
        vtkOutputWindow.SetInstance(window)
        try:
            self.data = read(path)
        finally:
            vtkOutputWindow.SetInstance(before)
        return window.GetOutput()

    def assert_refused(self, path, pattern):
        lines = [line for line in self.messages(path).splitlines() if line.startswith("ERROR: /")]
        self.assertTrue(lines, "it was read")
        self.assertTrue(self.data is None or self.data.GetNumberOfPoints() == 0)
        self.assertRegex(lines[0], pattern)
        self.assertRegex(lines[0], rf"^ERROR: {path}, .+: found .+; expected .+")

    def assert_edit_refused(self, name, edit, pattern):
        self.assert_refused(edited(self.folder / f"{name}.rho", self.bad, edit), pattern)

    def test_names_of_files_may_be_no_text(self):
        path = self.folder / os.fsdecode(b"\xff.rho")
        self.assertRegex(self.messages(path), r"No such file .*/\\udcff.rho")
        path.write_bytes(b"")
        self.assertRegex(self.messages(path), r"/[?].rho, byte 0: found the end of the file")
        path.write_bytes((self.folder / "grid.rho").read_bytes())
        self.assertEqual(self.messages(path), "")
        self.assertEqual(self.data.GetNumberOfPoints(), 504)

    def test_good_files_are_silent(self):
        for name in self.names:
            self.assertEqual(self.messages(self.folder / f"{name}.rho"), "", name)
            self.assertEqual(self.messages(edited(self.folder / f"{name}.rho", self.bad, lambda *_: None)), "", name)

    def test_files_cut_anywhere_are_refused(self):
        for name in self.names:
            whole = (self.folder / f"{name}.rho").read_bytes()
            cuts = [0, 1, 7, 8, 100, 4095, 4096, 4159, 4160, 5000, len(whole) // 2, len(whole) - 4096, len(whole) - 64,
                    len(whole) - 1]
            for cut in cuts:
                with self.subTest(name=name, cut=cut):
                    self.bad.write_bytes(whole[:cut])
                    self.assert_refused(self.bad, "the end of the file|the seal of a complete file|the size of the "
                                                  "file|the length of the header")
        self.bad.write_bytes(whole + bytes(64))
        self.assert_refused(self.bad, "the seal of a complete file")
        self.bad.write_bytes(whole + whole[-64:])
        self.assert_refused(self.bad, f"found {len(whole)}; expected {len(whole) + 64}, the size of the file")

    def test_other_files_are_refused(self):
        whole = (self.folder / "grid.rho").read_bytes()
        self.bad.write_bytes(whole.replace(b"rhoray", b"horray", 1))
        self.assert_refused(self.bad, "byte 8: .*horray.*; expected the start of a .rho file")
        self.assert_refused(self.folder, "found a folder or a special file")
        os.mkfifo(self.folder / "pipe.rho")
        self.assert_refused(self.folder / "pipe.rho", "found a folder or a special file")
        self.assertIn("No such file", self.messages(self.folder / "missing.rho"))
        for length in (0, 1, 4087, 4088, 2**20 + 4088, 2**63, 2**64 - 8, 2**64 - 1):
            self.bad.write_bytes(length.to_bytes(8, "little") + whole[8:])
            self.assert_refused(self.bad, "byte 0: found .*the length of the header|header: found .*a JSON object")

    def test_newer_versions_features_and_kinds_are_refused(self):
        def metadata(**changes):
            return lambda header, details: header["__metadata__"].update(changes)
        self.assert_edit_refused("grid", metadata(version="2.0"), "version: found '2.0'; expected 1.x; a newer reader")
        for version in ("1", "1.x", "", "1.00000", "0.9", "10.0"):
            self.assert_edit_refused("grid", metadata(version=version), "header, version")
        self.assertEqual(self.messages(edited(self.folder / "grid.rho", self.bad, metadata(version="1.99"))), "")
        self.assert_edit_refused("grid", metadata(requires="axis-tables,warp"), "requires: found 'axis-tables,warp'; "
                                 "expected some of axis-tables, cell-clusters, sparse-bricks; a newer reader")
        self.assert_edit_refused("grid", metadata(kind="vdb"), "kind: found 'vdb'; expected grid, .*rhoray pack")
        for key in ("version", "requires", "kind", "details"):
            self.assert_edit_refused("grid", lambda header, details: header["__metadata__"].pop(key), f"header, {key}")

    def test_headers_that_are_not_json_objects_are_refused(self):
        whole = (self.folder / "grid.rho").read_bytes()
        start = b'{"__metadata__":{"format":"rhoray"'
        for text in (b"", b"}}}", b"},", b',"a":1e999999}', b',"a":' + b"9" * 5000 + b"}}", b',"format":"rhoray"}}',
                     b',"a":"\xff"}}', b',"a":' + b"[" * 100000):
            self.assert_refused(with_header(whole, start + text, self.bad), "header: found .*; expected a JSON object")
        for details in ("[]", "{", "", '{"a":1,"a":1}', "[" * 50000):
            self.assert_edit_refused("grid", lambda header, _: header["__metadata__"].update(details=details),
                                     "details: found .*; expected a JSON object")

    def test_arrays_outside_the_file_or_of_another_size_are_refused(self):
        def array(**changes):
            return lambda header, details: header["samples"].update(changes)
        for offsets in ([4096, 10**9], [10**9, 10**9 + 3072], [-4096, -1024], [4096], 4096):
            self.assert_edit_refused("grid", array(data_offsets=offsets), "array 'samples': found data_offsets")
        self.assert_edit_refused("grid", array(shape=[2**40], data_offsets=[4096, 4096 + 2**42]), "the end of the file")
        self.assert_edit_refused("grid", array(shape=[2**62, 2**62]), "array 'samples': found data_offsets")
        for changes in ({"shape": [-1]}, {"shape": 5}, {"shape": [1] * 9}, {"shape": [True]}, {"dtype": "F16"},
                        {"dtype": []}, {"more": 1}):
            self.assert_edit_refused("grid", array(**changes), "array 'samples'")
        self.assert_edit_refused("grid", lambda header, _: header.update(samples=[]), "array 'samples'")
        self.assert_edit_refused("grid", lambda header, _: header.pop("_seal"), "header: found arrays of")
        self.assert_edit_refused("grid", rename("_pad.0", "odd"), "array 'odd': found its start at .* a multiple of 64")
        for name, arrays in (("grid", ["samples"]), ("sparse", ["samples", "bricks"]), ("leaves", ["cells", "field.0"]),
                             ("clusters", ["points", "cluster.offsets", "cluster.vertices", "cluster.corners"]),
                             ("surface", ["points", "triangles"])):
            for missing in arrays:
                self.assert_edit_refused(name, rename(missing, "other"), f"found no array '{missing}'")

    def test_details_that_do_not_fit_are_refused(self):
        huge = [2**20] * 3
        for name, key, values_of_key in (
                ("grid", "sample_count", [[9, 8], [9, 8, 1], [9, 8, 8.0], [9, 8, 70], [9, 8, 2**21], huge, None]),
                ("grid", "brick_edge", [0, 65, True, "4", 5]), ("grid", "superbrick_edge", [[0, 1, 1], [1, 1, 1], 1]),
                ("grid", "field", [[], None]), ("grid", "more_fields", [[1], {}]),
                ("sparse", "stored_brick_count", [2**33, 1, -1]), ("sparse", "sample_count", [huge]),
                ("clusters", "point_count", [0, 10**9, 63]), ("clusters", "cell_count", [2**32, 161]),
                ("clusters", "clusters", [{}, [], {"size": 64, "vertex_count": 3}, {"size": 65, "vertex_count": 64}]),
                ("clusters", "fields", [{"a": 1}]), ("clusters", "origin", [[0, 0, None], [0, 0, 1e301]]),
                ("clusters", "length_unit", [5]), ("surface", "point_type", ["U8", None]),
                ("surface", "triangle_count", [-1, 1]), ("leaves", "cell_count", [7])):
            for bad in values_of_key:
                with self.subTest(name=name, key=key, bad=bad):
                    self.assert_edit_refused(name, lambda header, details: details.update({key: bad}),
                                             "details/|array '")
        def of_integers(header, details):
            header["samples"]["dtype"] = details["field"]["type"] = "U32"
        self.assert_edit_refused("sparse", of_integers, "details/more_fields: .*U32")
        for field in ({}, {"name": ""}, {"type": "F16"}, {"unit": 3}):
            self.assert_edit_refused("grid", lambda header, details: details["field"].update(field) or
                                     (details["field"].clear() if not field else None), "details/more_fields")
        for axes in ({"x_axis": [0, 0, 0]}, {"x_axis": [1, 0, 0], "y_axis": [2, 0, 0]}, {"origin": [1e400, 0, 0]}):
            self.assert_edit_refused("grid", lambda header, details: details["world_from_grid"].update(axes),
                                     "details/world_from_grid")

    def assert_number_refused(self, name, array, place, number, pattern):
        """Changes one element of an array."""
        header, _, _ = opened(self.folder / f"{name}.rho")
        data = bytearray((self.folder / f"{name}.rho").read_bytes())
        begin, end = (8 + int.from_bytes(data[:8], "little") + offset for offset in header[array]["data_offsets"])
        encoded = np.array(number, rho_file.DTYPES[header[array]["dtype"]]).tobytes()
        place %= (end - begin) // len(encoded)
        data[begin + place * len(encoded):begin + (place + 1) * len(encoded)] = encoded
        self.bad.write_bytes(data)
        self.assert_refused(self.bad, pattern)

    def test_numbers_that_lead_out_of_arrays_are_refused(self):
        offsets = opened(self.folder / "clusters.rho")[2]("cluster.offsets")
        self.assertEqual(len(offsets), 4)
        last_table = int(offsets[-1] - offsets[-2])
        for name, array, place, number in (
                ("leaves", "cells", 5, 64), ("leaves", "cells", 0, 2**32 - 1), ("clusters", "cluster.vertices", 3, 64),
                ("clusters", "cluster.corners", 7, 255), ("clusters", "cluster.corners", -1, last_table),
                ("clusters", "cluster.offsets", 1, 2**63), ("clusters", "cluster.offsets", 1, int(offsets[2]) + 1),
                ("clusters", "cluster.offsets", 0, 1), ("clusters", "cluster.offsets", -1, int(offsets[-1]) - 1),
                ("surface", "triangles", 4, 2**31), ("surface", "points", 3, np.nan), ("clusters", "points", 0, np.inf),
                ("sparse", "bricks", 0, 8), ("rectilinear", "axis.0", 1, np.nan), ("rectilinear", "axis.0", 2, 1),
                ("rectilinear", "axis.0", 0, -np.inf)):
            with self.subTest(array=array, place=place, number=number):
                self.assert_number_refused(name, array, place, number, f"array '{array}', element [0-9]+: found")

    def write_empty_grid(self, bricks):
        """A sparse grid with many samples, of which none is stored."""
        table = 4 * bricks**3

        def edit(header, details):
            seal = {name: header[name] for name in ("_sum", "_seal")}
            for name in [name for name in header if name != "__metadata__"]:
                del header[name]
            header["bricks"] = {"dtype": "U32", "shape": [bricks] * 3, "data_offsets": [0, table]}
            header["samples"] = {"dtype": "F32", "shape": [0, 64, 64, 64], "data_offsets": [table, table]}
            header["_sum"] = {**seal["_sum"], "shape": [0], "data_offsets": [table, table]}
            header["_seal"] = {**seal["_seal"], "data_offsets": [table, table + 64]}
            details.update(sample_count=[64 * bricks] * 3, brick_edge=64, stored_brick_count=0)
        edited(self.folder / "sparse.rho", self.bad, edit)
        data = self.bad.read_bytes()
        start = 8 + int.from_bytes(data[:8], "little")
        size = (start + table + 64).to_bytes(8, "little")
        self.bad.write_bytes(data[:start] + b"\xff" * table + data[-64:-56] + size + data[-48:])

    def test_a_grid_larger_than_the_memory_is_refused(self):
        self.write_empty_grid(4)
        self.assertEqual(self.messages(self.bad), "")
        self.assertTrue(np.isnan(values(self.data.GetPointData(), "made")).all())
        self.write_empty_grid(256)
        self.assertRegex(self.messages(self.bad), rf"^ERROR: {self.bad}: needs 16384.0 GiB of memory; this machine has")
        self.write_empty_grid(8)
        before = resource.getrlimit(resource.RLIMIT_AS)
        used = int(pathlib.Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + 2**28, before[1]))
        try:
            self.assertRegex(self.messages(self.bad), rf"^ERROR: {self.bad}: Unable to allocate 512. MiB")
        finally:
            resource.setrlimit(resource.RLIMIT_AS, before)

    def test_random_damage_is_refused_or_harmless(self):
        rng, refused = np.random.default_rng(5), 0
        for name in self.names:
            whole = np.fromfile(self.folder / f"{name}.rho", np.uint8)
            header, _, _ = opened(self.folder / f"{name}.rho")
            text = len(json.dumps(header, separators=(",", ":")))
            for _ in range(150):
                damaged = whole.copy()
                places = rng.integers(0, text if rng.random() < 0.7 else len(whole), rng.integers(1, 4))
                damaged[places] = rng.integers(0, 256, len(places))
                damaged.tofile(self.bad)
                try:
                    data = rho_file.open_data(str(self.bad))
                    for field in data.point_fields:
                        data.read_point_values(field, np.empty(data.point_shape, rho_file.DTYPES[field.type]))
                    if isinstance(data, rho_file.Mesh):
                        corners = np.empty((data.cell_count, data.corner_count), np.int64)
                        data.read_corners(corners)
                        self.assertLess(corners.max(), data.point_count)
                except rho_file.RhoError as error:
                    refused += 1
                    self.assertRegex(str(error), "found .*; expected ")
                    self.assertLess(len(str(error)), 1000)
        self.assertGreater(refused, 300)
        self.assertLess(refused, 150 * len(self.names))


# ---- ParaView ---------------------------------------------------------------------------------------------------


class ParaView(Packed):
    """The plugin in pvpython and pvserver."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        site = cls.folder / "base/lib/python3.11/site-packages"
        site.mkdir(parents=True)
        # As tools/paraview/README.md tells users to do.
        (site / "usercustomize.py").write_text("import inspect; inspect.getargspec = inspect.getfullargspec\n")
        cls.environment = {**os.environ, "PYTHONUSERBASE": str(cls.folder / "base"), "PYTHONDONTWRITEBYTECODE": "1"}
        np.save(cls.folder / "made.npy", numbered(9, 8, 7))
        points, cells = box_of_tetrahedra(3)
        write_tetrahedra(cls.folder / "made.vtk", points, cells,
                         [("height", points[:, 2].astype("f4")), ("square", (points**2).sum(1))])
        for name, source in (("grid", "made.npy"), ("mesh", "made.vtk")):
            run(RHORAY, "pack", cls.folder / source, "-o", cls.folder / f"{name}.rho", "--quiet")

    def pvpython(self, script, **environment):
        """What a script prints that begins with these lines."""
        start = f"from paraview.simple import *\nplugin = {str(PLUGIN)!r}\nfolder = {str(self.folder)!r}\n"
        done = subprocess.run(["pvpython", "-c", start + textwrap.dedent(script)], capture_output=True, text=True,
                              env={**self.environment, **environment}, timeout=PATIENCE_S)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split("\n")[:-1]

    SHOW = """
        for name in ("grid", "mesh"):
            reader = OpenDataFile(f"{folder}/{name}.rho")
            reader.UpdatePipeline()
            info = reader.GetDataInformation()
            print(type(reader).__name__, info.GetDataSetTypeAsString(), info.GetNumberOfPoints(),
                  info.GetNumberOfCells(), *sorted(reader.PointData.keys()))
        """
    SHOWN = ["RhorayReader vtkImageData 504 336 made", "RhorayReader vtkUnstructuredGrid 64 162 height square"]

    def test_a_script_loads_the_plugin_and_opens_files(self):
        self.assertEqual(self.pvpython("LoadPlugin(plugin, ns=globals())\n" + textwrap.dedent(self.SHOW)), self.SHOWN)

    def test_the_plugin_is_found_in_a_folder(self):
        self.assertEqual(self.pvpython(self.SHOW, PV_PLUGIN_PATH=str(PLUGIN.parent)), self.SHOWN)

    def test_fields_are_chosen_and_another_file_is_opened(self):
        self.assertEqual(self.pvpython("""
            LoadPlugin(plugin, ns=globals())
            reader = RhorayReader(FileName=f"{folder}/mesh.rho", PointArrayStatus=["square"])
            for chosen in (None, ["height"], [], ["height", "square"]):
                if chosen is not None:
                    reader.PointArrayStatus = chosen
                reader.UpdatePipeline()
                print(*sorted(reader.PointData.keys()), sep=",")
            reader.FileName = f"{folder}/grid.rho"
            reader.UpdatePipeline()
            print(*reader.PointArrayStatus.Available, *reader.PointData.keys())
            contour = Contour(Input=reader, ContourBy="made", Isosurfaces=[100.5])
            x, y, z = servermanager.Fetch(contour).GetPoint(20)
            print(abs(x + 9 * y + 72 * z - 100.5) < 1e-4)
            """), ["square", "height", "", "height,square", "made made", "True"])

    def test_a_server_reads_the_file(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        server = subprocess.Popen(["pvserver", f"--server-port={port}"], stdout=subprocess.DEVNULL,
                                  env=self.environment)
        try:
            end = time.monotonic() + PATIENCE_S
            while time.monotonic() < end and f":{port:04X} 00000000:0000 0A" not in \
                    pathlib.Path("/proc/net/tcp").read_text() + pathlib.Path("/proc/net/tcp6").read_text():
                time.sleep(0.1)
            shown = self.pvpython(f"Connect('127.0.0.1', {port})\nLoadPlugin(plugin, remote=True, ns=globals())\n"
                                  + textwrap.dedent(self.SHOW))
            self.assertEqual([line for line in shown if line.startswith("Rhoray")], self.SHOWN)
            server.wait(PATIENCE_S)  # it ends with its client
        finally:
            server.kill()
            server.wait()

    def test_of_several_processes_the_first_reads(self):
        for name in ("grid", "mesh"):
            counts = []
            for piece in (0, 1, 2):
                reader = RhorayReader()
                reader.SetFileName(str(self.folder / f"{name}.rho"))
                reader.UpdatePiece(piece, 3, 0)
                counts.append(reader.GetOutputDataObject(0).GetNumberOfCells())
            self.assertEqual(counts, [336 if name == "grid" else 162, 0, 0], name)


if __name__ == "__main__":
    unittest.main()

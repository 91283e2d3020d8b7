"""Grids in the ParaView reader."""
import unittest

import numpy as np

from support import (HIDDEN, Packed, RHORAY, edited, names, numbered, points_of, read, run, texts, values,
                     write_nrrd, write_rectilinear)
from rhoray_reader import RhorayReader
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersCore import vtkContourFilter, vtkThreshold
from vtkmodules.vtkIOXML import vtkXMLImageDataReader


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


if __name__ == "__main__":
    unittest.main()

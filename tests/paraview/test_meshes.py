"""Meshes, surfaces and released files in the ParaView reader."""
import gc
import os
import unittest
from unittest import mock

import numpy as np

from support import (HIDDEN, Packed, RELEASED, RHORAY, box_of_tetrahedra, cells_of, names, opened, points_of, read,
                     run, texts, values, write_ply, write_tetrahedra)
import rho_file
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


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


if __name__ == "__main__":
    unittest.main()

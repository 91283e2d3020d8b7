"""Damaged and unusual files in the ParaView reader."""
import json
import os
import pathlib
import resource
import unittest

import numpy as np

from support import (Packed, RHORAY, box_of_tetrahedra, edited, numbered, opened, read, rename, run, values,
                     with_header, write_ply, write_rectilinear, write_tetrahedra)
import rho_file
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow


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
        """The messages of the reader in a pipeline."""
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
        """A sparse grid with many samples. No brick is stored."""
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


if __name__ == "__main__":
    unittest.main()

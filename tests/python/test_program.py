"""Functions that start the program, compared with what the program itself prints and writes."""
import csv
import gc
import json
import os
import pathlib
import subprocess

import numpy
import pytest
import rhoray as rr
from conftest import distance_samples

PROGRAM = os.environ["RHORAY_PROGRAM"]
MEASURED = {"seconds", "cpu_seconds", "peak_bytes", "worker_peak_bytes", "range_proof"}  # differ from run to run


def printed(*words, cwd):
    """The JSON document that the program prints."""
    done = subprocess.run([PROGRAM, *map(str, words), "--json", "-q"], cwd=cwd, capture_output=True, text=True)
    assert done.returncode in (0, 6), done.stderr
    return json.loads(done.stdout)


def refused(*words, cwd):
    """(exit code, fact, hint) of the program."""
    done = subprocess.run([PROGRAM, *map(str, words), "-q"], cwd=cwd, capture_output=True, text=True)
    fact, _, hint = done.stderr.strip().partition("\nhint: ")
    return done.returncode, fact.partition(": ")[2], hint


def without_measured(document):
    return {key: value for key, value in document.items() if key not in MEASURED}


def write_nrrd(path):
    path.write_bytes(b"NRRD0004\ntype: float\ndimension: 3\nsizes: 41 33 25\nspacings: 0.5 0.5 0.5\n"
                     b"endian: little\nencoding: raw\n\n" + distance_samples().tobytes())


CUBE = numpy.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float) * (1 / 3) + 0.1
SIDES = numpy.array([[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2],
                     [2, 4, 6], [1, 3, 5], [3, 7, 5]])


def write_ply(path, triangles=SIDES):
    rows = [" ".join(map(repr, point)) for point in CUBE.tolist()]
    rows += ["3 " + " ".join(map(str, corners)) for corners in triangles]
    path.write_text("ply\nformat ascii 1.0\nelement vertex 8\n"
                    "property double x\nproperty double y\nproperty double z\n"
                    f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
                    + "\n".join(rows) + "\n")


def write_vtk(path):
    """A mesh of other cells than tetrahedra, with two fields: two cubes of one corner."""
    points = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1, 2)]
    corners = [[i, i + 1, i + 4, i + 3, i + 6, i + 7, i + 10, i + 9] for i in (0, 1)]
    path.write_text("# vtk DataFile Version 3.0\ncubes\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 12 double\n"
                    + "\n".join(" ".join(map(str, point)) for point in points) + "\nCELLS 2 18\n"
                    + "\n".join("8 " + " ".join(map(str, cell)) for cell in corners) + "\nCELL_TYPES 2\n12\n12\n"
                    + "POINT_DATA 12\nSCALARS u double 1\nLOOKUP_TABLE default\n"
                    + "\n".join(str(x + 2 * y) for x, y, _ in points)
                    + "\nSCALARS w double 1\nLOOKUP_TABLE default\n" + "\n".join(str(z) for _, _, z in points) + "\n")


@pytest.fixture
def folder(tmp_path, monkeypatch, ball, box):
    """The working folder, with data of every kind."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    ball.save("ball.rho")
    box.save("box.rho")
    write_nrrd(tmp_path / "ball.nrrd")
    write_vtk(tmp_path / "cubes.vtk")
    write_ply(tmp_path / "cube.ply")
    write_ply(tmp_path / "open.ply", SIDES[1:])
    return tmp_path


# ---- open, pack, info ----------------------------------------------------------------------------

def test_info_is_that_of_the_program(folder, ball):
    for name in ("ball.rho", "box.rho", "ball.nrrd", "cubes.vtk", "cube.ply"):
        assert rr.info(name, stats=True) == printed("info", name, "--stats", cwd=folder)
    in_memory = rr.info(ball)
    assert in_memory["fields"] == rr.info("ball.rho")["fields"]
    assert in_memory["file"] == ball.path
    os.rename("ball.nrrd", "-ball.nrrd")  # which is not an option
    assert rr.info("-ball.nrrd", spacing=(1, 2, 3))["geometry"]["spacing"] == [1, 2, 3]


def test_packed_files_are_those_of_the_program(folder):
    calls = [("ball.nrrd", {"spacing": (1, 2, 3), "type": "F64"}, ["--spacing=1,2,3", "--type=F64"]),
             ("cubes.vtk", {"field": ["w", "u"], "max_error": 0.001}, ["--field=w,u", "--max-error=0.001"]),
             ("cube.ply", {}, [])]
    for name, options, words in calls:
        report = printed("pack", name, *words, "-o", "packed.rho", "--force", cwd=folder)
        expected = pathlib.Path("packed.rho").read_bytes()
        data = rr.pack(name, path="packed.rho", replace=True, **options)
        assert pathlib.Path("packed.rho").read_bytes() == expected
        assert without_measured(data.report) == without_measured(report)
        assert data.field is None or data.field.name == options.get("field", ["ball"])[0]
    assert data.path == str(folder / "packed.rho")  # from every folder
    assert rr.pack("ball.nrrd").field.range == rr.open("ball.rho").field.range


def test_other_files_are_opened_by_a_copy_that_lives_as_long_as_the_data(folder, monkeypatch):
    subprocess.run([PROGRAM, "pack", "cubes.vtk", "-o", "cubes.rho", "-q"], check=True)
    expected, data = rr.open("cubes.rho"), rr.open(pathlib.Path("cubes.vtk"))
    assert data.array_names == expected.array_names
    assert all(numpy.array_equal(data.array(name), expected.array(name)) for name in data.array_names if name[0] != "_")
    monkeypatch.chdir("/")
    assert rr.info(data)["fields"] == rr.info(expected)["fields"]
    copy, points = pathlib.Path(data.path), data.array("points").copy()
    array, other = data.array("points"), data.with_field("w")
    assert other.field.name == "w"
    del data
    gc.collect()
    assert rr.info(other)["file"] == str(copy)
    del other
    gc.collect()
    assert copy.exists()  # because of the array
    assert numpy.array_equal(array, points)
    del array
    gc.collect()
    assert not copy.parent.exists()


def test_options_of_reading_are_taken_when_opening(folder):
    pathlib.Path("ball.raw").write_bytes(b"skip" + distance_samples().tobytes())
    data = rr.open("ball.raw", raw="41x33x25:float32:le:4", spacing=numpy.array([0.5, 0.5, 0.5]), origin=(1, 0, 0))
    assert data.bounds == ((1, 0, 0), (21, 16, 12))
    assert data.field.range == rr.open("ball.rho").field.range
    assert rr.open("cubes.vtk", "w").field.name == "w"
    os.rename("ball.rho", "ball.data")
    assert rr.open("ball.data").kind == "grid"  # packed files are known by their beginning
    with pytest.raises(rr.UsageError, match="packed file"):
        rr.open("ball.data", spacing=(1, 1, 1))


def test_data_in_temporary_files_can_be_saved(folder):
    data = rr.open("ball.nrrd")
    data.save("saved.rho")
    assert pathlib.Path("saved.rho").read_bytes() == pathlib.Path(data.path).read_bytes()
    with pytest.raises(rr.UsageError, match="saved.rho already exists"):
        data.save("saved.rho")
    data.save("saved.rho", replace=True)
    assert not list(folder.glob("*.part"))


def test_colours_are_packed_to_files(folder):
    pathlib.Path("photo.nrrd").write_bytes(b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 2 2 2\nkinds: RGB-color "
                                           b"domain domain domain\nencoding: raw\n\n" + bytes(range(24)))
    assert rr.pack("photo.nrrd", color=True, path="photo.rho") is None
    assert rr.info("photo.rho")["kind"] == "colors"
    with pytest.raises(rr.UsageError, match="path="):
        rr.pack("photo.nrrd", color=True)


# ---- resample ------------------------------------------------------------------------------------

def test_resampled_grids_are_those_of_the_program(folder, box):
    report = printed("resample", "cubes.vtk", "--size=9", "-o", "grid.rho", cwd=folder)
    expected = pathlib.Path("grid.rho").read_bytes()
    grid = rr.resample("cubes.vtk", "grid.rho", size=9, replace=True)
    assert pathlib.Path("grid.rho").read_bytes() == expected
    assert without_measured(grid.report) == without_measured(report)
    small = rr.resample(box, size=(5, 6, 7))
    assert small.report["errors"] == printed("resample", "box.rho", "--size=5x6x7", "-o", "b.rho", cwd=folder)["errors"]
    assert numpy.array_equal(small.array("samples"), rr.open("b.rho").array("samples"), equal_nan=True)
    assert list(pathlib.Path(small.path).parent.iterdir()) == [pathlib.Path(small.path)]


def test_the_shown_field_is_resampled_first_with_the_others(folder):
    grid = rr.resample(rr.open("cubes.vtk").with_field("w"), spacing=0.5)
    assert (grid.field.name, list(grid.fields)) == ("w", ["w", "u"])
    assert list(rr.resample(rr.open("cubes.vtk"), spacing=(0.5, 0.5, 0.5), field="w").fields) == ["w"]


def test_openvdb_files_are_written_and_opened(folder):
    grid = rr.resample("cubes.vtk", pathlib.Path("grid.vdb"), size=9, field="u")
    assert pathlib.Path("grid.vdb").stat().st_size > 0
    assert grid.kind == "grid" and grid.report["file"] == "grid.vdb"
    assert grid.field.range == pytest.approx(rr.resample("cubes.vtk", size=9, field="u").field.range)


def test_an_error_that_is_not_reached_is_refused(folder):
    code, fact, hint = refused("resample", "cubes.vtk", "--size=8", "--max-error=1e-30", "-o", "grid.rho", cwd=folder)
    with pytest.raises(rr.Error) as caught:
        rr.resample("cubes.vtk", "grid.rho", size=8, max_error=1e-30, replace=True)
    assert (caught.value.code, caught.value.fact, caught.value.hint) == (code, fact, hint) and code == 6
    assert rr.open("grid.rho").kind == "grid"
    with pytest.raises(rr.Error, match=r"1e-30 was requested[^\n]*\nhint: path="):
        rr.resample("cubes.vtk", size=8, max_error=1e-30)


# ---- tetrahedralize ------------------------------------------------------------------------------

def test_meshes_are_those_of_the_program(folder):
    report = printed("tetrahedralize", "cube.ply", "--max-volume=0.001", "-o", "cube.vtu", cwd=folder)
    expected = pathlib.Path("cube.vtu").read_bytes()
    mesh = rr.tetrahedralize("cube.ply", path="cube.vtu", max_volume=0.001, replace=True)
    assert pathlib.Path("cube.vtu").read_bytes() == expected
    assert without_measured(mesh.report) == without_measured(report)
    packed = rr.tetrahedralize(pathlib.Path("cube.ply"), path="cube.rho", max_volume=0.001)
    temporary = rr.tetrahedralize("cube.ply", max_volume=0.001)
    assert packed.path == str(folder / "cube.rho") and packed.report["file"] == "cube.rho"
    assert temporary.report == {**temporary.report, "cells": report["cells"], "file": temporary.path}
    for data in (packed, temporary):
        assert data.kind == "tetrahedra"
        assert all(numpy.array_equal(data.array(name), mesh.array(name)) for name in mesh.array_names if name[0] != "_")


def test_surfaces_in_memory_keep_their_coordinates():
    mesh = rr.tetrahedralize(rr.surface(CUBE, SIDES))
    assert rr.info(mesh)["origin"] == [0, 0, 0]
    assert set(map(tuple, CUBE.tolist())) <= set(map(tuple, mesh.array("points").tolist()))


def test_regions_have_their_volumes(folder):
    inner = rr.surface((CUBE - 0.2) / 3 + 0.2, SIDES)
    mesh = rr.tetrahedralize("cube.ply", inner, max_volume={1: 1e-3, 2: 1e-5})
    assert mesh.report["cells"] < rr.tetrahedralize("cube.ply", inner, max_volume=1e-5).report["cells"] / 2
    plain = rr.tetrahedralize("cube.ply", inner, regions=False)
    assert mesh.fields["region"].range == (1, 2) and "region" not in plain.fields
    assert mesh.report["cells"] > plain.report["cells"] + (1 / 9) ** 3 / 1e-5
    hollow = rr.tetrahedralize("cube.ply", inner, cavities=True)
    assert not rr.trace(hollow.boundary(), [[0.2, 0.2, 0.2]], [[0, 0, 1]]).t[0] > 0.1


def test_faulty_surfaces_are_refused_with_a_file_of_their_facets(folder):
    code, fact, hint = refused("tetrahedralize", "open.ply", "-o", "open.vtu", cwd=folder)
    faults = pathlib.Path("open.faults.ply").read_bytes()
    with pytest.raises(rr.FileError) as caught:
        rr.tetrahedralize("open.ply", path="open.vtu", replace=True)
    assert (caught.value.code, caught.value.fact, caught.value.hint) == (code, fact, hint)
    with pytest.raises(rr.FileError) as caught:
        rr.tetrahedralize("open.ply")
    kept = pathlib.Path(caught.value.fact.rpartition(" are in ")[2])
    assert kept.read_bytes() == faults
    mended = rr.tetrahedralize("open.ply", repair=True)
    assert mended.report["repair"]["filled_holes"] == 1


@pytest.mark.parametrize("call, words", [
    (lambda box: rr.tetrahedralize(box), "found tetrahedra; expected triangles"),
    (lambda box: rr.tetrahedralize(box.boundary()), "boundary of a mesh"),
    (lambda box: rr.info(box.boundary()), "boundary of a mesh"),
    (lambda box: rr.info(rr.open("box.rho").boundary()), "boundary of a mesh"),
    (lambda box: rr.tetrahedralize("absent.ply", path="box.rho"), "box.rho already exists"),
    (lambda box: rr.tetrahedralize("absent.ply", path="none/box.rho"), "there is no folder none"),
    (lambda box: rr.tetrahedralize("cube.ply", path="box.txt"), "expected .vtu"),
    (lambda box: rr.tetrahedralize(), "no SURFACE"),
    (lambda box: rr.info("box.rho", output="x"), "unknown option output"),
    (lambda box: rr.info(box, progress=3), "progress: 3; expected None, True"),
])
def test_calls_that_make_no_sense_are_refused_with_a_sentence(folder, box, call, words):
    with pytest.raises(rr.UsageError, match=words):
        call(box)


# ---- validate, accuracy --------------------------------------------------------------------------

def test_validation_is_that_of_the_program(folder, box):
    words = ["--iso=1.5", "--samples=500", "--seed=3"]
    expected = without_measured(printed("validate", "box.rho", *words, "--field=u", cwd=folder))
    found = rr.validate("box.rho", 1.5, samples=500, seed=3, field="u")
    assert without_measured(found) == expected and found["holds"] is True
    in_memory = rr.validate(box, 1.5, samples=500, seed=3)
    assert in_memory["field"] == "u" and in_memory["rays"] == expected["rays"]
    assert rr.validate(rr.open("cubes.vtk").with_field("w"), 0.5, samples=10)["field"] == "w"
    outside = rr.validate(box, 1.5, samples=500, seed=3, max_depth_error=1e-30)
    assert outside["holds"] is False
    pathlib.Path("report").mkdir()
    pathlib.Path("report/report.txt").touch()
    with pytest.raises(rr.UsageError, match="already exists"):
        rr.validate("box.rho", 1.5, samples=10, report="report")
    rr.validate("box.rho", 1.5, samples=10, report="report", replace=True)
    assert "within the limits" in pathlib.Path("report/report.txt").read_text()


def test_accuracy_is_a_table_ready_for_plots(folder, ball):
    options = {"size": (64, 48), "time_limit": 5, "repeat": 1}
    found = rr.accuracy(ball, "results", iso=[3, 5], **options)
    columns = found.columns
    with open("results/results.csv", encoding="utf-8") as file:
        table = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert {len(column) for column in columns.values()} == {len(table)}
    assert columns["variant"].tolist() == [row["variant"] for row in table]
    assert columns["width"].tolist() == [64] * len(table)
    depth = [float(row["depth_median_cells"] or "nan") for row in table]
    assert columns["depth_median_cells"] == pytest.approx(depth, nan_ok=True) and numpy.isnan(depth).any()
    assert columns["front"].dtype == bool and columns["front"].any()
    assert set(columns["layer"]) == {f"isosurface {value} of 'distance'" for value in (3, 5)}
    assert found.units["cpu_ms"] == "ms" and found.meanings["variant"] == "variant that was drawn"
    with open("results/results.json", encoding="utf-8") as file:
        written = json.load(file)
    assert found.conclusions == written["conclusions"] and found.notes == written["notes"]
    assert found.facts == written["context"]
    assert found.report == "results/report.html" and pathlib.Path(found.report).exists()
    assert found.conclusions[0] in repr(found)


def test_accuracy_of_a_scene(folder, temporary_folder, ball):
    scene = {"data": {"head": {"file": "somewhere"}}, "layers": [{"type": "mip"}]}
    found = rr.accuracy(scene, data={"head": ball}, size="64x48", time_limit=5, repeat=1, max_error=0.01)
    assert found.report is None and found.facts["size"] == [64, 48]
    assert found.facts["input"] == "data in memory"
    assert "'distance'" in found.columns["layer"][0]
    assert any("would use" in note for note in found.notes)
    assert list(temporary_folder.iterdir()) == []
    pathlib.Path("scenes").mkdir()
    layer = {"type": "isosurface", "data": "head", "isovalue": "hihg"}
    pathlib.Path("scenes/scene.json").write_text(
        json.dumps({"data": {"head": {"file": "../ball.rho"}, "other": {"file": "../ball.rho"}}, "layers": [layer]}))
    for given in ({}, {"data": {"other": ball}}):
        with pytest.raises(rr.Error, match="/layers/0/isovalue: found \"hihg\""):
            rr.accuracy("scenes/scene.json", **given)


# ---- errors --------------------------------------------------------------------------------------

@pytest.mark.parametrize("call, words, error", [
    (lambda: rr.open("absent.nrrd"), ["pack", "absent.nrrd"], rr.FileError),
    (lambda: rr.info("absent.rho"), ["info", "absent.rho"], rr.FileError),
    (lambda: rr.pack("cubes.vtk", field="v", path="x.rho"), ["pack", "cubes.vtk", "--field=v", "-o", "x.rho"],
     rr.UsageError),
    (lambda: rr.pack("cubes.vtk", path="box.rho"), ["pack", "cubes.vtk", "-o", "box.rho"], rr.UsageError),
    (lambda: rr.validate("ball.rho", "p200"), ["validate", "ball.rho", "--iso=p200"], rr.UsageError),
    (lambda: rr.validate("ball.rho", 4, sample=3), ["validate", "ball.rho", "--iso=4", "--sample=3"], rr.UsageError),
    (lambda: rr.resample("cubes.vtk"), ["resample", "cubes.vtk"], rr.UsageError),
    (lambda: rr.resample("ball.rho", size=4), ["resample", "ball.rho", "--size=4"], rr.Error),
    (lambda: rr.accuracy("cube.ply", "out"), ["accuracy", "cube.ply", "-o", "out"], rr.UsageError),
    (lambda: rr.tetrahedralize("box.rho"), ["tetrahedralize", "box.rho"], rr.UsageError),
])
def test_errors_are_those_of_the_program(folder, call, words, error):
    code, fact, hint = refused(*words, cwd=folder)
    with pytest.raises(error) as caught:
        call()
    assert (caught.value.code, caught.value.fact, caught.value.hint) == (code, fact, hint)
    assert str(caught.value) == fact + (f"\nhint: {hint}" if hint else "")
    assert type(caught.value).__module__ == "rhoray"

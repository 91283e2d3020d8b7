"""Arrays to data, and data to arrays."""
import gc
import os
import pathlib
import subprocess
import sys
import threading

import numpy
import pytest
import rhoray as rr
from conftest import box_mesh, distance_samples


def test_a_volume_says_what_it_holds(ball):
    assert ball.kind == "grid"
    assert ball.length_unit == "mm"
    assert ball.bounds == ((0, 0, 0), (20, 16, 12))
    field = ball.field
    samples = distance_samples()
    assert (field.name, field.unit) == ("distance", "mm")
    assert field.range == (samples.min(), samples.max())
    assert field.histogram.sum() == samples.size


def test_a_contiguous_array_is_packed_without_a_copy(tmp_path):
    program = (
        "import numpy, resource, rhoray as rr\n"
        "rr.volume(numpy.zeros((8, 8, 8)))  # what the first call needs for itself\n"
        "values = numpy.ones((256, 512, 256), dtype=numpy.uint16)\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        f"rr.volume(values, path={str(tmp_path / 'v.rho')!r})\n"
        "more = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)\n"
        "assert more < 0.2 * values.nbytes, more\n")
    subprocess.run([sys.executable, "-c", program], check=True)


def test_axes_orders_and_memory_orders_mean_the_same():
    values = distance_samples()[:5, :6, :7].astype(numpy.float64)
    points = numpy.array([[1.0, 2.0, 3.0], [5.5, 4.25, 0.5]])
    expected, _ = rr.sample(rr.volume(values), points)
    strided = numpy.zeros((10, 12, 14))[::2, ::2, ::2]
    strided[...] = values
    reversed_view = numpy.ascontiguousarray(values[::-1, :, ::-1])[::-1, :, ::-1]
    for same in (numpy.asfortranarray(values), strided, reversed_view):
        assert numpy.array_equal(rr.sample(rr.volume(same), points)[0], expected)
    xyz = rr.volume(values.transpose(2, 1, 0), axes="xyz")
    assert numpy.array_equal(rr.sample(xyz, points)[0], expected)


@pytest.mark.parametrize("kind", ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"])
def test_every_element_type_is_taken(kind):
    values = numpy.arange(27).reshape(3, 3, 3).astype(kind)
    values_there, cells = rr.sample(rr.volume(values), [[1, 1, 1], [2, 0, 1]])
    assert values_there.tolist() == [13, 11]
    assert (cells < 8).all()


def test_affines_and_positions_place_samples():
    values = distance_samples()[:4, :5, :6]
    turned = numpy.array([[0, -2, 0, 10], [3, 0, 0, 20], [0, 0, -1, 30], [0, 0, 0, 1.0]])
    index = numpy.array([2.5, 1.25, 0.75, 1])
    at = (turned @ index)[:3]
    expected, _ = rr.sample(rr.volume(values), [index[:3]])
    found, _ = rr.sample(rr.volume(values, affine=turned), [at])
    assert found == pytest.approx(expected, rel=1e-12)  # two roundings of coordinates
    x, y, z = numpy.array([0, 1, 3, 4, 8, 9.0]), numpy.array([0, 2, 3, 5, 6.0]), numpy.array([-4, -1, 0, 7.0])
    uneven = rr.volume(values, positions=(x, y, z))
    assert uneven.bounds == ((0, 0, -4), (9, 6, 7))
    found, _ = rr.sample(uneven, [[x[3], y[1], z[2]]])
    assert found[0] == values[2, 1, 3]


def test_arrays_of_files_are_read_only_views_that_outlive_everything(tmp_path):
    path = tmp_path / "box.rho"
    points, cells, values = box_mesh()
    rr.pack(points, cells, {"u": values}, path=path)
    data = rr.open(path)
    names = data.array_names
    arrays = {name: data.array(name) for name in names}
    copies = {name: array.copy() for name, array in arrays.items()}
    assert not any(array.flags.writeable for array in arrays.values())
    assert not any(array.flags.owndata for array in arrays.values())
    del data
    path.unlink()
    gc.collect()
    for name in names:
        assert numpy.array_equal(arrays[name], copies[name])
    with pytest.raises(ValueError):
        arrays[names[0]][...] = 0


def test_saved_data_are_those_of_a_packed_file(tmp_path, box):
    box.save(tmp_path / "saved.rho")
    points, cells, values = box_mesh()
    region = (points[cells].mean(axis=1)[:, 0] > 0.5).astype(numpy.int32)
    rr.mesh(points, cells, {"u": values}, {"region": region}, path=tmp_path / "packed.rho")
    assert (tmp_path / "saved.rho").read_bytes() == (tmp_path / "packed.rho").read_bytes()
    assert rr.open(tmp_path / "saved.rho").damaged_blocks() == []
    with pytest.raises(rr.UsageError, match="already exists|exists"):
        box.save(tmp_path / "saved.rho")
    box.save(tmp_path / "saved.rho", replace=True)


def test_data_of_files_are_saved_as_those_in_memory_are(tmp_path, box):
    distance_samples().tofile(tmp_path / "ball.raw")
    raw = {"raw": "41x33x25:float32"}
    kept, temporary = rr.pack(tmp_path / "ball.raw", path=tmp_path / "kept.rho", **raw), rr.open(tmp_path / "ball.raw", **raw)
    errors = []
    for data in (kept, temporary):
        data.save(tmp_path / "saved.rho", replace=True)
        assert rr.open(tmp_path / "saved.rho").damaged_blocks() == []
        assert (tmp_path / "saved.rho").read_bytes() == pathlib.Path(data.path).read_bytes()
    for data in (kept, temporary, box):
        for path in (tmp_path / "saved.rho", tmp_path / "no" / "folder.rho", tmp_path, "/proc/saved.rho"):
            with pytest.raises(rr.Error) as refused:
                data.save(path)
            errors.append(str(refused.value))
    assert errors[:4] == errors[4:8] == errors[8:]
    assert not any("force" in error for error in errors)
    with pytest.raises(rr.UsageError, match="this is the boundary of a mesh"):
        box.boundary().save(tmp_path / "boundary.rho")
    threads = [threading.Thread(target=temporary.save, args=(tmp_path / f"{i % 2}.rho", True)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0.rho", "1.rho", "ball.raw", "kept.rho", "saved.rho"]


def test_opening_and_closing_keeps_no_memory(tmp_path):
    rr.pack(distance_samples(), path=tmp_path / "a.rho")
    for _ in range(300):
        array = rr.open(tmp_path / "a.rho").array(rr.open(tmp_path / "a.rho").array_names[0])
    assert array.size > 0


def test_progress_is_told_and_its_exceptions_end_the_work(tmp_path):
    phases = []
    rr.volume(distance_samples(), progress=lambda phase, done, total: phases.append((phase, done, total)))
    assert phases and all(isinstance(phase, str) for phase, _, _ in phases)

    def fail(phase, done, total):
        raise RuntimeError("enough")
    with pytest.raises(RuntimeError, match="enough"):
        rr.pack(distance_samples(), path=tmp_path / "never.rho", progress=fail)
    assert list(tmp_path.iterdir()) == []


def test_labels_and_boundaries_of_meshes(box):
    assert box.kind == "tetrahedra"
    assert box.fields["region"].of_cells
    assert box.boundary().kind == "triangles"
    half = box.boundary("region", 1)
    hits = rr.trace(half, [[0.2, 0.4, 5], [0.8, 0.4, 5]], [[0, 0, -1], [0, 0, -1]])
    assert hits.t.tolist() == [numpy.inf, 4]


@pytest.mark.parametrize("call, error, words", [
    (lambda: rr.volume(numpy.zeros((2, 2))), rr.UsageError, "three axes"),
    (lambda: rr.volume(numpy.zeros((1, 2, 2))), rr.UsageError, "at least 2"),
    (lambda: rr.volume(numpy.zeros((0, 2, 2))), rr.UsageError, "expected at least 2"),
    (lambda: rr.volume({}), rr.UsageError, "at least one"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2), dtype=object)), TypeError, "object"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2), dtype=bool)), TypeError, "bool"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2), dtype=complex)), TypeError, "complex"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2), dtype=">f4")), TypeError, "big-endian"),
    (lambda: rr.volume(numpy.ma.masked_less(numpy.zeros((2, 2, 2)), 1)), TypeError, "masked"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2)), spacing=(1, 0, 1)), rr.UsageError, "above 0"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2)), origin=(1, numpy.nan, 1)), rr.UsageError, "finite"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2)), axes="xzy"), rr.UsageError, "xzy"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2)), affine=numpy.zeros((3, 3))), rr.UsageError, "4 x 4"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2)), positions=([0, 1], [0, 1], [1, 1])), rr.UsageError, "rising"),
    (lambda: rr.mesh(numpy.zeros((4, 2)), [[0, 1, 2, 3]]), (rr.UsageError, TypeError), ""),
    (lambda: rr.mesh(numpy.eye(4)[:, :3], numpy.array([[0, 1, 2, 4]])), rr.UsageError, "index of 4 points"),
    (lambda: rr.mesh(numpy.eye(4)[:, :3], numpy.array([[0, 1, 2, -1]])), rr.UsageError, "found -1"),
    (lambda: rr.mesh(numpy.eye(4)[:, :3], numpy.array([[0, 1, 2, 3.0]])), rr.UsageError, "integers"),
    (lambda: rr.mesh(numpy.full((4, 3), numpy.nan), numpy.array([[0, 1, 2, 3]])), rr.UsageError, "finite"),
    (lambda: rr.mesh(numpy.eye(4)[:, :3], [[0, 1, 2, 3]], numpy.arange(4.0)), rr.UsageError, "point_fields: .*dict"),
    (lambda: rr.mesh(numpy.eye(4)[:, :3], [[0, 1, 2, 3]], {}, [1.0]), rr.UsageError, "cell_fields: .*dict"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2), dtype=">f4")), TypeError, r"use a\.astype\(a\.dtype\.newbyteorder"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2)), affine=numpy.eye(4), spacing=(1, 1, 2)), rr.UsageError, "spacing"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2)), affine=numpy.eye(4), positions=[[0, 1]] * 3), rr.UsageError, "affine"),
    (lambda: rr.volume(numpy.zeros((2, 2, 2)), positions=[[0, 1]] * 3, origin=(0, 0, 0)), rr.UsageError, "origin"),
    (lambda: rr.open("/nonexistent.rho"), rr.FileError, "nonexistent"),
])
def test_bad_arrays_are_refused_with_a_sentence(call, error, words):
    with pytest.raises(error, match=words):
        call()


def test_meshes_and_surfaces_are_made_of_lists_and_integers():
    points, tetrahedra = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]], [[0, 1, 2, 3]]
    for one in (points, numpy.array(points, numpy.int16), numpy.array(points, numpy.float32)):
        mesh = rr.mesh(one, tetrahedra, {"u": [0, 1, 2, 3]})
        assert mesh.bounds == ((0, 0, 0), (2, 2, 2)) and mesh.field.range == (0, 3)
        assert rr.surface(one, [[0, 1, 2]]).bounds == ((0, 0, 0), (2, 2, 0))


def test_files_may_have_names_that_are_not_utf_8(ball, tmp_path):
    path = os.path.join(tmp_path, os.fsdecode(b"b\xff.rho"))
    ball.save(path)
    data = rr.open(path)
    assert data.path == path
    assert numpy.array_equal(rr.render(data, iso=4, size=(20, 15)).rgba, rr.render(ball, iso=4, size=(20, 15)).rgba)
    assert rr.info(data)["kind"] == "grid"
    for call in (lambda: ball.save(path), lambda: rr.open(path, field="q"), lambda: rr.open(path + ".rho"),
                 lambda: rr.view(data, iso=4, browser=False)):
        with pytest.raises(rr.Error, match="b\N{REPLACEMENT CHARACTER}|UTF-8"):
            call()


def test_unknown_names_are_refused_with_those_that_exist(ball):
    with pytest.raises(rr.UsageError, match="'distance'|distance"):
        ball.with_field("distanze")
    with pytest.raises(rr.UsageError, match="no array 'x'"):
        ball.array("x")


def test_arrays_come_out_as_they_went_in(ball, box):
    samples, = ball.unpack()
    assert samples["distance"].dtype == numpy.float32
    assert numpy.array_equal(samples["distance"], distance_samples())
    assert ball.array("samples").ndim == 7  # of superbricks, bricks and samples
    two = rr.volume({"a": numpy.arange(60, dtype=numpy.int16).reshape(3, 4, 5), "b": numpy.ones((3, 4, 5))})
    assert {name: values.dtype.str for name, values in two.unpack()[0].items()} == {"a": "<i2", "b": "<f8"}

    points, cells, fields, fields_of_cells = box.unpack()
    expected_points, expected_cells, values = box_mesh()
    assert numpy.array_equal(points, expected_points) and numpy.array_equal(cells, expected_cells)
    assert numpy.array_equal(fields["u"], values)
    middles = points[cells].mean(axis=1)
    assert numpy.array_equal(fields_of_cells["region"], middles[:, 0] > 0.5)
    assert numpy.array_equal(rr.sample(box, middles)[1], numpy.arange(len(cells)))
    again = rr.mesh(points, cells, fields, fields_of_cells)
    assert numpy.array_equal(rr.render(again, iso=2).rgba, rr.render(box, iso=2).rgba)

    triangle = rr.surface(numpy.eye(3), numpy.array([[0, 1, 2]]))
    points, triangles = triangle.unpack()
    assert numpy.array_equal(points, numpy.eye(3)) and triangles.tolist() == [[0, 1, 2]]
    with pytest.raises(rr.UsageError, match="boundary"):
        box.boundary().unpack()

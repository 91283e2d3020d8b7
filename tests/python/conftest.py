"""Data that the tests share: small, made here, with known answers."""
import signal
import tempfile

import numpy
import pytest
import rhoray as rr

# Python that is started in the background of a script ignores Ctrl+C; the tests send it.
signal.signal(signal.SIGINT, signal.default_int_handler)

CENTRE = numpy.array([10.0, 8.0, 6.0])


def distance_samples():
    """values[k, j, i]: distance from CENTRE at (0.5 i, 0.5 j, 0.5 k)."""
    k, j, i = numpy.mgrid[0:25, 0:33, 0:41]
    at = 0.5 * numpy.stack([i, j, k], axis=-1)
    return numpy.linalg.norm(at - CENTRE, axis=-1).astype(numpy.float32)


@pytest.fixture
def temporary_folder(tmp_path, monkeypatch):
    """The folder of the module's temporary files during a test."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture(scope="session")
def ball():
    return rr.volume({"distance": distance_samples()}, spacing=(0.5, 0.5, 0.5), length_unit="mm",
                     units={"distance": "mm"})


def box_mesh(count=4):
    """A box of count^3 cubes, six tetrahedra each; the field is 2 x + 3 y - z."""
    axis = numpy.linspace(0, 1, count + 1)
    z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij")
    points = numpy.stack([x.ravel(), y.ravel(), z.ravel()], axis=-1)

    def index(i, j, k):
        return (k * (count + 1) + j) * (count + 1) + i
    cells = []
    for k in range(count):
        for j in range(count):
            for i in range(count):
                corner = [index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1)) for c in range(8)]
                for a, b in ((1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1)):
                    cells.append([corner[0], corner[a], corner[b], corner[7]])
    return points, numpy.array(cells), points @ numpy.array([2.0, 3.0, -1.0])


@pytest.fixture(scope="session")
def box():
    points, cells, values = box_mesh()
    region = (points[cells].mean(axis=1)[:, 0] > 0.5).astype(numpy.int32)
    return rr.mesh(points, cells, {"u": values}, {"region": region})

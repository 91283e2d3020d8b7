"""Objects of other libraries: each is taken as what it says of itself."""
import numpy
import pytest
import rhoray as rr
from conftest import box_mesh, distance_samples

SAMPLES = distance_samples()[:6, :7, :8].copy()
INDEX = numpy.array([2.5, 3.25, 1.75])  # x, y, z


@pytest.fixture(scope="module")
def expected():
    return rr.sample(rr.volume(SAMPLES), [INDEX])[0][0]


def test_xarray(expected):
    xarray = pytest.importorskip("xarray")
    array = xarray.DataArray(SAMPLES.transpose(2, 0, 1)[::-1], dims=("x", "z", "y"), name="distance",
                             coords={"x": 10 + 2.0 * numpy.arange(8)[::-1], "y": numpy.arange(7) ** 1.5,
                                     "z": numpy.arange(6.0)}, attrs={"units": "mm"})
    array.x.attrs["units"] = "cm"
    data = rr.pack(array)
    assert (data.field.name, data.field.unit, data.length_unit) == ("distance", "mm", "cm")
    at = [10 + 2 * INDEX[0], 3 ** 1.5 + 0.25 * (4 ** 1.5 - 3 ** 1.5), INDEX[2]]
    assert rr.sample(data, [at])[0][0] == pytest.approx(expected, rel=1e-12)
    with pytest.raises(rr.UsageError, match="time, x, y"):
        rr.pack(xarray.DataArray(SAMPLES, dims=("time", "x", "y")))


def test_nibabel(expected):
    nibabel = pytest.importorskip("nibabel")
    affine = numpy.array([[-2, 0, 0, 90], [0, 0, 3, -20], [0, 1.5, 0, 7], [0, 0, 0, 1.0]])
    data = rr.pack(nibabel.Nifti1Image(SAMPLES.transpose(2, 1, 0), affine))
    at = (affine @ [*INDEX, 1])[:3]
    assert rr.sample(data, [at])[0][0] == pytest.approx(expected, rel=1e-6)  # affines are single precision there
    assert data.length_unit == "mm"


def test_images_like_those_of_simpleitk(expected):
    class Image:
        def GetSpacing(self):
            return 2.0, 3.0, 4.0

        def GetOrigin(self):
            return 5.0, 6.0, 7.0

        def GetDirection(self):
            return 0, -1, 0, 1, 0, 0, 0, 0, 1
    import sys
    sys.modules[Image.__module__].GetArrayViewFromImage = lambda image: SAMPLES
    x, y, z = INDEX * [2, 3, 4]
    lps = numpy.array([5 - y, 6 + x, 7 + z])
    assert rr.sample(rr.pack(Image()), [lps * [-1, -1, 1]])[0][0] == pytest.approx(expected, rel=1e-12)


def test_meshio_there_and_back(tmp_path):
    meshio = pytest.importorskip("meshio")
    points, cells, values = box_mesh(2)
    region = numpy.arange(len(cells)) % 3
    mesh = meshio.Mesh(points, [("tetra", cells)], {"u": values, "v": numpy.zeros((len(points), 3))}, {"r": [region]})
    data = rr.pack(mesh)
    assert {name: field.of_cells for name, field in data.fields.items()} == {"u": False, "r": True}
    assert rr.sample(data, [[0.3, 0.6, 0.2]])[0][0] == pytest.approx(2 * 0.3 + 3 * 0.6 - 0.2)
    assert rr.pack(meshio.Mesh(points, [("triangle", cells[:, :3])])).kind == "triangles"
    with pytest.raises(rr.UsageError, match="hexahedron"):
        rr.pack(meshio.Mesh(points, [("hexahedron", [[0, 1, 4, 3, 9, 10, 13, 12]])]))
    # Back: the arrays of the packed file make the same mesh.
    back = meshio.Mesh(points, [("tetra", cells)], {"u": rr.sample(data, points)[0]})
    back.write(tmp_path / "back.vtu")
    assert numpy.allclose(meshio.read(tmp_path / "back.vtu").point_data["u"], values)


def test_vtk(expected):
    pytest.importorskip("vtkmodules")
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkImageData, vtkRectilinearGrid, vtkUnstructuredGrid
    image = vtkImageData()
    image.SetDimensions(8, 7, 6)
    image.SetSpacing(2, 3, 4)
    image.SetOrigin(-1, -2, -3)
    samples = numpy_to_vtk(SAMPLES.ravel(), deep=True)
    samples.SetName("distance")
    image.GetPointData().AddArray(samples)
    data = rr.pack(image)
    assert data.field.name == "distance"
    assert rr.sample(data, [INDEX * [2, 3, 4] - [1, 2, 3]])[0][0] == pytest.approx(expected, rel=1e-12)
    rectilinear = vtkRectilinearGrid()
    rectilinear.SetDimensions(8, 7, 6)
    for axis, count in (("X", 8), ("Y", 7), ("Z", 6)):
        getattr(rectilinear, f"Set{axis}Coordinates")(numpy_to_vtk(numpy.arange(count) ** 2.0, deep=True))
    rectilinear.GetPointData().AddArray(samples)
    at = numpy.floor(INDEX) ** 2 + (INDEX % 1) * (numpy.ceil(INDEX) ** 2 - numpy.floor(INDEX) ** 2)
    assert rr.sample(rr.pack(rectilinear), [at])[0][0] == pytest.approx(expected, rel=1e-12)
    points, cells, values = box_mesh(2)
    grid, corners, cell_array = vtkUnstructuredGrid(), vtkPoints(), vtkCellArray()
    corners.SetData(numpy_to_vtk(points, deep=True))
    cell_array.SetData(4, numpy_to_vtkIdTypeArray(cells.astype(numpy.int64).ravel(), deep=True))
    grid.SetPoints(corners)
    grid.SetCells(10, cell_array)
    u = numpy_to_vtk(values, deep=True)
    u.SetName("u")
    grid.GetPointData().AddArray(u)
    assert rr.sample(rr.pack(grid), [[0.3, 0.6, 0.2]])[0][0] == pytest.approx(2 * 0.3 + 3 * 0.6 - 0.2)
    # Back: a picture as image data.
    depth = rr.render(data, iso=11, size=(20, 10), channels=["depth"]).depth
    assert numpy_to_vtk(depth.ravel(), deep=True).GetNumberOfValues() == 200


def test_other_objects_are_refused():
    with pytest.raises(rr.UsageError, match="the type int; expected"):
        rr.pack(7)

"""What other libraries give and get: surfaces, tetrahedra, volumes, pictures and rays.

test_objects.py packs objects of meshio, nibabel, VTK and xarray. Here results of scipy, scikit-image and VTK become
data, and data become objects of all six. Their own interpolation, or the file that they write, must say the same.
"""
import numpy
import pytest
import rhoray as rr
import scipy.interpolate
import scipy.ndimage
import scipy.spatial
from conftest import CENTRE, box_mesh, distance_samples

SPACING = 0.5  # of the ball
ISO = 4
SINGLE = 2.0 ** -24  # relative rounding to single precision


def samples_of(data):
    """The samples of a grid as [k, j, i]. Packed files hold them in bricks; here they are sampled at their places."""
    facts = rr.info(data)
    geometry, shape = facts["geometry"], facts["samples"][::-1]
    steps = numpy.array(geometry["direction"]) * numpy.array(geometry["spacing"])[:, None]
    index = numpy.stack([axis.ravel() for axis in numpy.indices(shape)[::-1]], axis=-1)
    values, _ = rr.sample(data, numpy.array(geometry["origin"]) + index @ steps)
    return values.reshape(shape).astype(numpy.float32)  # as they were packed


def tetrahedra_of(mesh):
    """The tetrahedra of a mesh as [cells, 4] numbers of its points (formats/SPEC.md, 3.2)."""
    cluster = numpy.arange(mesh.array("cluster.corners").shape[0]) // rr.info(mesh)["clusters"]["size"]
    first = mesh.array("cluster.offsets")[cluster].astype(int)
    return mesh.array("cluster.vertices")[first[:, None] + mesh.array("cluster.corners")]


def of_source(mesh, name):
    """An array of cells in the order of the mesh that was packed, in which rays and points name cells."""
    values = numpy.empty(rr.info(mesh)["cells"])
    values[mesh.array("cell_ids")] = mesh.array(name)
    return values


def points_in(data, count, seed):
    low, high = numpy.array(data.bounds)
    return numpy.random.default_rng(seed).uniform(low, high, (count, 3))


def spread(count, seed):
    """Random directions of length 1."""
    directions = numpy.random.default_rng(seed).normal(size=(count, 3))
    return directions / numpy.linalg.norm(directions, axis=1, keepdims=True)


def test_samples_of_a_packed_grid_come_out(ball):
    assert numpy.array_equal(samples_of(ball), distance_samples())


# ---- scipy ---------------------------------------------------------------------------------------

@pytest.mark.parametrize("seed", range(12))
def test_any_grid_is_sampled_as_by_scipy(seed):
    random = numpy.random.default_rng(seed)
    shape = random.integers(2, 24, 3)
    kind = random.choice(["u1", "i2", "u4", "f4", "f8"])
    samples = (1000 * random.random(shape)).astype(kind) if kind != "u1" else random.integers(0, 256, shape, "u1")
    if seed % 2:
        spacing, origin = random.uniform(0.1, 3, 3), random.uniform(-100, 100, 3)
        axes = [origin[axis] + spacing[axis] * numpy.arange(count) for axis, count in enumerate(shape[::-1])]
        data = rr.volume(samples, spacing=spacing, origin=origin)
    else:
        axes = [numpy.cumsum(random.uniform(0.1, 3, count)) for count in shape[::-1]]
        data = rr.volume(samples, positions=axes)
    low, high = (numpy.array([axis[end] for axis in axes]) for end in (0, -1))
    inside = (high - low) * 1e-12  # a point on the outside may be outside by a rounding
    at = random.uniform(low + inside, high - inside, (2000, 3))
    at[:200, 0] = random.choice(axes[0][1:-1], 200) if len(axes[0]) > 2 else at[:200, 0]  # on faces of cells
    found, _ = rr.sample(data, at)
    linear = scipy.interpolate.RegularGridInterpolator(axes[::-1], samples.astype(float))
    # A position inside its cell has the rounding of a coordinate, relative to the narrowest cell;
    # the value has it times the largest step between samples, and the roundings of a sum of eight
    # terms.
    narrowest = min(numpy.diff(axis).min() for axis in axes)
    position = 4 * 2.0 ** -53 * max(abs(low).max(), abs(high).max()) / narrowest
    scale = numpy.abs(samples.astype(float)).max()
    assert numpy.abs(found - linear(at[:, ::-1])).max() <= scale * (6 * position + 16 * 2.0 ** -53)
    if seed % 2:
        index = ((at - low) / spacing)[:, ::-1].T
        mapped = scipy.ndimage.map_coordinates(samples.astype(float), index, order=1, mode="nearest")
        assert numpy.abs(found - mapped).max() <= scale * (6 * position + 16 * 2.0 ** -53)


@pytest.mark.parametrize("seed", range(4))
def test_delaunay_tetrahedra_are_interpolated_as_by_scipy(seed):
    random = numpy.random.default_rng(seed)
    points, values = random.random((300, 3)), random.random(300)
    delaunay = scipy.spatial.Delaunay(points)
    data = rr.mesh(points, delaunay.simplices, {"u": values})
    at = random.random((3000, 3))
    found, cells = rr.sample(data, at)
    expected = scipy.interpolate.LinearNDInterpolator(delaunay, values)(at)
    inside = numpy.isfinite(expected) & numpy.isfinite(found)
    # Both agree where the tetrahedra end, but for points within a rounding of the outside.
    assert inside.sum() > 2000 and (numpy.isfinite(expected) != numpy.isfinite(found)).sum() <= 3
    # Values up to 1, weighted by barycentric coordinates whose roundings grow as tetrahedra get
    # flat.
    flattest = numpy.abs(numpy.linalg.det(numpy.diff(points[delaunay.simplices[cells[inside]]], axis=1))).min()
    assert numpy.abs(found - expected)[inside].max() < 100 * 2.0 ** -53 / flattest


def test_hits_make_a_hull_of_scipy(ball):
    directions = spread(20_000, 1)
    hits = rr.trace(ball, numpy.tile(CENTRE, (20_000, 1)), directions, iso=ISO, accuracy="certified")
    hull = scipy.spatial.ConvexHull(CENTRE + hits.t[:, None] * directions)
    # Interpolation between samples of a distance, which is convex, adds at most h^2 / 8 times its
    # second derivatives. They are 2 / r together, and r is at least ISO less a diagonal in the
    # cells of the surface. So the surface is that much inside the ball at most. The hull of the
    # hits is a little smaller.
    shrunk = SPACING ** 2 / (4 * (ISO - 3 ** 0.5 * SPACING))
    assert (hits.t <= ISO + hits.error).all() and (hits.t >= ISO - shrunk - hits.error).all()
    assert 0.999 * (1 - shrunk / ISO) ** 3 < hull.volume / (4 / 3 * numpy.pi * ISO ** 3) < 1


# ---- scikit-image --------------------------------------------------------------------------------

def test_vertices_of_marching_cubes_are_on_the_traced_isosurface(ball):
    measure = pytest.importorskip("skimage.measure")
    index, triangles, _, _ = measure.marching_cubes(samples_of(ball), ISO)
    vertices = SPACING * index[:, ::-1].astype(float)
    # They are on edges of cells, where the trilinear field is linear, so they are on its
    # isosurface. Coordinates are below 64 samples and rounded to single precision. The field
    # changes by at most 1 per length.
    rounding = 64 * SINGLE * SPACING
    assert index.dtype == numpy.float32 and len(vertices) > 1000
    assert numpy.abs(rr.sample(ball, vertices)[0] - ISO).max() < rounding
    outwards = vertices - CENTRE
    length = numpy.linalg.norm(outwards, axis=1)
    hits = rr.trace(ball, numpy.tile(CENTRE, (len(vertices), 1)), outwards / length[:, None], iso=ISO,
                    accuracy="certified")
    assert numpy.abs(hits.t - length).max() < 2 * rounding  # along a ray, the field changes by at least 1/2 per length
    # The triangles are chords. An edge is at most a diagonal of a cell, and leaves the sphere by
    # its sagitta.
    surface = rr.surface(vertices, triangles)
    directions = spread(20_000, 2)
    flat, curved = (rr.trace(data, numpy.tile(CENTRE, (20_000, 1)), directions, **iso).t
                    for data, iso in ((surface, {}), (ball, {"iso": ISO})))
    assert numpy.abs(flat - curved).max() < 3 * SPACING ** 2 / (8 * ISO)


def test_a_picture_is_labelled(ball):
    measure = pytest.importorskip("skimage.measure")
    camera = {"position": CENTRE - [0, 40, 0], "target": CENTRE, "up": [0, 0, 1], "fov": 20}
    picture = rr.render(ball, iso=ISO, size=(160, 120), antialias=1, camera=camera, channels=["depth"])
    labels, count = measure.label(numpy.isfinite(picture.depth), return_num=True)
    (ball_there,) = measure.regionprops(labels)
    assert count == 1 and ball_there.area == picture.stats["hits"]
    # The camera looks at the centre of the ball, which is a circle there. Its rim is sampled by
    # pixels.
    assert numpy.allclose(ball_there.centroid, (59.5, 79.5), atol=0.1)
    radius = 60 * numpy.tan(numpy.arcsin(ISO / 40)) / numpy.tan(numpy.radians(10))  # pixels
    assert ball_there.equivalent_diameter == pytest.approx(2 * radius, rel=0.01) and ball_there.eccentricity < 0.1


# ---- VTK -----------------------------------------------------------------------------------------

def vtk_image(data, values):
    """Image data of VTK, with the samples [k, j, i] of a grid."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    image = vtkImageData()
    image.SetDimensions(values.shape[::-1])
    image.SetSpacing(SPACING, SPACING, SPACING)
    array = numpy_to_vtk(values.ravel(), deep=True)
    array.SetName(data.field.name)
    image.GetPointData().SetScalars(array)
    return image


def test_vtk_gets_a_volume_and_gives_its_contour(ball, tmp_path):
    pytest.importorskip("vtkmodules")
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkContourFilter, vtkProbeFilter
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
    image = vtk_image(ball, samples_of(ball))
    at = points_in(ball, 1000, 3)
    places, probe, where = vtkPoints(), vtkProbeFilter(), vtkPolyData()
    places.SetData(numpy_to_vtk(at, deep=True))
    where.SetPoints(places)
    probe.SetInputData(where)
    probe.SetSourceData(image)
    probe.Update()
    probed = vtk_to_numpy(probe.GetOutput().GetPointData().GetArray("distance"))
    assert numpy.abs(probed - rr.sample(ball, at)[0]).max() < 16 * SINGLE  # VTK keeps values below 16 in float32
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(str(tmp_path / "ball.vti"))
    writer.SetInputData(image)
    writer.Write()
    assert numpy.array_equal(samples_of(rr.open(tmp_path / "ball.vti")), distance_samples())
    contour = vtkContourFilter()
    contour.SetInputData(image)
    contour.SetValue(0, ISO)
    contour.Update()
    surface = rr.pack(contour.GetOutput())
    assert surface.kind == "triangles"
    vertices = surface.array("points").astype(float)
    assert len(vertices) > 1000 and numpy.abs(rr.sample(ball, vertices)[0] - ISO).max() < 64 * SINGLE * SPACING


# ---- meshio --------------------------------------------------------------------------------------

def test_meshio_writes_a_packed_mesh_that_is_read_again(box, tmp_path):
    meshio = pytest.importorskip("meshio")
    points, tetrahedra = box.array("points"), tetrahedra_of(box)
    mesh = meshio.Mesh(points, [("tetra", tetrahedra)], {"u": box.array("field.0")},
                       {"region": [box.array("cell_field.0")]})
    at = points_in(box, 1000, 4)
    for name, file_format in (("box.vtu", "vtu"), ("box.vtk", "vtk"), ("box.msh", "gmsh22")):
        mesh.write(tmp_path / name, file_format=file_format)
        again = rr.open(tmp_path / name)
        assert again.array("points").shape == points.shape and tetrahedra_of(again).shape == (len(box_mesh()[1]), 4)
        (values, cells), (expected, there) = rr.sample(again, at), rr.sample(box, at)
        assert numpy.array_equal(values, expected)
        assert numpy.array_equal(of_source(again, "cell_field.0")[cells], of_source(box, "cell_field.0")[there])


# ---- xarray and nibabel --------------------------------------------------------------------------

def test_xarray_gets_a_volume_and_a_picture(ball):
    xarray = pytest.importorskip("xarray")
    axes = {name: SPACING * numpy.arange(count) for name, count in zip("zyx", distance_samples().shape)}
    array = xarray.DataArray(samples_of(ball), dims=("z", "y", "x"), coords=axes, name="distance")
    at = points_in(ball, 1000, 5)
    rows = {name: xarray.DataArray(at[:, axis], dims="point") for axis, name in enumerate("xyz")}
    assert numpy.abs(array.astype(float).interp(rows).values - rr.sample(ball, at)[0]).max() < 1e-13 * 20
    again = rr.pack(array)
    assert again.bounds == ball.bounds
    assert numpy.array_equal(samples_of(again), distance_samples())
    picture = rr.render(ball, iso=ISO, size=(160, 120), channels=["depth", "value"])
    channels = xarray.Dataset({name: (("row", "column"), getattr(picture, name)) for name in ("depth", "value")})
    eye = numpy.array(picture.scene["camera"]["position"])
    expected = numpy.linalg.norm(eye - CENTRE) - ISO
    assert float(channels.depth.min()) == pytest.approx(expected, abs=SPACING ** 2 / ISO)
    assert float(channels.value.mean()) == ISO  # xarray leaves NaN out


def test_nibabel_writes_a_volume_that_is_read_again(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    affine = numpy.array([[-2, 0, 0, 90], [0, 0, 3, -20], [0, 1.5, 0, 7], [0, 0, 0, 1.0]])
    samples = distance_samples()[:14, :16, :21]
    turned = rr.volume({"distance": samples}, affine=affine, length_unit="mm")
    image = nibabel.Nifti1Image(samples_of(turned).transpose(2, 1, 0), affine)
    image.header.set_xyzt_units("mm")
    nibabel.save(image, tmp_path / "turned.nii.gz")
    again = rr.open(tmp_path / "turned.nii.gz")
    assert (again.bounds, again.length_unit) == (turned.bounds, "mm")
    assert numpy.array_equal(samples_of(again), samples)
    at = points_in(turned, 1000, 6)
    # Also nibabel's own map of the world to indices, with interpolation of scipy.
    index = nibabel.affines.apply_affine(numpy.linalg.inv(image.affine), at)
    mapped = scipy.ndimage.map_coordinates(image.get_fdata(), index.T, order=1)
    assert numpy.abs(rr.sample(again, at)[0] - mapped).max() < 1e-13 * 20

"""Rays and points, against numpy and scipy."""
import numpy
import pytest
import rhoray as rr
import scipy.interpolate
import scipy.ndimage
from conftest import CENTRE, box_mesh, distance_samples


def rays_to_ball(count, seed):
    random = numpy.random.default_rng(seed)
    origins = CENTRE + 30 * (lambda v: v / numpy.linalg.norm(v, axis=1, keepdims=True))(random.normal(size=(count, 3)))
    return origins, CENTRE + random.uniform(-3, 3, (count, 3)) - origins


def test_samples_are_those_of_scipy(ball):
    points = numpy.random.default_rng(2).uniform([0, 0, 0], [20, 16, 12], (2000, 3))
    values, cells = rr.sample(ball, points)
    expected = scipy.ndimage.map_coordinates(distance_samples().astype(float), (points[:, ::-1] / 0.5).T, order=1)
    # Both are trilinear in double precision; roundings of weights and of seven additions.
    assert numpy.abs(values - expected).max() < 1e-13 * 20
    assert (cells < 24 * 32 * 40).all()
    outside, none = rr.sample(ball, [[-1, 5, 5], [5, 5, 12.5]])
    assert numpy.isnan(outside).all() and (none == 2**64 - 1).all()


def test_samples_of_meshes_are_those_of_scipy():
    random = numpy.random.default_rng(3)
    points, cells, _ = box_mesh(3)
    values = random.random(len(points))
    at = random.uniform(0, 1, (1000, 3))
    found, ids = rr.sample(rr.mesh(points, cells, {"u": values}), at)
    corners = points[cells[ids]]
    weights = numpy.linalg.solve(numpy.concatenate([corners, numpy.ones((len(at), 4, 1))], axis=2).transpose(0, 2, 1),
                                 numpy.concatenate([at, numpy.ones((len(at), 1))], axis=1)[..., None])[..., 0]
    assert weights.min() > -1e-12  # each point is in its cell, up to rounding
    assert numpy.abs(found - (weights * values[cells[ids]]).sum(axis=1)).max() < 1e-12
    linear = scipy.interpolate.LinearNDInterpolator(points, points @ [1, 2, 3])
    found, _ = rr.sample(rr.mesh(points, cells, {"u": points @ [1.0, 2.0, 3.0]}), at)
    assert numpy.abs(found - linear(at)).max() < 1e-12


@pytest.mark.parametrize("accuracy", ["float", "double", "certified", "exact"])
def test_first_hits_are_on_the_surface(ball, accuracy):
    origins, directions = rays_to_ball(5000, 4)
    hits = rr.trace(ball, origins, directions, iso=4, accuracy=accuracy)
    at = origins[hits.is_hit] + hits.t[hits.is_hit, None] * directions[hits.is_hit]
    values, _ = rr.sample(ball, at)
    tolerance = {"float": 1e-4, "double": 1e-9, "certified": 2e-3, "exact": 1e-9}[accuracy]  # its promise, in cells
    assert numpy.abs(values - 4).max() < tolerance
    assert hits.is_hit.sum() > 4000
    assert (hits.error is not None) == (accuracy in ("certified", "exact"))
    if hits.error is not None:
        exact = rr.trace(ball, origins, directions, iso=4, accuracy="exact")
        assert numpy.array_equal(exact.is_hit, hits.is_hit)
        both = hits.is_hit
        assert (numpy.abs(hits.t[both] - exact.t[both]) <= (hits.error + exact.error)[both]).all()
    assert numpy.isnan(hits.value[~hits.is_hit]).all()
    assert numpy.array_equal(rr.trace(ball, origins, directions, iso=4, accuracy=accuracy, query="any"), hits.is_hit)


def test_gradients_are_those_of_the_field(box):
    origins = numpy.array([[0.3, 0.4, 5.0], [0.6, 0.2, 5.0]])
    hits = rr.trace(box, origins, numpy.array([[0, 0, -1.0], [0, 0, -2.0]]), iso=1.0)
    assert hits.gradient == pytest.approx(numpy.array([[2, 3, -1], [2, 3, -1]]), abs=1e-12)
    # 2 x + 3 y - z = 1 on the ray
    assert hits.t == pytest.approx([5 - (2 * 0.3 + 3 * 0.4 - 1), (5 - (2 * 0.6 + 3 * 0.2 - 1)) / 2], abs=1e-12)


def test_all_hits_are_in_order_and_start_with_the_first(ball):
    origins, directions = rays_to_ball(500, 5)
    found = rr.trace(ball, origins, directions, iso=4, query="all")
    exact = rr.trace(ball, origins, directions, iso=4, accuracy="exact")
    counts = numpy.diff(found.first.astype(int))
    assert numpy.array_equal(counts > 0, exact.is_hit)
    assert set(counts) <= {0, 2}  # in and out of the ball
    starts = found.first[:-1].astype(int)[counts > 0]
    assert numpy.array_equal(found.t[starts], exact.t[exact.is_hit])
    assert not found.enters[starts].any()  # inside the ball, distances are below the isovalue
    assert found.enters[starts + 1].all()
    assert (found.t[starts] < found.t[starts + 1]).all()
    one = rr.trace(ball, origins, directions, iso=4, query="all", max_hits=1)
    assert numpy.array_equal(one.truncated, counts > 1)


def test_largest_values_are_at_least_those_of_samples(ball):
    origins, directions = rays_to_ball(200, 6)
    hits = rr.trace(ball, origins, directions, query="largest")
    steps = numpy.linspace(0, 2, 400)
    points = origins[:, None] + steps[None, :, None] * directions[:, None]
    sampled = rr.sample(ball, points.reshape(-1, 3))[0].reshape(200, 400)
    assert (hits.value >= numpy.nanmax(sampled, axis=1) - 1e-12).all()
    at = rr.sample(ball, origins + hits.t[:, None] * directions)[0]
    inside = ~numpy.isnan(at)
    assert numpy.abs(at - hits.value)[inside].max() < 1e-9


def test_limits_and_types_of_arrays(ball):
    origins, directions = rays_to_ball(300, 7)
    hits = rr.trace(ball, origins, directions, iso=4)
    behind = rr.trace(ball, origins, directions, iso=4, t_min=numpy.where(hits.is_hit, hits.t + 1e-6, 0))
    assert (behind.t[hits.is_hit] > hits.t[hits.is_hit]).all()
    none = rr.trace(ball, origins, directions, iso=4, t_max=numpy.full(300, 0.1))
    assert not none.is_hit.any()
    single = rr.trace(ball, origins.astype("f4"), directions.astype("f4"), iso=4)
    widened = rr.trace(ball, origins.astype("f4").astype(float), directions.astype("f4").astype(float), iso=4)
    assert numpy.array_equal(single.t, widened.t)
    strided = rr.trace(ball, numpy.repeat(origins, 2, axis=0)[::2], directions[::-1][::-1], iso=4)
    assert numpy.array_equal(strided.t, hits.t)
    empty = rr.trace(ball, numpy.zeros((0, 3)), numpy.zeros((0, 3)), iso=4)
    assert empty.t.shape == (0,)


@pytest.mark.parametrize("options", [{"iso": 4}, {"iso": 4, "accuracy": "certified"}, {"query": "largest"},
                                     {"query": "largest", "accuracy": "exact"}])
def test_answers_overwrite_those_of_an_earlier_call(ball, options):
    earlier = rr.trace(ball, *rays_to_ball(700, 8), **options)
    arrays = {name: array for name, array in vars(earlier).items() if array is not None}
    rays = rays_to_ball(700, 9)
    expected = rr.trace(ball, *rays, **options)
    assert not any(numpy.array_equal(array, getattr(expected, name)) for name, array in arrays.items())
    assert rr.trace(ball, *rays, **options, out=earlier) is earlier
    for name, array in arrays.items():
        assert getattr(earlier, name) is array
        assert numpy.array_equal(array, getattr(expected, name), equal_nan=array.dtype.kind == "f"), name


def test_answers_are_written_into_arrays_of_the_caller(ball, tmp_path):
    rays = rays_to_ball(300, 10)
    expected = rr.trace(ball, *rays, iso=4)
    t = numpy.memmap(tmp_path / "t", float, "w+", shape=(300,))
    block = numpy.full((5, 300), 7.0)
    gradient = block[1:4].reshape(300, 3)
    hits = rr.Hits(t=t, value=block[0], cell=numpy.zeros(300, numpy.uint64), error=None, gradient=gradient)
    assert rr.trace(ball, *rays, iso=4, out=hits) is hits
    t.flush()
    assert numpy.array_equal(numpy.fromfile(tmp_path / "t"), expected.t)
    assert numpy.array_equal(block[0], expected.value, equal_nan=True)
    assert numpy.array_equal(block[1:4].reshape(300, 3), expected.gradient)
    assert (block[4] == 7).all()


RAYS = numpy.tile([10.0, 8.0, 30.0], (4, 1)), numpy.tile([0.0, 0.0, -1.0], (4, 1))
LONG = numpy.zeros(40)


def hits_with(**arrays):
    """Hits for four rays, as the query "first" makes them, with these arrays."""
    return rr.Hits(**{"t": numpy.zeros(4), "value": numpy.zeros(4), "cell": numpy.zeros(4, numpy.uint64), "error": None,
                      "gradient": numpy.zeros((4, 3)), **arrays})


@pytest.mark.parametrize("arrays, error, words", [
    ({"t": numpy.zeros(4, "f4")}, TypeError, "out.t: elements of the type float32; expected float64"),
    ({"t": numpy.zeros(4, ">f8")}, TypeError, "out.t: elements of the type >f8"),
    ({"cell": numpy.zeros(4, numpy.int64)}, TypeError, "out.cell: elements of the type int64; expected uint64"),
    ({"t": [0.0] * 4}, TypeError, "out.t: found list"),
    ({"value": None}, TypeError, "out.value: found None"),
    ({"value": numpy.ma.zeros(4)}, TypeError, "out.value: found MaskedArray"),
    ({"t": numpy.zeros(3)}, rr.UsageError, r"out.t: an array of the shape \(3,\); expected \(4,\)"),
    ({"gradient": numpy.zeros(12)}, rr.UsageError, "out.gradient: an array of the shape"),
    ({"error": numpy.zeros(4)}, rr.UsageError, "out.error: found an array; expected None"),
    ({"t": numpy.frombuffer(bytes(32))}, rr.UsageError, "out.t: a read-only array"),
    ({"t": numpy.zeros(8)[::2]}, rr.UsageError, "out.t: an array that is not contiguous"),
    ({"t": numpy.zeros(4)[::-1]}, rr.UsageError, "out.t: an array that is not contiguous"),
    ({"gradient": numpy.zeros((3, 4)).T}, rr.UsageError, "out.gradient: an array that is not contiguous"),
    ({"t": numpy.zeros(40, "u1")[1:33].view(float)}, rr.UsageError, "out.t: an array .* not aligned"),
    ({"t": LONG[10:14], "value": LONG[13:17]}, rr.UsageError, "out.value: shares memory with out.t"),
    ({"gradient": RAYS[0]}, rr.UsageError, "out.gradient: shares memory with origins"),
    ({"t": RAYS[1].ravel()[8:]}, rr.UsageError, "out.t: shares memory with directions"),
    ({"value": LONG[:4]}, rr.UsageError, "out.value: shares memory with t_min"),
])
def test_unfit_memory_for_answers_is_refused(ball, arrays, error, words):
    before = [array.copy() for array in RAYS]
    with pytest.raises(error, match=words):
        rr.trace(ball, *RAYS, iso=4, t_min=LONG[:4], out=hits_with(**arrays))
    assert all(numpy.array_equal(array, copy) for array, copy in zip(RAYS, before, strict=True))


@pytest.mark.parametrize("options, error, words", [
    ({"iso": 4, "out": (numpy.zeros(4), numpy.zeros(4))}, TypeError, "out: found tuple; expected Hits"),
    ({"iso": 4, "accuracy": "exact", "out": hits_with()}, TypeError, "out.error: found None"),
    ({"query": "largest", "out": hits_with()}, rr.UsageError, "out.gradient: .* this call has no gradient"),
    ({"iso": 4, "query": "any", "out": hits_with()}, rr.UsageError, "out has no effect on the query 'any'"),
    ({"iso": 4, "query": "all", "out": hits_with()}, rr.UsageError, "out has no effect on the query 'all'"),
])
def test_memory_for_answers_of_another_query_is_refused(ball, options, error, words):
    with pytest.raises(error, match=words):
        rr.trace(ball, *RAYS, **options)


@pytest.mark.parametrize("call, words", [
    (lambda ball: rr.trace(ball, numpy.zeros((2, 2)), numpy.ones((2, 3)), iso=4), "origins"),
    (lambda ball: rr.trace(ball, numpy.zeros((2, 3)), numpy.ones((1, 3)), iso=4), "directions"),
    (lambda ball: rr.trace(ball, numpy.zeros((1, 3)), numpy.zeros((1, 3)), iso=4), "direction"),
    (lambda ball: rr.trace(ball, numpy.full((1, 3), numpy.nan), numpy.ones((1, 3)), iso=4), "finite"),
    (lambda ball: rr.trace(ball, numpy.zeros((1, 3)), numpy.ones((1, 3))), "iso"),
    (lambda ball: rr.trace(ball, numpy.zeros((1, 3)), numpy.ones((1, 3)), iso=numpy.inf), "isovalue"),
    (lambda ball: rr.trace(ball, numpy.zeros((1, 3)), numpy.ones((1, 3)), iso=4, query="last"), "last"),
    (lambda ball: rr.trace(ball, numpy.zeros((1, 3)), numpy.ones((1, 3)), iso=4, t_min=[0, 1]), "t_min"),
    (lambda ball: rr.trace(ball, 1.0, numpy.ones((1, 3)), iso=4), "origins"),
    (lambda ball: rr.sample(ball, numpy.zeros((3,))), "points"),
    (lambda ball: rr.sample(ball, 1.0), "points"),
    (lambda ball: rr.sample(ball, [[0, numpy.inf, 0]]), "finite"),
])
def test_wrong_rays_are_refused_with_a_sentence(ball, call, words):
    with pytest.raises(rr.Error, match=words):
        call(ball)


@pytest.mark.parametrize("array, words", [
    (numpy.ma.masked_less(numpy.ones((1, 3)), 2), "a masked array"),
    (numpy.ma.masked_less(numpy.ones((1, 3), int), 2), "a masked array"),
    (numpy.ones((1, 3), object), "object"),
    (numpy.array([["1", "2", "3"]]), "<U1"),
    (numpy.ones((1, 3), complex), "complex128"),
    (numpy.ones((1, 3), "m8[s]"), "timedelta64"),
])
def test_rays_and_points_that_are_no_plain_numbers_are_refused(ball, array, words):
    plain = numpy.ones((1, 3))
    for name, call in (("points", lambda: rr.sample(ball, array)),
                       ("origins", lambda: rr.trace(ball, array, plain, iso=4)),
                       ("directions", lambda: rr.trace(ball, plain, array, iso=4)),
                       ("t_max", lambda: rr.trace(ball, plain, plain, iso=4, t_max=array[:, 0]))):
        with pytest.raises(TypeError, match=f"{name}: .*{words}"):
            call()
    for other in (plain.astype(bool), plain.astype(">f8").astype(numpy.float32), plain.astype(numpy.uint8)):
        assert numpy.array_equal(rr.sample(ball, other)[0], rr.sample(ball, plain)[0])

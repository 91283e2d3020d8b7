// Arrays that make no sense are refused with the argument's name, what was found and what was
// expected.
#include <gtest/gtest.h>

#include <limits>
#include <new>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/support/sanitizers.h"

namespace rhoray::tests {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t smallest = std::numeric_limits<std::int64_t>::min();

using Numbers = std::vector<std::int64_t>;

TEST(ArrayViews, describe_contiguous_values) {
  const std::vector<float> values(24);
  const ArrayView view(std::span<const float>(values), {2, 3, 4});
  EXPECT_EQ(view.count(), 24);
  EXPECT_EQ(Numbers(view.strides_bytes().begin(), view.strides_bytes().end()), (Numbers{48, 16, 4}));
  EXPECT_EQ(view.type(), ElementType::F32);
  EXPECT_EQ(ArrayView(std::span<const float>(values)).shape()[0], 24);
  EXPECT_FALSE(ArrayView().is_given());
  EXPECT_EQ(ArrayView().count(), 0);
  const std::span<const double> empty;
  EXPECT_EQ(ArrayView(empty, {0, 3}).count(), 0);
  EXPECT_EQ(ArrayView(empty, {largest, 0, largest}).count(), 0) << "no stride overflows";
}

TEST(ArrayViews, refuse_shapes_that_do_not_fit_their_values) {
  const std::vector<float> values(24);
  const std::span<const float> all(values);
  const auto refuse = [](const std::string& words, const auto& act) { expect_refused(ErrorCode::usage, words, act); };
  refuse("an array of 24 elements with the shape [5, 5]", [&] { ArrayView(all, {5, 5}); });
  refuse("an array of the shape [-2, -12]", [&] { ArrayView(all, {-2, -12}); });
  refuse("an array of 9 axes; expected at most 8", [&] { ArrayView(all, {1, 1, 1, 1, 1, 1, 1, 1, 24}); });
  refuse("expected sizes whose product is their number", [&] { ArrayView(all, {largest, largest}); });
  refuse("an array of 3 elements at a null pointer",
         [] { ArrayView(std::span<const float>(static_cast<float*>(nullptr), 3)); });
}

TEST(ArrayViews, refuse_strides_that_overflow) {
  const float value = 0;
  const auto refuse = [&](const std::string& words, const Numbers& shape, const Numbers& strides, const void* first) {
    expect_refused(ErrorCode::usage, words, [&] { ArrayView(first, ElementType::F32, shape, strides); });
  };
  refuse("an array of 2 axes and 1 strides; expected as many", {1, 1}, {4}, &value);
  refuse("an array of 9 axes", {1, 1, 1, 1, 1, 1, 1, 1, 1}, {4, 4, 4, 4, 4, 4, 4, 4, 4}, &value);
  refuse("an array of the shape [-1]; expected sizes from 0 up", {-1}, {4}, &value);
  refuse("an array of 2 elements at a null pointer", {2}, {4}, nullptr);
  const std::string most = "expected at most 9223372036854775807 bytes";
  refuse(most, {largest, 2}, {0, 0}, &value);
  refuse(most, {2}, {largest}, &value);
  refuse(most, {2}, {smallest}, &value);
  refuse(most, {3, 3}, {largest / 4, largest / 3}, &value);
  refuse(most, {2, 2}, {-largest / 2, -largest / 2 - 8}, &value);
  // One value that is repeated: the array is small, but a copy of it would not be.
  refuse(most, {largest / 4, 2}, {0, 0}, &value);
  refuse(most, {largest / 4 + 1}, {0}, &value);
  const Numbers shape{2, 2}, strides{0, -4};
  EXPECT_EQ(ArrayView(&value, ElementType::F32, shape, strides).count(), 4);
}

TEST(ArrayViews, refuse_a_number_that_is_no_type) {
  const float value = 0;
  const Numbers one{1}, stride{4};
  expect_refused(ErrorCode::usage, "ElementType: found 10; expected a number from 0 to 9",
                 [&] { ArrayView(&value, static_cast<ElementType>(10), one, stride); });
}

/// A view of one value that is repeated may describe more than memory can hold.
ArrayView repeated(const Numbers& shape) {
  static constexpr float value = 1;
  return {&value, ElementType::F32, shape, Numbers(shape.size(), 0)};
}
constexpr std::int64_t many = std::int64_t{1} << 59;

TEST(LargeArrays, of_a_repeated_value_find_no_memory) {
  if (sanitized) GTEST_SKIP() << no_limits_of_memory;
  EXPECT_THROW(pack(GridArrays{.fields = {{.name = "f", .values = repeated({many / 4, 2, 2})}}}, AxisOrder::zyx),
               std::bad_alloc);
  EXPECT_THROW(pack(SurfaceArrays{.points = repeated({many, 3}), .triangles = {}}), std::bad_alloc);
  EXPECT_THROW(pack(SurfaceArrays{.points = repeated({many / 8, 3}), .triangles = {}}), std::bad_alloc);
}

TEST(LargeArrays, are_not_copied_by_a_call_that_was_stopped_before) {
  std::stop_source stop;
  stop.request_stop();
  const PackOptions stopped{.watch = stop.get_token()};
  expect_refused(ErrorCode::interrupted, "interrupted", [&] {
    pack(SurfaceArrays{.points = repeated({many, 3}), .triangles = {}}, stopped);
  });
  expect_refused(ErrorCode::interrupted, "interrupted", [&] {
    pack(MeshArrays{.points = repeated({many, 3}), .tetrahedra = {}}, stopped);
  });
  expect_refused(ErrorCode::interrupted, "interrupted", [&] {
    pack(GridArrays{.fields = {{.name = "f", .values = repeated({many / 4, 2, 2})}}}, AxisOrder::zyx, stopped);
  });
}

/// A grid that is in order; each test spoils it in one way.
struct GoodGrid {
  Samples<float> samples = samples_of<float>(4, 3, 2, [](auto i, auto j, auto k) { return i + j * k; });
  GridArrays grid{.fields = {samples.field("f"), samples.field("g")}};

  void refuse(const std::string& words) const {
    expect_refused(ErrorCode::usage, words, [&] { pack(grid, AxisOrder::zyx); });
  }
};

template <class Spoil>
void refuse_grid(const std::string& words, const Spoil& spoil) {
  GoodGrid good;
  spoil(good.grid);
  good.refuse(words);
}

TEST(BadGrids, are_refused_with_numbers_that_are_no_enumerators) {
  const GoodGrid good;
  expect_refused(ErrorCode::usage, "AxisOrder: found 7; expected a number from 0 to 1",
                 [&] { pack(good.grid, static_cast<AxisOrder>(7)); });
  expect_refused(ErrorCode::usage, "PackOptions::memory: found 5; expected a number from 0 to 1",
                 [&] { pack(good.grid, AxisOrder::zyx, {.memory = static_cast<Memory>(5)}); });
}

TEST(BadGrids, are_refused_for_their_fields) {
  refuse_grid("GridArrays::fields: found none", [](GridArrays& grid) { grid.fields.clear(); });
  refuse_grid("GridArrays::fields[1].name: 'f' occurs twice", [](GridArrays& grid) { grid.fields[1].name = "f"; });
  refuse_grid("GridArrays::fields[0].name: is empty", [](GridArrays& grid) { grid.fields[0].name = ""; });
  refuse_grid("GridArrays::fields[0].values: not given", [](GridArrays& grid) {
    grid.fields.pop_back();
    grid.fields[0].values = {};
  });
  refuse_grid("GridArrays::fields[1].values: not given", [](GridArrays& grid) { grid.fields[1].values = {}; });
  const std::vector<float> values(24);
  const std::span<const float> all(values);
  refuse_grid("GridArrays::fields[1].values: an array of the shape [2, 4, 3]; expected [2, 3, 4]",
              [&](GridArrays& grid) {
                grid.fields[1].values = {all, {2, 4, 3}};
              });
  refuse_grid("GridArrays::fields[0].values: an array of the shape [24]; expected three axes",
              [&](GridArrays& grid) { grid.fields = {{.name = "f", .values = all}}; });
  refuse_grid("expected three axes", [&](GridArrays& grid) {
    grid.fields = {{.name = "f", .values = {all, {1, 2, 3, 4}}}};
  });
  refuse_grid("GridArrays::fields[0].values: 1 samples along y; expected at least 2", [&](GridArrays& grid) {
    grid.fields = {{.name = "f", .values = {all, {6, 1, 4}}}};
  });
  refuse_grid("0 samples along x", [&](GridArrays& grid) {
    grid.fields = {{.name = "f", .values = {std::span<const float>(), {2, 2, 0}}}};
  });
}

TEST(BadGrids, are_refused_for_their_positions) {
  for (const double step : {nan, infinite, 0.0, -1.0})
    refuse_grid("GridArrays::spacing: (", [&](GridArrays& grid) { grid.spacing.y = step; });
  for (const double place : {nan, infinite})
    refuse_grid("GridArrays: its position is not finite", [&](GridArrays& grid) { grid.origin.z = place; });
  refuse_grid("its position is not finite", [&](GridArrays& grid) {
    grid.world_from_grid = Affine{.y_axis = {0, nan, 0}};
  });
  refuse_grid("GridArrays::world_from_grid: a cell has the volume 0; expected independent axes", [&](GridArrays& grid) {
    grid.world_from_grid = Affine{.y_axis = {2, 0, 0}};
  });
  refuse_grid("expected independent axes", [&](GridArrays& grid) {
    grid.world_from_grid = Affine{.z_axis = {0, 0, 0}};
  });
  for (const double step : {1e-110, 1e150})
    refuse_grid("GridArrays::spacing: a cell has the volume", [&](GridArrays& grid) {
      grid.spacing = {step, step, step};
    });
  const std::array<std::vector<double>, 3> good{{{0, 1, 2, 3}, {0, 1, 2}, {0, 1}}};
  refuse_grid("GridArrays: positions and world_from_grid are both given", [&](GridArrays& grid) {
    grid.positions = good;
    grid.world_from_grid.emplace();
  });
  const auto along_y = [&](const std::string& words, const std::vector<double>& positions) {
    refuse_grid("GridArrays::positions[1]: " + words, [&](GridArrays& grid) {
      grid.positions = good;
      grid.positions[1] = positions;
    });
  };
  along_y("0 numbers; expected 3", {});
  along_y("2 numbers; expected 3", {0, 1});
  along_y("1 at index 2; expected finite, strictly rising numbers", {0, 1, 1});
  along_y("0 at index 1; expected finite, strictly rising numbers", {1, 0, 2});
  along_y("nan at index 0; expected finite", {nan, 0, 2});
  along_y("inf at index 2; expected finite", {0, 1, infinite});
}

TEST(BadGrids, are_refused_for_integers_that_no_double_holds) {
  for (const std::uint64_t value : {std::uint64_t{1} << 60 | 1, ~std::uint64_t{0}}) {
    const Samples<std::uint64_t> samples =
        samples_of<std::uint64_t>(2, 2, 2, [&](auto i, auto, auto) { return i == 1 ? value : 0; });
    expect_refused(ErrorCode::usage, "GridArrays::fields[0].values: sample (1, 0, 0) is ",
                   [&] { pack({.fields = {samples.field("f")}}, AxisOrder::zyx); });
  }
  const Samples<std::int64_t> samples = samples_of<std::int64_t>(
      2, 2, 2, [&](auto i, auto, auto) { return i == 1 ? -((std::int64_t{1} << 60) | 1) : 0; });
  expect_refused(ErrorCode::usage, "GridArrays::fields[0].values: sample (1, 0, 0) is ",
                 [&] { pack({.fields = {samples.field("f")}}, AxisOrder::zyx); });
  const Samples<std::uint64_t> exact =
      samples_of<std::uint64_t>(2, 2, 2, [](auto i, auto, auto) { return std::uint64_t{1} << (i == 1 ? 60 : 0); });
  EXPECT_EQ(pack({.fields = {exact.field("f")}}, AxisOrder::zyx).field().range, (Interval{1, 0x1p60}));
}

TEST(BadGrids, without_any_data_have_no_range_and_show_nothing) {
  const Samples<float> samples = samples_of<float>(3, 3, 3, [](auto, auto, auto) { return NAN; });
  const Dataset data = pack({.fields = {samples.field("f")}}, AxisOrder::zyx);
  EXPECT_EQ(data.field().range, std::nullopt);
  EXPECT_EQ(data.field().no_data_count, 27U);
  Scene scene{.layers = {{.data = data, .show = Isosurface{0}}}};
  scene.camera = fit_camera(scene, {8, 8});
  RenderContext context;
  Picture picture;
  EXPECT_EQ(context.render(scene, {.size = {8, 8}}, picture).statistics.hits, 0U);
}

/// A mesh that is in order.
struct GoodMesh {
  MadeMesh mesh = box_mesh(2);
  std::vector<double> values = mesh.point_values([](const Vec3& p) { return p.x; });
  std::vector<double> parts = std::vector<double>(static_cast<std::size_t>(mesh.cell_count()));
  MeshArrays arrays = mesh.arrays();

  GoodMesh() {
    arrays.point_fields = {{.name = "x", .values = std::span<const double>(values)}};
    arrays.cell_fields = {{.name = "part", .values = std::span<const double>(parts)}};
  }
};

/// @param spoil  (GoodMesh&): changes the arrays or what they show
template <class Spoil>
void refuse_mesh(const std::string& words, const Spoil& spoil) {
  GoodMesh good;
  spoil(good);
  expect_refused(ErrorCode::usage, words, [&] { pack(good.arrays); });
}

TEST(BadMeshes, are_refused_for_their_points) {
  refuse_mesh("MeshArrays::points: not given", [](GoodMesh& good) { good.arrays.points = {}; });
  const std::vector<double> numbers(81);
  const std::span<const double> all(numbers);
  refuse_mesh("MeshArrays::points: an array of the shape [81]; expected [n, 3]",
              [&](GoodMesh& good) { good.arrays.points = all; });
  refuse_mesh("an array of the shape [3, 27]; expected [n, 3]", [&](GoodMesh& good) {
    good.arrays.points = {all, {3, 27}};
  });
  const std::vector<std::int32_t> whole(81);
  refuse_mesh("MeshArrays::points: elements of the type I32; expected F32 or F64", [&](GoodMesh& good) {
    good.arrays.points = {std::span<const std::int32_t>(whole), {27, 3}};
  });
  for (const double bad : {nan, infinite, -infinite})
    refuse_mesh("MeshArrays::points: point 5 is (", [&](GoodMesh& good) { good.mesh.points[16] = bad; });
}

TEST(BadMeshes, are_refused_for_their_shape) {
  refuse_mesh("1e+101", [](GoodMesh& good) { good.mesh.points[16] = 1e101; });
  refuse_mesh("volume", [](GoodMesh& good) {
    for (std::size_t z = 2; z < good.mesh.points.size(); z += 3) good.mesh.points[z] = 0;
  });
}

TEST(BadMeshes, are_refused_for_their_cells) {
  refuse_mesh("MeshArrays::tetrahedra: not given", [](GoodMesh& good) { good.arrays.tetrahedra = {}; });
  refuse_mesh("MeshArrays::tetrahedra: found none", [](GoodMesh& good) {
    good.arrays.tetrahedra = {std::span<const int>(), {0, 4}};
  });
  refuse_mesh("MeshArrays::tetrahedra[2][1]: found -1; expected an index of 27 points",
              [](GoodMesh& good) { good.mesh.tetrahedra[9] = -1; });
  refuse_mesh("MeshArrays::tetrahedra[0][3]: found 27; expected an index of 27 points",
              [](GoodMesh& good) { good.mesh.tetrahedra[3] = 27; });
  refuse_mesh("found 9223372036854775807", [](GoodMesh& good) { good.mesh.tetrahedra[3] = largest; });
  const std::vector<std::uint64_t> huge(8, ~std::uint64_t{0});
  refuse_mesh("MeshArrays::tetrahedra[0][0]: found 18446744073709551615", [&](GoodMesh& good) {
    good.arrays.tetrahedra = {std::span<const std::uint64_t>(huge), {2, 4}};
  });
  refuse_mesh("MeshArrays::tetrahedra: an array of the shape [8]; expected [n, 4]",
              [&](GoodMesh& good) { good.arrays.tetrahedra = std::span<const std::uint64_t>(huge); });
  refuse_mesh("an array of the shape [4, 2]; expected [n, 4]", [&](GoodMesh& good) {
    good.arrays.tetrahedra = {std::span<const std::uint64_t>(huge), {4, 2}};
  });
  const std::vector<float> floats(8);
  refuse_mesh("MeshArrays::tetrahedra: floating-point numbers; expected integers", [&](GoodMesh& good) {
    good.arrays.tetrahedra = {std::span<const float>(floats), {2, 4}};
  });
}

TEST(BadMeshes, are_refused_for_their_fields) {
  refuse_mesh("MeshArrays::point_fields[0].values: an array of the shape [26]; expected [27]", [](GoodMesh& good) {
    good.arrays.point_fields[0].values = std::span(std::as_const(good.values)).first(26);
  });
  refuse_mesh("MeshArrays::cell_fields[0].values: not given",
              [](GoodMesh& good) { good.arrays.cell_fields[0].values = {}; });
  refuse_mesh("MeshArrays::point_fields[0].name: is empty",
              [](GoodMesh& good) { good.arrays.point_fields[0].name = ""; });
  refuse_mesh("MeshArrays::cell_fields[1].name: 'part' occurs twice",
              [](GoodMesh& good) { good.arrays.cell_fields.push_back(good.arrays.cell_fields[0]); });
  const std::vector<std::uint64_t> odd(27, std::uint64_t{1} << 63 | 1);
  refuse_mesh("MeshArrays::point_fields[0].values[0]: 9223372036854775809 does not fit a double exactly",
              [&](GoodMesh& good) { good.arrays.point_fields[0].values = std::span<const std::uint64_t>(odd); });
  const std::vector<std::int64_t> most(27, largest);
  refuse_mesh("does not fit a double exactly",
              [&](GoodMesh& good) { good.arrays.point_fields[0].values = std::span<const std::int64_t>(most); });
}

TEST(BadSurfaces, are_refused) {
  const std::vector<double> points{0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::vector<int> indices{0, 1, 2};
  SurfaceArrays arrays{.points = {std::span<const double>(points), {3, 3}},
                       .triangles = {std::span<const int>(indices), {1, 3}}};
  EXPECT_EQ(pack(arrays).kind(), DataKind::triangles);
  const auto refuse = [&](const std::string& words) { expect_refused(ErrorCode::usage, words, [&] { pack(arrays); }); };
  indices[1] = 3;
  refuse("SurfaceArrays::triangles[0][1]: found 3; expected an index of 3 points");
  indices[1] = -2;
  refuse("SurfaceArrays::triangles[0][1]: found -2");
  arrays.triangles = {std::span<const int>(), {0, 3}};
  refuse("SurfaceArrays::triangles: found none");
  arrays.triangles = {};
  refuse("SurfaceArrays::triangles: not given");
  arrays.points = {};
  refuse("SurfaceArrays::points: not given");
}

}  // namespace
}  // namespace rhoray::tests

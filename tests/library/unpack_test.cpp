// Packed data as arrays again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

TEST(Unpack, gives_the_samples_of_a_grid) {
  const Samples<std::int16_t> samples =
      samples_of<std::int16_t>(37, 11, 6, [](auto i, auto j, auto k) { return i - 40 * j + 300 * k; });
  const Samples<double> other =
      samples_of<double>(37, 11, 6, [](auto i, auto j, auto k) { return 0.1 * static_cast<double>(i * j - k); });
  const Dataset grid = pack({.fields = {samples.field("a"), other.field("b")}}, AxisOrder::zyx);
  const GridCopy a = unpack_grid(grid, "a"), b = unpack_grid(grid, "b");
  EXPECT_THAT(a.shape, testing::ElementsAre(6, 11, 37));
  EXPECT_EQ(a.type, ElementType::I16);
  ASSERT_EQ(a.samples.size(), samples.values.size() * sizeof(std::int16_t));
  EXPECT_EQ(std::memcmp(a.samples.data(), samples.values.data(), a.samples.size()), 0);
  EXPECT_EQ(b.type, ElementType::F64);
  ASSERT_EQ(b.samples.size(), other.values.size() * sizeof(double));
  EXPECT_EQ(std::memcmp(b.samples.data(), other.values.data(), b.samples.size()), 0);
  EXPECT_EQ(unpack_grid(grid).type, ElementType::I16) << "the first field";
  expect_refused(ErrorCode::usage, "no field 'c'", [&] { unpack_grid(grid, "c"); });
  expect_refused(ErrorCode::usage, "is no grid", [] { unpack_grid(ball_mesh()); });
}

TEST(Unpack, gives_a_mesh_in_the_order_of_its_source) {
  const MadeMesh made = box_mesh(6, {{-1, -1, -1}, {1, 1, 1}});  // that of ball_mesh
  const MeshCopy copy = unpack_mesh(ball_mesh());
  ASSERT_EQ(copy.points.size(), static_cast<std::size_t>(made.point_count()));
  EXPECT_EQ(std::memcmp(copy.points.data(), made.points.data(), made.points.size() * sizeof(double)), 0);
  ASSERT_EQ(copy.tetrahedra.size(), static_cast<std::size_t>(made.cell_count()));
  for (std::size_t cell = 0; cell < copy.tetrahedra.size(); ++cell) {
    const auto* const corners = made.tetrahedra.data() + 4 * cell;
    ASSERT_THAT(copy.tetrahedra[cell], testing::UnorderedElementsAre(corners[0], corners[1], corners[2], corners[3]));
  }
  ASSERT_EQ(copy.fields.size(), 3U);
  EXPECT_EQ(copy.fields[0].name, "radius");
  EXPECT_EQ(copy.fields[0].values, made.point_values([](const Vec3& p) { return distance(p); }));
  EXPECT_FALSE(copy.fields[0].is_of_cells);
  EXPECT_EQ(copy.fields[2].name, "part");
  EXPECT_TRUE(copy.fields[2].is_of_cells);
  EXPECT_EQ(copy.fields[2].values.size(), copy.tetrahedra.size());
  expect_refused(ErrorCode::usage, "holds no tetrahedra", [] { unpack_mesh(octahedron()); });
  expect_refused(ErrorCode::usage, "holds no tetrahedra", [] { unpack_mesh(gyroid_grid()); });
}

}  // namespace
}  // namespace rhoray::tests

#include "preprocess/mesh/order_cells.h"
#include "formats/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include "tests/support/meshes.h"

namespace rhoray::preprocess {
namespace {

using Corners = std::array<std::array<double, 3>, 4>;

Corners corners(const CleanMesh& mesh, std::size_t cell) {
  Corners corners;
  for (std::size_t v = 0; v < 4; ++v) corners[v] = mesh.points[mesh.cells[cell][v]];
  return corners;
}

/// Sum over neighbours in the order of the distance between their centres.
double way_through(const CleanMesh& mesh) {
  const auto center = [&](std::size_t cell) {
    Vec3 sum(0, 0, 0);
    for (const auto& p : corners(mesh, cell)) sum += tests::to_vec3(p) / 4;
    return sum;
  };
  double way = 0;
  for (std::size_t cell = 1; cell < mesh.cells.size(); ++cell) way += (center(cell) - center(cell - 1)).length();
  return way;
}

/// A mesh whose cells and points stand in no order.
NeutralMesh shuffled_mesh() {
  NeutralMesh mesh = tests::box_mesh({.cells = {12, 7, 9}, .box = {{0, 0, 0}, {3, 1, 1}}, .jitter = 0.1});
  std::vector<std::uint64_t> number(mesh.points.size());
  for (std::size_t p = 0; p < number.size(); ++p) number[p] = p * 1237 % number.size();
  Array<std::array<double, 3>> points(number.size());
  for (std::size_t p = 0; p < number.size(); ++p) points[number[p]] = mesh.points[p];
  mesh.points = points;
  for (auto& cell : mesh.cells)
    for (std::uint64_t& vertex : cell) vertex = number[vertex];
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    std::swap(mesh.cells[c], mesh.cells[c * 7919 % mesh.cells.size()]);
  return mesh;
}

TEST(OrderCells, keeps_every_cell_and_point_and_tells_where_it_stood) {
  const NeutralMesh source = shuffled_mesh();
  const CleanMesh before = clean_mesh(source, "mesh");
  CleanMesh after = before;
  const Array<std::uint32_t> ranks = order_cells(after);
  ASSERT_EQ(after.cells.size(), before.cells.size());
  ASSERT_EQ(ranks.size(), before.points.size());
  std::set<std::uint64_t> cells(after.source_cells.begin(), after.source_cells.end());
  std::set<std::uint32_t> points(ranks.begin(), ranks.end());
  EXPECT_EQ(cells.size(), before.cells.size());
  EXPECT_EQ(points.size(), before.points.size());
  for (std::size_t c = 0; c < after.cells.size(); ++c) {
    ASSERT_EQ(corners(after, c), corners(before, after.source_cells[c]))
        << "all cells are in the source's order before";
  }
  for (std::size_t p = 0; p < ranks.size(); ++p) {
    ASSERT_EQ(after.points[p], before.points[ranks[p]]);
    ASSERT_EQ(after.source_points[p], before.source_points[ranks[p]]);
  }
}

TEST(OrderCells, puts_neighbours_side_by_side_and_points_by_first_use) {
  CleanMesh mesh = clean_mesh(shuffled_mesh(), "mesh");
  const double before = way_through(mesh);
  order_cells(mesh);
  EXPECT_LT(way_through(mesh), before / 8);
  std::uint32_t named = 0;
  for (const auto& cell : mesh.cells)
    for (const std::uint32_t vertex : cell) {
      ASSERT_LE(vertex, named);
      named = std::max(named, vertex + 1);
    }
}

TEST(OrderCells, keeps_the_sources_order_at_one_place_and_does_not_depend_on_threads) {
  NeutralMesh mesh = shuffled_mesh();
  const auto twice = mesh.cells[5];
  mesh.cells.push_back(twice);  // where cell 5 is
  const auto ordered = [&](unsigned threads) {
    const ThreadLimit control(threads);
    CleanMesh clean = clean_mesh(mesh, "mesh");
    order_cells(clean);
    return clean;
  };
  const CleanMesh one = ordered(1), two = ordered(2);
  EXPECT_EQ(one.source_cells, two.source_cells);
  EXPECT_EQ(one.cells, two.cells);
  const auto first = std::find(one.source_cells.begin(), one.source_cells.end(), 5U);
  const auto second = std::find(one.source_cells.begin(), one.source_cells.end(), mesh.cells.size() - 1);
  EXPECT_LT(first, second);
  EXPECT_LT(second, one.source_cells.end());
}

TEST(OrderCells, parts_blocks_of_a_power_of_two_by_planes_across_their_longest_axis) {
  CleanMesh mesh = clean_mesh(shuffled_mesh(), "mesh");  // 4536 cells
  order_cells(mesh);
  const auto center = [&](std::size_t cell, int axis) {
    double sum = 0;
    for (const auto& p : corners(mesh, cell)) sum += p[static_cast<std::size_t>(axis)] / 4;
    return sum;
  };
  int blocks = 0;
  for (std::size_t size = 2; size <= 8192; size *= 2)
    for (std::size_t first = 0; first + size / 2 < mesh.cells.size(); first += size) {
      const std::size_t middle = first + size / 2, end = std::min(first + size, mesh.cells.size());
      Box3 box;
      for (std::size_t cell = first; cell < end; ++cell)
        box.extendBy(Vec3(center(cell, 0), center(cell, 1), center(cell, 2)));
      // Centres are compared as floats in the mesh's longest edge, which is 3: axes or places that
      // are as near count as equal.
      constexpr double rounding = 3 * 0x1p-22;
      bool is_parted = false;
      for (int axis = 0; axis < 3; ++axis) {
        if (box.size()[axis] < box.size()[static_cast<int>(box.majorAxis())] - rounding) continue;
        double before = -1, behind = 4;
        for (std::size_t cell = first; cell < end; ++cell)
          (cell < middle ? before : behind) =
              cell < middle ? std::max(before, center(cell, axis)) : std::min(behind, center(cell, axis));
        is_parted |= before <= behind + rounding;
      }
      EXPECT_TRUE(is_parted) << "block of " << size << " at " << first;
      ++blocks;
    }
  EXPECT_GT(blocks, 4500);
}

TEST(OrderCells, holds_cells_of_one_centre_and_flat_meshes) {
  NeutralMesh mesh = shuffled_mesh();
  const auto cell = mesh.cells[0];
  mesh.cells.assign(5000, cell);  // as often as pivots can divide badly
  CleanMesh clean = clean_mesh(mesh, "mesh");
  order_cells(clean);
  for (std::uint64_t n = 0; n < 5000; ++n) ASSERT_EQ(clean.source_cells[n], n);
}

}  // namespace
}  // namespace rhoray::preprocess

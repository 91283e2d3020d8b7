#include "preprocess/mesh/build_clusters.h"
#include "formats/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "formats/base/interval.h"
#include "preprocess/mesh/order_cells.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {
namespace {

using formats::BoxBlock;
using formats::ClusterShape;

CleanMesh ordered(const NeutralMesh& mesh) {
  CleanMesh clean = clean_mesh(mesh, "mesh");
  order_cells(clean);
  return clean;
}

TEST(BuildClusters, gives_every_cluster_the_vertices_of_its_cells_and_each_cell_its_own) {
  const CleanMesh mesh = ordered(tests::box_mesh({.cells = {9, 8, 7}, .jitter = 0.1}));
  for (const std::uint64_t size : {1U, 2U, 32U, 64U}) {
    const Clusters clusters = build_clusters(mesh.points, mesh.cells, size);
    const std::size_t count = (mesh.cells.size() + size - 1) / size;
    ASSERT_EQ(clusters.table_starts.size(), count + 1);
    for (std::size_t cluster = 0; cluster < count; ++cluster) {
      std::set<std::uint32_t> vertices;
      const std::size_t end = std::min(mesh.cells.size(), (cluster + 1) * size);
      for (std::size_t c = cluster * size; c < end; ++c) vertices.insert(mesh.cells[c].begin(), mesh.cells[c].end());
      const auto first = clusters.tables.begin() + static_cast<std::ptrdiff_t>(clusters.table_starts[cluster]);
      const auto last = clusters.tables.begin() + static_cast<std::ptrdiff_t>(clusters.table_starts[cluster + 1]);
      ASSERT_TRUE(std::equal(first, last, vertices.begin(), vertices.end()));
      for (std::size_t c = cluster * size; c < end; ++c)
        for (std::size_t v = 0; v < 4; ++v) ASSERT_EQ(first[clusters.corners[c][v]], mesh.cells[c][v]);
    }
  }
}

TEST(BuildClusters, takes_seven_tenths_of_a_vertex_for_a_cell) {
  const CleanMesh mesh = ordered(tests::box_mesh({.cells = {20, 20, 20}, .jitter = 0.1}));
  const Clusters clusters = build_clusters(mesh.points, mesh.cells, 64);
  EXPECT_LT(static_cast<double>(clusters.tables.size()), 0.71 * static_cast<double>(mesh.cells.size()));
}

/// Boxes as small as floats allow: the coordinates of one lie on, or between floats beside, a
/// vertex's.
void expect_tight_boxes(const CleanMesh& mesh, std::uint64_t size) {
  const Clusters clusters = build_clusters(mesh.points, mesh.cells, size);
  int exponent = 0;
  EXPECT_EQ(std::frexp(clusters.box_unit, &exponent), 0.5);
  constexpr float infinity = std::numeric_limits<float>::infinity();
  for (std::size_t cluster = 0; cluster + 1 < clusters.table_starts.size(); ++cluster) {
    const BoxBlock& block = clusters.boxes[0][cluster / 8];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double low = HUGE_VAL, high = -HUGE_VAL;
      for (std::size_t i = clusters.table_starts[cluster]; i < clusters.table_starts[cluster + 1]; ++i) {
        low = std::min(low, mesh.points[clusters.tables[i]][axis]);
        high = std::max(high, mesh.points[clusters.tables[i]][axis]);
      }
      const float lo = block.lo[axis][cluster % 8], hi = block.hi[axis][cluster % 8];
      ASSERT_LE(static_cast<double>(lo) * clusters.box_unit, low);
      ASSERT_GT(static_cast<double>(std::nextafter(lo, infinity)) * clusters.box_unit, low);
      ASSERT_GE(static_cast<double>(hi) * clusters.box_unit, high);
      ASSERT_LT(static_cast<double>(std::nextafter(hi, -infinity)) * clusters.box_unit, high);
    }
  }
}

TEST(BuildClusters, rounds_boxes_outwards_by_less_than_one_float_also_where_floats_do_not_reach) {
  for (const double scale : {1.0, 1e-60, 1e60}) {
    for (const double low : {0.0, -0.4}) {
      const Vec3 corner = Vec3(low, low, low) * scale;
      expect_tight_boxes(ordered(tests::box_mesh(
                             {.cells = {5, 6, 7}, .box = {corner, corner + Vec3(1, 2, 3) * scale}, .jitter = 0.1})),
                         16);
    }
  }
}

TEST(BuildClusters, makes_each_level_of_eights_of_the_one_below) {
  const CleanMesh mesh = ordered(tests::box_mesh({.cells = {10, 10, 10}, .jitter = 0.1}));
  const Clusters clusters = build_clusters(mesh.points, mesh.cells, 4);
  const ClusterShape& shape = clusters.shape;
  EXPECT_EQ(shape.count(0), 1500U);
  EXPECT_EQ(shape.count(1), 188U);
  EXPECT_EQ(shape.count(3), 3U);
  EXPECT_EQ(shape.top_level(), 3);
  ASSERT_EQ(clusters.boxes.size(), 4U);
  for (std::size_t level = 0; level < 4; ++level) {
    EXPECT_EQ(clusters.boxes[level].size(), shape.block_count(static_cast<int>(level)));
    if (level == 0) continue;
    for (std::size_t entry = 0; entry < 8 * clusters.boxes[level].size(); ++entry)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        float lo = std::numeric_limits<float>::infinity(), hi = -lo;  // of an empty entry
        if (entry < shape.count(static_cast<int>(level))) {
          const BoxBlock& below = clusters.boxes[level - 1][entry];
          lo = *std::min_element(below.lo[axis].begin(), below.lo[axis].end());
          hi = *std::max_element(below.hi[axis].begin(), below.hi[axis].end());
        }
        ASSERT_EQ(clusters.boxes[level][entry / 8].lo[axis][entry % 8], lo);
        ASSERT_EQ(clusters.boxes[level][entry / 8].hi[axis][entry % 8], hi);
      }
  }
}

TEST(BuildClusterRanges, leave_out_cells_without_data) {
  const CleanMesh mesh = ordered(tests::box_mesh({.cells = {6, 6, 6}}));
  std::vector<float> values(mesh.points.size());
  for (std::size_t p = 0; p < values.size(); ++p)
    // without data on both sides, because a cell's vertices rise in x
    values[p] = std::abs(mesh.points[p][0] - 0.5) > 0.2 ? std::numeric_limits<float>::quiet_NaN()
                                                        : static_cast<float>(37 * p % 101);
  const ClusterShape shape{.cell_count = mesh.cells.size(), .cluster_size = 8};
  const auto levels = build_cluster_ranges(mesh.cells, std::span<const float>(values), shape);
  int empty = 0;
  Interval<float> of_all;
  for (std::size_t cluster = 0; cluster < shape.count(0); ++cluster) {
    Interval<float> expected;
    for (std::size_t c = 8 * cluster; c < std::min(mesh.cells.size(), 8 * cluster + 8); ++c) {
      const auto& cell = mesh.cells[c];
      if (std::any_of(cell.begin(), cell.end(), [&](std::uint32_t p) { return std::isnan(values[p]); })) continue;
      for (const std::uint32_t p : cell) expected.include(values[p]);
    }
    const Interval<float> found{levels[0][cluster / 8].lo[cluster % 8], levels[0][cluster / 8].hi[cluster % 8]};
    ASSERT_EQ(found, expected);
    of_all.include(expected);
    empty += found.is_empty();
  }
  EXPECT_GT(empty, 10);
  EXPECT_EQ(*std::max_element(levels.back()[0].hi.begin(), levels.back()[0].hi.end()), of_all.hi);
}

TEST(BuildClusters, does_not_depend_on_the_number_of_threads) {
  const CleanMesh mesh = ordered(tests::box_mesh({.cells = {30, 30, 20}, .jitter = 0.1}));
  const auto built = [&](unsigned threads) {
    const ThreadLimit control(threads);
    return build_clusters(mesh.points, mesh.cells, 64);
  };
  const Clusters one = built(1), two = built(2);
  EXPECT_EQ(one.tables, two.tables);
  EXPECT_EQ(one.table_starts, two.table_starts);
  EXPECT_EQ(one.corners, two.corners);
}

}  // namespace
}  // namespace rhoray::preprocess

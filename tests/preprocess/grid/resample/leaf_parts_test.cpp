#include "preprocess/grid/resample/leaf_parts.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/preprocess/grid/resample/support.h"

namespace rhoray::preprocess {
namespace {

using Tetrahedron = std::array<Point, 4>;

TEST(ClippedVolume, is_known_by_hand_for_a_corner_of_the_box) {
  const Tetrahedron corner{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  EXPECT_DOUBLE_EQ(clip_to_box(corner, {0, 0, 0}, {1, 1, 1}).volume, 1.0 / 6);
  EXPECT_DOUBLE_EQ(clip_to_box(corner, {0, 0, 0}, {1, 1, 1}).center[0], 0.25);
  // Halfway up the slices are triangles of half the edge: what is above is an eighth.
  EXPECT_DOUBLE_EQ(clip_to_box(corner, {0, 0, 0.5}, {1, 1, 1}).volume, 1.0 / 48);
  EXPECT_DOUBLE_EQ(clip_to_box(corner, {0, 0, 0}, {1, 1, 0.5}).volume, 7.0 / 48);
  const Tetrahedron large{{{-9, -9, -9}, {40, -9, -9}, {-9, 40, -9}, {-9, -9, 40}}};
  const ClippedVolume whole = clip_to_box(large, {1, 2, 3}, {2, 4, 6});
  EXPECT_NEAR(whole.volume, 6, 1e-12);
  EXPECT_NEAR(whole.center[0], 1.5, 1e-12);
  EXPECT_NEAR(whole.center[1], 3, 1e-12);
  EXPECT_NEAR(whole.center[2], 4.5, 1e-12);
  EXPECT_EQ(clip_to_box(corner, {0.5, 0.5, 0.5}, {1, 1, 1}).volume, 0);
  EXPECT_EQ(clip_to_box(corner, {-1, 0, 0}, {0, 1, 1}).volume, 0) << "only a face is in this box";
}

TEST(ClippedVolume, agrees_with_counting_points_of_a_lattice) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-0.5, 1.5);
  constexpr int n = 40;
  for (int round = 0; round < 20; ++round) {
    Tetrahedron t;
    for (Point& p : t) p = {place(random), place(random), place(random)};
    const auto six_volumes = [](const Point& a, const Point& b, const Point& c, const Point& d) {
      return dot(cross(minus(b, a), minus(c, a)), minus(d, a));
    };
    const double whole = six_volumes(t[0], t[1], t[2], t[3]);
    int count = 0;
    for (int i = 0; i < n * n * n; ++i) {
      const Point q{(i % n + 0.5) / n, (i / n % n + 0.5) / n, (i / n / n + 0.5) / n};
      bool is_inside = true;
      for (std::size_t v = 0; v < 4; ++v) {
        Tetrahedron moved = t;
        moved[v] = q;
        is_inside = is_inside && six_volumes(moved[0], moved[1], moved[2], moved[3]) * whole > 0;
      }
      count += is_inside;
    }
    if (whole < 0) std::swap(t[2], t[3]);
    EXPECT_NEAR(clip_to_box(t, {0, 0, 0}, {1, 1, 1}).volume, static_cast<double>(count) / (n * n * n), 0.01) << round;
  }
}

TEST(LeafParts, share_out_all_of_the_mesh_among_the_leaf_cells) {
  const Sampled sampled(with_random_values(tests::strewn_mesh(60, 0.4, 0.3, 4), 1), {.longest_axis = 20});
  const std::vector<Point> steps = points_in_steps(sampled.mesh, sampled.lattice);
  LeafParts parts(sampled.mesh, steps);
  LeafParts::Leaves all;
  all.set();
  std::vector<double> volumes(sampled.mesh.cells.size(), 0);
  for (std::size_t slot = 0; slot < sampled.touched.bricks.size(); ++slot) {
    const Index3 first = sampled.touched.at(slot) * SampleLattice::brick_edge;
    const Point in_steps{static_cast<double>(first.x), static_cast<double>(first.y), static_cast<double>(first.z)};
    for (const LeafParts::Part& part :
         parts.find(in_steps, sampled.touched.lists.view().list(sampled.touched.bricks[slot]), all, 0)) {
      volumes[part.cell] += part.volume;
      const std::array<std::size_t, 3> low{part.leaf % 8, part.leaf / 8 % 8, part.leaf / 64};
      for (std::size_t a = 0; a < 3; ++a) {
        EXPECT_GE(part.center[a], static_cast<double>(low[a]));
        EXPECT_LE(part.center[a], static_cast<double>(low[a] + 1));
      }
    }
  }
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    const auto& cell = sampled.mesh.cells[c];
    const Point &p = steps[cell[0]], a = minus(steps[cell[1]], p), b = minus(steps[cell[2]], p);
    const double whole = dot(cross(a, b), minus(steps[cell[3]], p)) / 6;
    EXPECT_NEAR(volumes[c], whole, 1e-9 * whole + 1e-12) << c;
  }
}

}  // namespace
}  // namespace rhoray::preprocess

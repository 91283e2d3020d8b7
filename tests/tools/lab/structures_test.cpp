// The study's own structures for meshes: each returns the library's answer for every ray, and
// rounding points has the stated effects on a mesh.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "formats/base/number_text.h"
#include "render/ray_caster.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/structures/cell_orders.h"
#include "tools/lab/structures/cell_sides.h"
#include "tools/lab/structures/made_meshes.h"
#include "tools/lab/structures/ways.h"
#include "tools/lab/warped_box.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Ray;
using study::MeshForWays;
using study::Way;

constexpr std::int64_t edge = 5;  // 750 cells
constexpr double isovalue = 0.9;

struct NamedMesh {
  std::string name;
  preprocess::NeutralMesh mesh;
};
std::vector<NamedMesh> meshes() {
  return {{"even", study::warped_box(edge)},
          {"graded", study::graded(study::warped_box(edge), 6)},
          {"slivers", study::with_slivers(study::warped_box(edge), edge)}};
}

/// Rays through the mesh from everywhere, along its axes through points and faces, cut short, and
/// past it. In the frame of a packed mesh, whose origin is the centre or a corner of the unit cube;
/// `low` is the cube's low corner there.
std::vector<Ray> rays_through(const Vec3& low) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> in(0, 1), around(-2, 3);
  const auto anywhere = [&](auto& numbers) { return Vec3(numbers(random), numbers(random), numbers(random)); };
  std::vector<Ray> rays;
  for (int n = 0; n < 4000; ++n) {
    const Vec3 origin = anywhere(around);
    rays.push_back({.origin = origin + low, .direction = anywhere(in) - origin});
    if (n % 8 == 1) rays.back().origin = anywhere(in) + low;
    if (n % 8 == 2) rays.back().t_max = 0.8;
    if (n % 8 == 3) rays.back().t_min = 1;
    if (n % 8 == 4) rays.back().direction[n / 8 % 3] = 0;
    if (n % 16 == 5) rays.back() = {.origin = Vec3(0, 0.5, -1) + low, .direction = {1e-3 * n / 4000, 0, 1}};
    if (n % 16 == 6) rays.back() = {.origin = Vec3(-1, 0.4, 0.4) + low, .direction = {1, 0.05 * in(random), 0}};
  }
  return rays;
}

TEST(Structures, all_give_every_ray_the_librarys_answer) {
  for (const NamedMesh& named : meshes()) {
    const TemporaryFolder folder;
    const MeshForWays mesh(named.mesh, folder.path());
    const std::vector<Ray> rays = rays_through(-mesh.packed().description().origin);
    std::vector<Hit> expected(rays.size());
    render::RayCaster(mesh.dataset(), isovalue, {}).first_crossings(rays, expected);
    EXPECT_GT(std::ranges::count_if(expected, &Hit::is_miss), 500) << named.name;
    EXPECT_GT(std::ranges::count_if(expected, [](const Hit& hit) { return !hit.is_miss(); }), 500) << named.name;

    std::vector<Way> ways = mesh.structures(isovalue);
    for (Way& way : mesh.orders(isovalue)) ways.push_back(std::move(way));
    EXPECT_EQ(ways.size(), 31U);
    for (const Way& way : ways) {
      std::vector<Hit> hits(rays.size());
      render::KernelCounters counters;
      way.ask(rays, hits, counters);
      std::size_t other = 0;
      for (std::size_t r = 0; r < rays.size(); ++r)
        other +=
            hits[r].t != expected[r].t || hits[r].cell != expected[r].cell || hits[r].gradient != expected[r].gradient;
      EXPECT_EQ(other, 0U) << named.name << ", " << way.name;
      EXPECT_GT(counters.macrocells_visited, 0U) << named.name << ", " << way.name;
      EXPECT_GT(counters.cells_visited, 1000U) << named.name << ", " << way.name;
      EXPECT_GT(counters.cells_solved, 1000U) << named.name << ", " << way.name;
      EXPECT_GT(way.bytes_per_cell, 4) << named.name << ", " << way.name;
      EXPECT_GE(way.named_per_cell, 1) << named.name << ", " << way.name;
    }
  }
}

TEST(Structures, hold_a_ray_against_a_cell_once_where_there_is_a_mailbox) {
  const TemporaryFolder folder;
  const MeshForWays mesh(study::warped_box(edge), folder.path());
  const std::vector<Ray> rays = rays_through(-mesh.packed().description().origin);
  std::map<std::string, std::uint64_t> tested;
  for (const Way& way : mesh.orders(isovalue)) {
    std::vector<Hit> hits(rays.size());
    render::KernelCounters counters;
    way.ask(rays, hits, counters);
    tested[way.name] = counters.cells_solved;
  }
  const std::uint64_t often = tested["leaf lists: as packed"], once = tested["leaf lists: a mailbox for each cell"];
  EXPECT_GT(once, 0U);
  EXPECT_GT(often, once + once / 4) << "cells reach over several leaves";
  EXPECT_GE(tested["leaf lists: a small mailbox"], once);
  EXPECT_LE(tested["leaf lists: a small mailbox"], often);
}

TEST(CellSides, touches_every_box_that_holds_a_point_of_the_cell) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(-1, 1), share(0, 1);
  int inside = 0, apart = 0;
  for (int n = 0; n < 3000; ++n) {
    std::array<std::array<double, 3>, 4> points;
    for (auto& point : points)
      for (double& x : point) x = place(random);
    if (n % 5 == 0) points[3] = points[2];  // flat
    const study::CellSides sides(points);
    const Vec3 center(place(random), place(random), place(random)), half(0.3 * share(random) + 0.01);
    bool holds_one = false;
    for (int s = 0; s < 200 && !holds_one; ++s) {
      std::array<double, 4> weight;
      for (double& w : weight) w = -std::log(share(random) + 1e-300);
      const double sum = weight[0] + weight[1] + weight[2] + weight[3];
      holds_one = true;
      for (int axis = 0; axis < 3; ++axis) {
        double x = 0;
        for (std::size_t v = 0; v < 4; ++v) x += weight[v] / sum * points[v][static_cast<std::size_t>(axis)];
        holds_one &= std::abs(x - center[axis]) <= half[axis];
      }
    }
    const bool touches = sides.touches(center, half);
    inside += holds_one;
    apart += !touches;
    EXPECT_TRUE(touches || !holds_one) << n;
  }
  EXPECT_GT(inside, 200);
  EXPECT_GT(apart, 1000);
}

TEST(CellSides, keeps_clear_of_boxes_that_only_a_slanted_direction_tells_apart) {
  const study::CellSides corner({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  // Separated by the slanted face x + y + z = 1: the box's nearest corner is at a sum of 3 (c - h).
  EXPECT_TRUE(corner.touches(Vec3(0.5), Vec3(0.17)));
  EXPECT_FALSE(corner.touches(Vec3(0.5), Vec3(0.16)));
  // Separated by the product of z and an edge: x + y = 1, with z around 0, where neither faces nor
  // axes separate them.
  EXPECT_TRUE(corner.touches({0.6, 0.6, 0}, Vec3(0.11)));
  EXPECT_FALSE(corner.touches({0.6, 0.6, 0}, Vec3(0.09)));
  // Touching counts, up to rounding: here two faces meet.
  EXPECT_TRUE(corner.touches({-0.25, 0.1, 0.1}, Vec3(0.25)));
}

TEST(CellOrders, hold_every_cell_once_and_curves_keep_neighbours_together) {
  const TemporaryFolder folder;
  const MeshForWays mesh(study::warped_box(edge), folder.path());
  const study::PlainMesh plain(mesh.packed());
  const auto extent = [&](const std::vector<std::uint32_t>& order) {
    double sum = 0;
    for (std::size_t first = 0; first < order.size(); first += 8) {
      Box3 box;
      for (std::size_t n = first; n < std::min(first + 8, order.size()); ++n) box.extendBy(plain.box(order[n]));
      sum += box.size().length();
    }
    return sum;
  };
  for (const auto& order : {study::as_they_stand(plain), study::as_made(plain), study::shuffled(plain),
                            study::by_morton(plain), study::by_hilbert(plain)}) {
    std::vector<std::uint32_t> sorted = order;
    std::ranges::sort(sorted);
    EXPECT_EQ(sorted, study::as_they_stand(plain));
  }
  const std::vector<std::uint32_t> made = study::as_made(plain);
  for (std::uint32_t n = 0; n < plain.cell_count(); ++n) EXPECT_EQ(plain.cell_id(made[n]), n);
  const double shuffled = extent(study::shuffled(plain));
  EXPECT_LT(extent(study::by_morton(plain)), 0.5 * shuffled);
  EXPECT_LT(extent(study::by_hilbert(plain)), 0.45 * shuffled);
}

TEST(RoundedPoints, part_only_where_every_cluster_has_its_own_lattice) {
  for (const NamedMesh& named : meshes()) {
    const TemporaryFolder folder;
    const MeshForWays mesh(named.mesh, folder.path());
    const std::vector<Ray> rays = rays_through(-mesh.packed().description().origin);
    const std::vector<MeshForWays::RoundedWay> ways = mesh.rounded(isovalue);
    ASSERT_EQ(ways.size(), 5U);
    std::vector<std::vector<Hit>> hits;
    for (const auto& [way, shape] : ways) {
      render::KernelCounters counters;
      hits.emplace_back(rays.size());
      way.ask(rays, hits.back(), counters);
      const bool is_shared = hits.size() <= 3;
      EXPECT_EQ(shape.split_points == 0, is_shared) << named.name << ", " << way.name;
      EXPECT_EQ(shape.widest_gap_edges == 0, is_shared) << named.name << ", " << way.name;
    }
    EXPECT_EQ(ways[0].shape.folded_cells, 0U);
    EXPECT_NEAR(ways[1].way.bytes_per_cell, ways[0].way.bytes_per_cell / 2, 1e-12);
    EXPECT_NEAR(ways[2].way.bytes_per_cell, ways[0].way.bytes_per_cell / 3, 1e-12);
    // A position is off by at most half a step along each axis. There are 65535 or 1023 steps over
    // a cluster, in which an edge of the cells may be a sixty-fourth of its length (slivers and
    // graded cells: over their longest edge).
    EXPECT_LT(ways[3].shape.widest_gap_edges, 64 * 2.0 / 65535) << named.name;
    EXPECT_LT(ways[4].shape.widest_gap_edges, 64 * 2.0 / 1023) << named.name;
    EXPECT_LT(ways[3].shape.widest_gap_edges, ways[4].shape.widest_gap_edges) << named.name;
    for (std::size_t w = 0; w < ways.size(); ++w) {
      int other = 0;
      double largest = 0;
      for (std::size_t r = 0; r < rays.size(); ++r) {
        const Hit &now = hits[w][r], &exact = hits[0][r];
        other += now.is_miss() != exact.is_miss();
        if (!now.is_miss() && !exact.is_miss()) largest = std::max(largest, std::abs(now.t - exact.t));
      }
      EXPECT_LE(other, w == 0 ? 0 : 40) << named.name << ", " << ways[w].way.name;
      EXPECT_EQ(largest == 0, w == 0) << named.name << ", " << ways[w].way.name;
    }
  }
}

}  // namespace
}  // namespace rhoray::tests

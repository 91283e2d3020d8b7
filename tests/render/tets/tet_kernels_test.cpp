#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Method;
using render::Ray;
using render::RayShear;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Rays through the unit cube: arbitrary ones, and those aimed at points of a lattice of quarters,
/// along axes and diagonals.
std::vector<Ray> rays_through_cube(std::size_t count, std::uint64_t seed) {
  constexpr std::array<double, 4> steps{0.0, 1.0, -1.0, 2.0};
  Dice dice(seed);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    Vec3 direction = dice.direction(), through = dice.point({0, 0, 0}, {1, 1, 1});
    if (dice.below(3) == 0) direction = {dice.one_of(steps), dice.one_of(steps), dice.one_of(steps)};
    if (direction.length() == 0) continue;
    if (dice.coin())
      for (int axis = 0; axis < 3; ++axis) through[axis] = 0.25 * static_cast<double>(dice.below(5));
    rays.push_back({.origin = through - 4.0 * direction, .direction = direction});
  }
  return rays;
}

/// Tests all cells of a mesh, one after the other: no leaf lists, no hierarchy.
struct AllCells {
  const preprocess::NeutralMesh& mesh;

  template <class Act>
  void for_each_passage(const Ray& ray, double offset, Act act) const {
    const RayShear shear(ray);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
      auto v = mesh.cells[c];
      std::sort(v.begin(), v.end());
      render::SeenTet tet;
      bool has_data = true;
      for (std::size_t i = 0; i < 4; ++i) {
        tet.vertex[i] = shear.see(mesh.points[v[i]]);
        tet.value[i] = mesh.point_fields[0].values[v[i]];
        has_data = has_data && std::isfinite(tet.value[i]);
      }
      if (!has_data) continue;
      auto passage = pass_through(tet, offset);
      if (passage) passage = clip(*passage, ray.t_min, ray.t_max);
      if (passage) act(*passage, c);
    }
  }
  double first_crossing(const Ray& ray, double iso) const {
    double first = std::numeric_limits<double>::infinity();
    for_each_passage(ray, iso, [&](const render::TetPassage& passage, std::size_t) {
      if (const auto t = render::first_crossing(passage)) first = std::min(first, *t);
    });
    return first;
  }
  double largest_value(const Ray& ray) const {
    double largest = -std::numeric_limits<double>::infinity();
    for_each_passage(ray, 0, [&](const render::TetPassage& passage, std::size_t) {
      largest = std::max({largest, passage.in.value, passage.out.value});
    });
    return largest;
  }
};

/// The packed mesh itself: points in its own frame and order, so that a test of all cells computes
/// with the same bits.
preprocess::NeutralMesh packed_mesh(const TracedDataset& traced) {
  const formats::TetMesh packed(traced.dataset().file());
  preprocess::NeutralMesh mesh;
  mesh.points.assign(packed.points().begin(), packed.points().end());
  for (std::uint64_t c = 0; c < packed.description().cell_count; ++c) {
    const auto cell = packed.cell(c);
    mesh.cells.push_back({cell[0], cell[1], cell[2], cell[3]});
  }
  const std::span<const double> values = packed.values<double>(0);
  mesh.point_fields.push_back({.name = "value", .unit = {}, .values = {values.begin(), values.end()}});
  return mesh;
}

TEST(TetFirstCrossing, meets_the_plane_of_a_linear_field_at_its_exact_t) {
  const Vec3 slope(0.3, -0.7, 0.5);
  TracedDataset traced(box_mesh({.cells = {5, 4, 6}, .jitter = 0.1}, linear_field(slope, 0.1)));
  int hits = 0;
  for (const Ray& ray : rays_through_cube(3000, 1)) {
    const double t = (0.15 - 0.1 - slope.dot(ray.origin)) / slope.dot(ray.direction);
    const Vec3 p = ray.at(t);
    const double inset = std::min({p.x, p.y, p.z, 1 - p.x, 1 - p.y, 1 - p.z});
    const Hit hit = traced.first_crossing(ray, 0.15);
    if (std::abs(inset) < 1e-9 || std::isnan(inset)) continue;
    ASSERT_EQ(hit.is_miss(), inset < 0) << ray.origin << " + t " << ray.direction;
    if (hit.is_miss()) continue;
    EXPECT_NEAR(hit.t, t, 1e-12);
    EXPECT_EQ(hit.value, 0.15);
    EXPECT_LT((hit.gradient - slope).length(), 1e-11);
    ++hits;
  }
  EXPECT_GT(hits, 1200);
}

TEST(TetFirstCrossing, is_what_looking_into_every_cell_finds) {
  const auto field = distance_field({0.4, 0.5, 0.6});
  int hits = 0;
  for (const double jitter : {0.0, 0.12}) {
    const auto mesh = box_mesh({.cells = {4, 4, 4}, .jitter = jitter, .grading = 5}, field);
    for (const double leaves_per_cell : {0.05, 1.0, 8.0}) {
      TracedDataset traced(mesh, {.structure = preprocess::MeshStructure::leaves,
                                  .leaf_cells_per_tetrahedron = leaves_per_cell,
                                  .macro_factor = 2});
      const auto moved = packed_mesh(traced);
      for (const Ray& ray : rays_through_cube(700, 2)) {
        const Hit hit = traced.first_crossing(ray, 0.3), flat = traced.first_crossing(ray, 0.3, false);
        ASSERT_EQ(hit.t, AllCells{moved}.first_crossing(traced.ray_data(ray), 0.3));
        ASSERT_TRUE(same_bits(hit, flat));
        hits += !hit.is_miss();
      }
    }
  }
  EXPECT_GT(hits, 700);
}

TEST(TetFirstCrossing, holds_a_ray_against_no_tetrahedron_twice) {
  preprocess::NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.cells = {{0, 1, 2, 3}};
  add_point_field(mesh, "value", linear_field({1, 1, 1}, 0));
  TracedDataset traced(mesh, {.structure = preprocess::MeshStructure::leaves, .leaf_cells_per_tetrahedron = 8000});
  std::uint64_t tested = 0, leaves = 0;
  for (const Ray& ray : rays_through_cube(500, 3)) {
    for (const Method& method : {Method{}, Method{.algorithm = Method::Algorithm::certified}}) {
      traced.scratch.counters = {};
      traced.first_crossing(ray, 0.9, method);
      // Such a ray was tested against the cell in another precision, too.
      if (traced.scratch.counters.rays_redone != 0) continue;
      ASSERT_LE(traced.scratch.counters.cells_solved, 1U);
      tested += traced.scratch.counters.cells_solved;
      leaves += traced.scratch.counters.cells_visited;
    }
  }
  EXPECT_GT(tested, 100U);
  EXPECT_GT(leaves, 5 * tested);
}

TEST(TetFirstCrossing, names_the_cell_of_the_source_and_its_gradient) {
  auto mesh = box_mesh({.cells = {3, 3, 3}}, distance_field({0.5, 0.5, 0.5}));
  // One vertex twice: packing drops the cell, later ids stay.
  mesh.cells.insert(mesh.cells.begin() + 5, {7, 7, 8, 9});
  TracedDataset traced(mesh);
  int hits = 0;
  for (const Ray& ray : rays_through_cube(500, 3)) {
    const Hit hit = traced.first_crossing(ray, 0.35);
    if (hit.is_miss()) continue;
    ASSERT_LT(hit.cell, mesh.cells.size());
    ASSERT_NE(hit.cell, 5U);
    const auto& cell = mesh.cells[hit.cell];
    // The hit is in the cell: its barycentric coordinates are not negative.
    std::array<Vec3, 4> p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = to_vec3(mesh.points[cell[i]]);
    const Vec3 q = ray.at(hit.t);
    const auto volume = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
      return (b - a).cross(c - a).dot(d - a);
    };
    const double all = volume(p[0], p[1], p[2], p[3]);
    EXPECT_GE(volume(q, p[1], p[2], p[3]) / all, -1e-12);
    EXPECT_GE(volume(p[0], q, p[2], p[3]) / all, -1e-12);
    EXPECT_GE(volume(p[0], p[1], q, p[3]) / all, -1e-12);
    EXPECT_GE(volume(p[0], p[1], p[2], q) / all, -1e-12);
    for (std::size_t i = 1; i < 4; ++i) {
      EXPECT_NEAR(hit.gradient.dot(p[i] - p[0]),
                  mesh.point_fields[0].values[cell[i]] - mesh.point_fields[0].values[cell[0]], 1e-12);
    }
    ++hits;
  }
  EXPECT_GT(hits, 100);
}

TEST(TetFirstCrossing, from_inside_is_where_the_ray_comes_out) {
  TracedDataset traced(box_mesh({.cells = {4, 4, 4}}, linear_field({1, 0, 0})));
  const Ray from_inside{.origin = {0.7, 0.41, 0.33}, .direction = {-1, 0, 0}};
  EXPECT_NEAR(traced.first_crossing(from_inside, 0.2).t, 0.5, 1e-15);
  EXPECT_TRUE(traced.first_crossing({.origin = {0.7, 0.41, 0.33}, .direction = {1, 0, 0}}, 0.2).is_miss());
  Ray cut = from_inside;
  cut.t_max = 0.4;
  EXPECT_TRUE(traced.first_crossing(cut, 0.2).is_miss());
  cut = from_inside;
  cut.t_min = 0.6;
  EXPECT_TRUE(traced.first_crossing(cut, 0.2).is_miss());
}

TEST(TetFirstCrossing, gives_no_surface_at_the_mesh_boundary_or_against_cells_without_data) {
  auto mesh = box_mesh({.cells = {6, 6, 6}}, [](const Vec3& p) { return p.x < 0.4 ? 1.0 : p.x < 0.6 ? nan : -1.0; });
  TracedDataset traced(mesh);
  for (const Ray& ray : rays_through_cube(300, 4)) {
    EXPECT_TRUE(traced.first_crossing(ray, 0).is_miss());
    EXPECT_TRUE(traced.first_crossing(ray, 0, false).is_miss());
  }
}

TEST(TetFirstCrossing, reads_single_precision_fields) {
  TracedDataset traced(box_mesh({.cells = {4, 4, 4}}, linear_field({1, 0, 0}), true));
  EXPECT_EQ(traced.dataset().field().type, formats::ElementType::F32);
  EXPECT_NEAR(traced.first_crossing({.origin = {-1, 0.3, 0.4}, .direction = {1, 0, 0}}, 0.6).t, 1.6, 1e-15);
}

TEST(TetLargestValue, is_what_looking_into_every_cell_finds) {
  int hits = 0;
  const auto field = [](const Vec3& p) { return -std::abs(p.x - 0.45) - (p - Vec3(0.4, 0.6, 0.5)).length(); };
  const auto mesh = box_mesh({.cells = {4, 5, 3}, .jitter = 0.1}, field);
  TracedDataset traced(mesh, {.macro_factor = 2});
  const auto moved = packed_mesh(traced);
  for (const Ray& ray : rays_through_cube(1500, 5)) {
    const Hit hit = traced.largest_value(ray);
    const double truth = AllCells{moved}.largest_value(traced.ray_data(ray));
    ASSERT_EQ(hit.is_miss(), std::isinf(truth));
    if (hit.is_miss()) continue;
    EXPECT_NEAR(hit.value, truth, 1e-15);
    EXPECT_LT(hit.value, 0);
    EXPECT_TRUE(same_bits(hit, traced.largest_value(ray, render::Method{}, false)));
    EXPECT_TRUE(same_bits(hit, traced.largest_value(ray, face_rule)));
    ++hits;
  }
  EXPECT_GT(hits, 1000);
}

TEST(TetLargestValue, never_needs_more_of_the_queue_than_is_reserved) {
  TracedDataset traced(box_mesh({.cells = {5, 5, 5}}, distance_field({0.3, 0.3, 0.3})),
                       {.structure = preprocess::MeshStructure::leaves,
                        .leaf_cells_per_tetrahedron = 5,
                        .macro_factor = 2,
                        .macro_level_count = 4});
  traced.largest_value({.origin = {-1, 0.5, 0.5}, .direction = {1, 0, 0}});
  const std::size_t capacity = traced.scratch.queue.capacity();
  for (const Ray& ray : rays_through_cube(1000, 6)) traced.largest_value(ray);
  EXPECT_EQ(traced.scratch.queue.capacity(), capacity);
}

}  // namespace
}  // namespace rhoray::tests

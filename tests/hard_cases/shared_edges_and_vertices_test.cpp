// T01-T05. A ray through an edge or a vertex of a mesh, along an edge or in the plane of faces
// touches many tetrahedra at once. Tested one by one, they may all reject it or all accept it.
// Along a ray from outside a closed surface to the outside, the changes of side come in pairs.
#include <gtest/gtest.h>

#include "tests/hard_cases/mesh_crossings.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"

namespace rhoray::tests {
namespace {

preprocess::NeutralMesh ball_in_a_box(double jitter) {
  return box_mesh({.cells = {4, 4, 4}, .box = Box3({-2, -2, -2}, {2, 2, 2}), .jitter = jitter},
                  [](const Vec3& p) { return 1.7 - p.length(); });
}

/// Rays from outside to outside, aimed at vertices and edges inside the ball; some run along edges
/// and in face planes.
std::vector<render::Ray> rays_at_edges_and_vertices(const preprocess::NeutralMesh& mesh) {
  Dice dice(2);
  std::vector<render::Ray> rays;
  constexpr std::array<double, 3> steps{-1, 0, 1};
  while (rays.size() < 3000) {
    const auto& cell = mesh.cells[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(mesh.cells.size())))];
    const Vec3 a = to_vec3(mesh.points[cell[static_cast<std::size_t>(dice.below(4))]]);
    const Vec3 b = to_vec3(mesh.points[cell[static_cast<std::size_t>(dice.below(4))]]);
    if (a.length() > 1.2 || b.length() > 1.2) continue;
    const double share = dice.coin() ? 0.5 : dice.between(0, 1);
    const Vec3 target = dice.coin() ? a : share * a + (1 - share) * b;
    Vec3 direction = dice.direction();
    if (dice.below(3) == 0) direction = {dice.one_of(steps), dice.one_of(steps), dice.one_of(steps)};
    if (dice.below(6) == 0) direction = b - a;
    if (direction.length() == 0) continue;
    rays.push_back({.origin = target - (8 / direction.length()) * direction, .direction = direction});
  }
  return rays;
}

TEST(SharedEdgesAndVertices, inside_a_ball_are_no_holes_in_it) {
  int wrong = 0, none = 0;
  for (const double jitter : {0.0, 0.12}) {
    const auto mesh = ball_in_a_box(jitter);
    for (const render::Ray& ray : rays_at_edges_and_vertices(mesh)) {
      const MeshCrossings found = crossings(mesh, 0, ray);
      wrong += !found.is_right(found.ours);
      none += found.ours.empty();
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(none, 0);
}

TEST(SharedEdgesAndVertices, on_the_surface_change_the_side_in_pairs) {
  int rays = 0, odd = 0, odd_strict = 0;
  for (const double jitter : {0.0, 0.12}) {
    const auto mesh = ball_in_a_box(jitter);
    Dice dice(3);
    for (const auto& cell : mesh.cells)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j) {
          const double f = mesh.point_fields[0].values[cell[i]], g = mesh.point_fields[0].values[cell[j]];
          if ((f >= 0) == (g >= 0)) continue;
          // The point where the surface meets the edge.
          const Vec3 a = to_vec3(mesh.points[cell[i]]), b = to_vec3(mesh.points[cell[j]]);
          const Vec3 target = a + f / (f - g) * (b - a), direction = dice.direction();
          const MeshCrossings found = crossings(mesh, 0, {.origin = target - 8.0 * direction, .direction = direction});
          odd += found.ours.size() % 2 != 0;
          odd_strict += found.strict.size() % 2 != 0;
          ++rays;
        }
  }
  EXPECT_EQ(odd, 0);
  EXPECT_GT(rays, 1000);
  EXPECT_GT(odd_strict, 10) << "the strict test no longer fails here: is this case still the hard one?";
  RecordProperty("odd_strict", odd_strict);
}

TEST(SharedEdgesAndVertices, are_no_holes_in_a_packed_mesh) {
  const auto mesh = ball_in_a_box(0.12);
  TracedDataset traced(mesh);
  int missed = 0;
  for (const render::Ray& ray : rays_at_edges_and_vertices(mesh)) missed += traced.first_crossing(ray, 0).is_miss();
  EXPECT_EQ(missed, 0);
}

}  // namespace
}  // namespace rhoray::tests

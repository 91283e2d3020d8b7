#include "data/recipes/potential.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "data/recipes/torso_scene.h"
#include "data/recipes/torso_surface.h"
#include "formats/base/error.h"
#include "preprocess/tetrahedralize.h"

namespace rhoray::tests {
namespace {

using preprocess::NeutralMesh;
using recipes::solve_potential;

double norm(const std::array<double, 3>& p) {
  return std::hypot(p[0], p[1], p[2]);
}

/// A ball of radius 100 around 0 filled by TetGen, with small cells in the middle.
const NeutralMesh& ball() {
  static const NeutralMesh mesh = [] {
    preprocess::NeutralSurface surface;
    const auto add = [&](double radius, double size) {
      const recipes::StarSurface sphere{[=](const Vec3& p) { return p.length() - radius; }, Vec3(0), 2 * radius};
      const auto part = recipes::triangulate(sphere, [=](const Vec3&) { return size; });
      const std::uint64_t base = surface.points.size();
      for (const Vec3& p : part.points) {
        surface.points.push_back({p.x, p.y, p.z});
        surface.point_sizes.push_back(size);
      }
      for (const auto& t : part.triangles) {
        for (const auto corner : t) surface.facet_corners.push_back(base + corner);
        surface.facet_offsets.push_back(surface.facet_corners.size());
      }
    };
    add(100, 14);
    add(25, 4);
    surface.regions = {{.seed = {60, 0, 0}, .attribute = 1}, {.seed = {0, 0, 0}, .attribute = 2}};
    return preprocess::tetrahedralize(surface);
  }();
  return mesh;
}

TEST(TorsoPotential, reproduces_a_linear_potential_exactly) {
  const NeutralMesh& mesh = ball();
  const auto linear = [](const std::array<double, 3>& p) { return 3 + 0.5 * p[0] - 0.25 * p[1] + 2 * p[2]; };
  recipes::HeldFixed outside;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (norm(mesh.points[i]) > 85) outside.emplace_back(i, linear(mesh.points[i]));
  ASSERT_LT(outside.size(), mesh.points.size() / 2);
  const std::vector<double> even(mesh.cells.size(), 0.3);
  const auto solved = solve_potential(mesh, even, {.width_mm = 5}, outside);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    EXPECT_NEAR(solved.potential_mv[i], linear(mesh.points[i]), 1e-9);
}

TEST(TorsoPotential, of_a_dipole_in_a_homogeneous_ball_is_the_known_one) {
  // In a ball of radius R that no current leaves: phi = p.r / (4 pi sigma) (1 / r^3 + 2 / R^3).
  const NeutralMesh& mesh = ball();
  constexpr double sigma = 0.25, moment = 20, radius = 100;
  const std::vector<double> even(mesh.cells.size(), sigma);
  for (const double width : {6.0, 1.6}) {  // smooth, and narrower than the cells
    const auto solved = solve_potential(mesh, even, {.moment_ma_mm = {0, 0, moment}, .width_mm = width});
    EXPECT_LT(solved.residual, 1e-8);
    double error2 = 0, size2 = 0;
    int compared = 0;
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      const double r = norm(mesh.points[i]);
      if (r < 30) continue;  // five widths off, the smeared dipole is one point
      const double known = 1000 * moment * mesh.points[i][2] / (4 * std::numbers::pi * sigma) *
                           (1 / (r * r * r) + 2 / (radius * radius * radius));
      error2 += std::pow(solved.potential_mv[i] - known, 2);
      size2 += known * known;
      ++compared;
    }
    EXPECT_GT(compared, 500);
    EXPECT_LT(std::sqrt(error2 / size2), 0.03) << "width " << width;
  }
}

TEST(TorsoPotential, of_a_torso_is_found_by_iteration) {
  const auto torso = recipes::make_torso_surface(150'000);
  const NeutralMesh mesh = preprocess::tetrahedralize(torso.surface);
  ASSERT_GT(mesh.points.size(), 20'000u);
  const auto conductivity = recipes::conductivity_of_cells(mesh, {});
  const Vec3 at = recipes::torso::heart_centre;
  const auto solved = solve_potential(mesh, conductivity, {.at_mm = {at.x, at.y, at.z}, .moment_ma_mm = {20, 0, 0}});
  EXPECT_GT(solved.iteration_count, 10u);
  EXPECT_LT(solved.residual, 1e-9);
  const auto [lo, hi] = std::minmax_element(solved.potential_mv.begin(), solved.potential_mv.end());
  EXPECT_LT(*lo, -5);
  EXPECT_GT(*hi, 5);
}

TEST(TorsoPotential, takes_conductivities_by_region_and_refuses_others) {
  NeutralMesh mesh;
  mesh.cells.resize(3);
  EXPECT_THROW(recipes::conductivity_of_cells(mesh, {}), Error);
  mesh.cell_fields = {
      {.name = "region", .unit = {}, .component_count = 1, .was_single_precision = true, .values = {3, 1, 2}}};
  EXPECT_EQ(recipes::conductivity_of_cells(mesh, {}), (std::vector<double>{0.05, 0.24, 0.4}));
  mesh.cell_fields[0].values[1] = 7;
  EXPECT_THROW(recipes::conductivity_of_cells(mesh, {}), Error);
}

TEST(TorsoPotential, refuses_flat_cells_and_a_dipole_outside) {
  NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
  mesh.cells = {{0, 1, 2, 3}};
  const std::vector<double> even{1.0};
  EXPECT_THROW(solve_potential(mesh, even, {.at_mm = {200, 0, 0}, .moment_ma_mm = {1, 0, 0}}), Error);
  mesh.points[3] = {5, 5, 0};
  EXPECT_THROW(solve_potential(mesh, even, {}), Error);
}

}  // namespace
}  // namespace rhoray::tests

#include "render/kernels/wide/facet_blockers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/ray_questions.h"
#include "tests/agreement/pictures.h"

namespace rhoray::tests {
namespace {

using render::HitBatch;
using render::RayBatch;
using render::StartSide;
using render::wide::LightPlace;

constexpr int edge = 64;
constexpr std::size_t ray_count = static_cast<std::size_t>(edge) * edge;

double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z);
}

/// Boxes of blocks that are not empty.
std::size_t block_count(const render::BoxLevels& levels) {
  std::size_t count = 0;
  for (const render::BoxNode& node : levels.front())
    for (std::size_t c = 0; c < render::BoxNode::size; ++c) count += node.low[0][c] <= node.high[0][c];
  return count;
}

// From every hit that the camera sees, to the light, on the side that the camera is on: the crossings are those of the
// whole surface, to the bit, though a part of it is left out.
TEST(FacetBlockers, hold_back_what_the_whole_surface_does) {
  const TemporaryFolder folder;
  preprocess::NeutralMesh mesh = box_mesh({.cells = {16, 16, 16}, .box = {{-1, -1, -1}, {1, 1, 1}}});
  add_point_field(mesh, "value", waves);
  const render::Volume volume = packed(folder, "mesh.rho", mesh);
  const render::VolumeImplementation& implementation = volume.implementation();
  const render::Question question{.isovalue = 0.2, .method = render::method_of(render::Accuracy::single)};
  const render::Machine machine = render::Machine::baseline;
  const render::Kernel whole = choose_kernels(implementation, question.method, machine).first_crossing;
  const render::wide::BlockerKernel some = render::wide::blocker_kernel(implementation, question.method, machine);
  ASSERT_NE(some, nullptr);

  render::KernelScratch scratch;
  RayBatch rays(ray_count), light_rays(ray_count);
  HitBatch seen(ray_count), by_all(ray_count), by_some(ray_count);
  const render::Camera camera =
      render::fit_camera(volume.bounds(), {.azimuth_deg = 33, .elevation_deg = 31, .zoom = 1.3}, 1);
  const std::vector<render::Ray> of_camera = camera_rays(volume, camera, edge, edge);
  for (std::size_t r = 0; r < ray_count; ++r) rays.set(r, of_camera[r]);
  rays.count = ray_count;
  whole(implementation, question, rays, seen, scratch);

  std::size_t asked = 0, blocked = 0, left_out = 0;
  light_rays.has_start_sides = true;
  const LightPlace lights[] = {{.is_place = false, .at = {1, -2, 1.5}, .reach = 0},
                               {.is_place = false, .at = {-1, -1, 0.1}, .reach = 0.2},
                               {.is_place = true, .at = {0.1, -0.4, 0.9}, .reach = 0},
                               {.is_place = true, .at = {-2, -3, 2}, .reach = 0.3}};
  for (const LightPlace& light : lights)
    for (const StartSide side : {StartSide::outside, StartSide::inside}) {
      const auto blockers = render::wide::blockers_of(implementation, question, light, side, 2);
      ASSERT_TRUE(blockers);
      const std::size_t all = block_count(blockers->facets().levels());
      left_out += all - block_count(blockers->levels());
      std::size_t count = 0;
      for (std::size_t r = 0; r < ray_count; ++r) {
        const render::Hit hit = seen[r];
        if (hit.is_miss()) continue;
        const Vec3 place = of_camera[r].at(hit.t);
        // A point of the light as far from its middle as any may be.
        const Vec3 off = light.reach * Vec3(std::sin(double(r)), std::cos(double(r)), 0);
        const Vec3 way = light.is_place ? light.at + off - place : light.at + off;
        const double along = hit.gradient.dot(of_camera[r].direction);
        const StartSide of_eye = static_cast<StartSide>((along < 0) - (along > 0));
        if (of_eye != side || hit.gradient.dot(way) * static_cast<double>(side) <= 0) continue;
        light_rays.set(count++, {.origin = place,
                                 .direction = way,
                                 .t_max = light.is_place ? 1 : std::numeric_limits<double>::infinity(),
                                 .start_side = side});
      }
      light_rays.count = count;
      whole(implementation, question, light_rays, by_all, scratch);
      some(implementation, question, *blockers, light_rays, by_some, scratch);
      for (std::size_t r = 0; r < count; ++r) {
        ASSERT_EQ(by_some.t[r], by_all.t[r]) << r;
        blocked += !by_all[r].is_miss();
      }
      asked += count;
    }
  EXPECT_GT(asked, 4000U);
  EXPECT_GT(blocked, 500U);
  EXPECT_LT(blocked, asked - 500);
  EXPECT_GT(left_out, 100U);
}

// A ball: of its lit side nothing can hold the light back.
TEST(FacetBlockers, are_the_half_that_is_turned_away_from_the_light) {
  const TemporaryFolder folder;
  preprocess::NeutralMesh mesh = box_mesh({.cells = {24, 24, 24}, .box = {{-1, -1, -1}, {1, 1, 1}}});
  add_point_field(mesh, "value", [](const Vec3& p) { return 0.7 - p.length(); });
  const render::Volume volume = packed(folder, "mesh.rho", mesh);
  const render::Question question{.isovalue = 0.01, .method = render::method_of(render::Accuracy::single)};
  const auto blockers =
      render::wide::blockers_of(volume.implementation(), question, {.at = {0, 0, 1}}, StartSide::outside, 1);
  ASSERT_TRUE(blockers);
  const render::Facets& facets = blockers->facets();
  std::size_t kept_high = 0, kept_low = 0, high = 0, low = 0;
  for (std::size_t n = 0; n < facets.levels().front().size(); ++n)
    for (std::size_t c = 0; c < render::BoxNode::size; ++c) {
      const render::BoxNode &all = facets.levels().front()[n], &kept = blockers->levels().front()[n];
      if (!(all.low[2][c] <= all.high[2][c])) continue;
      const bool is_kept = kept.low[2][c] <= kept.high[2][c];
      if (all.low[2][c] > 0.1F) ++high, kept_high += is_kept;
      if (all.high[2][c] < -0.1F) ++low, kept_low += is_kept;
    }
  EXPECT_GT(high, 50U);
  EXPECT_LT(kept_high, high / 10);
  EXPECT_EQ(kept_low, low);
}

TEST(FacetBlockers, are_of_meshes_in_single_precision_only) {
  const TemporaryFolder folder;
  preprocess::NeutralMesh mesh = box_mesh({});
  add_point_field(mesh, "value", waves);
  const render::Volume of_mesh = packed(folder, "mesh.rho", mesh);
  const Index3 samples(5, 5, 5);
  const render::Volume of_grid =
      packed(folder, "grid.rho", sampled_volume<double>(samples, lattice_over({Vec3(-1), Vec3(1)}, samples), waves));
  const auto kernel = [](const render::Volume& volume, render::Accuracy accuracy, render::Machine machine) {
    return render::wide::blocker_kernel(volume.implementation(), render::method_of(accuracy), machine);
  };
  EXPECT_NE(kernel(of_mesh, render::Accuracy::single, render::Machine::baseline), nullptr);
  EXPECT_EQ(kernel(of_mesh, render::Accuracy::single, render::Machine::scalar), nullptr);
  EXPECT_EQ(kernel(of_mesh, render::Accuracy::twofold, render::Machine::baseline), nullptr);
  EXPECT_EQ(kernel(of_mesh, render::Accuracy::certified, render::Machine::baseline), nullptr);
  EXPECT_EQ(kernel(of_grid, render::Accuracy::single, render::Machine::baseline), nullptr);
}

}  // namespace
}  // namespace rhoray::tests

#include "render/triangles/shadow/facet_occluders.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "render/ray_caster.h"
#include "render/triangles/kernels/facet_kernels.h"
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

/// A rough ball over a rough floor, on which it casts a shadow visible to the camera.
double ball_over_floor(const Vec3& p) {
  const double rough = 0.02 * std::sin(15 * p.x) * std::cos(13 * p.y);
  return std::max(-0.5 - p.z, 0.75 - (p - Vec3(-0.3, 0.3, 0.1)).length()) + rough;
}

// Traces shadow rays from every hit that the camera sees, starting on the camera's side. An any-hit
// query of a part of the surface, or of all of it, must give the same result as the first
// crossings. Rays above all occluders must hit nothing.
struct Answers {
  std::size_t asked = 0, blocked = 0, left_out = 0, above = 0, in_shadow = 0;
};
void expect_the_same_as_first_crossings(render::Machine machine, double (*field)(const Vec3&), Answers& sum) {
  const TemporaryFolder folder;
  preprocess::NeutralMesh mesh = box_mesh({.cells = {32, 32, 32}, .box = {{-1, -1, -1}, {1, 1, 1}}});
  add_point_field(mesh, "value", field);
  const render::Dataset dataset = packed(folder, "mesh.rho", mesh);
  const render::LoadedDataset& implementation = dataset.implementation();
  const render::RayQuery query{.isovalue = 0.2, .method = render::method_of(render::Accuracy::float32)};
  const render::Intersectors chosen = choose_intersectors(implementation, query, machine);
  const render::Kernel whole = chosen.first_hit;
  const render::AnyHitKernel any = chosen.any_hit;
  ASSERT_NE(any, nullptr);

  const auto facets = render::wide::facets_with_occluders(implementation, query, 2);
  ASSERT_TRUE(facets);
  render::KernelScratch scratch;
  RayBatch rays(ray_count), light_rays(ray_count);
  HitBatch seen(ray_count), by_all(ray_count);
  std::vector<std::uint64_t> crossed(ray_count / 64), crossed_of_all(ray_count / 64);
  const render::Camera camera =
      render::fit_camera(dataset.bounds(), {.azimuth_deg = 33, .elevation_deg = 31, .zoom = 1.3}, 1);
  const std::vector<render::Ray> of_camera = camera_rays(dataset, camera, edge, edge);
  for (std::size_t r = 0; r < ray_count; ++r) rays.set(r, of_camera[r]);
  rays.count = ray_count;
  whole(implementation, query, rays, seen, scratch);

  auto& [asked, blocked, left_out, above, in_shadow] = sum;
  light_rays.has_start_sides = true;
  const LightPlace lights[] = {{.is_place = false, .at = {1, -2, 1.5}, .reach = 0},
                               {.is_place = false, .at = {-1, 0.8, 1.2}, .reach = 0},
                               {.is_place = false, .at = {-1, -1, 0.1}, .reach = 0.2},
                               {.is_place = true, .at = {0.1, -0.4, 0.9}, .reach = 0},
                               {.is_place = true, .at = {-2, -3, 2}, .reach = 0.3}};
  for (const LightPlace& light : lights)
    for (const StartSide side : {StartSide::outside, StartSide::inside}) {
      const auto of_light = render::wide::facet_occluders_of(machine, facets, light, render::wide::Shadows::unknown);
      const render::wide::Occluders* occluders = &of_light->of(side);
      left_out += facets_of(*occluders).facets().count() - facets_of(*occluders).count();
      EXPECT_EQ(occluders->heights.has_value(), !light.is_place && light.reach == 0);
      std::size_t count = 0;
      for (std::size_t r = 0; r < ray_count; ++r) {
        const render::Hit hit = seen[r];
        if (hit.is_miss()) continue;
        const Vec3 place = of_camera[r].at(hit.t);
        // A point of the light at the maximum distance from its centre.
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
      whole(implementation, query, light_rays, by_all, scratch);
      any(implementation, query, occluders, light_rays, crossed.data(), scratch);
      any(implementation, query, nullptr, light_rays, crossed_of_all.data(), scratch);
      for (std::size_t r = 0; r < count; ++r) {
        const bool is_crossed = (crossed[r / 64] >> r % 64 & 1) != 0;
        ASSERT_EQ(is_crossed, !by_all[r].is_miss()) << r;
        ASSERT_EQ((crossed_of_all[r / 64] >> r % 64 & 1) != 0, is_crossed) << r;
        blocked += is_crossed;
      }
      const auto with_shadows = render::wide::with_shadows(machine, of_light, light);
      const auto& heights = with_shadows->of(side).heights;
      for (std::size_t first = 0; heights && first < count; first += 64) {
        const std::uint64_t all = count - first < 64 ? (std::uint64_t{1} << (count - first)) - 1 : ~std::uint64_t{0};
        const auto known = heights->know(machine, light_rays, first, all);
        ASSERT_EQ(crossed[first / 64] & all & ~(known.asked | known.in_shadow), 0U);
        ASSERT_EQ(known.in_shadow & ~crossed[first / 64], 0U);
        ASSERT_EQ(occluders->heights->know(machine, light_rays, first, all).asked, known.asked | known.in_shadow);
        above += static_cast<std::size_t>(std::popcount(all & ~(known.asked | known.in_shadow)));
        in_shadow += static_cast<std::size_t>(std::popcount(known.in_shadow));
      }
      asked += count;
    }
}

TEST(FacetOccluders, hold_back_what_the_whole_surface_does) {
  for (const render::Machine machine : {render::Machine::baseline, render::Machine::avx2, render::Machine::avx512}) {
    if (!has_machine(machine)) continue;
    Answers of_waves, of_ball;
    expect_the_same_as_first_crossings(machine, waves, of_waves);
    expect_the_same_as_first_crossings(machine, ball_over_floor, of_ball);
    EXPECT_GT(of_waves.asked, 4000U);
    EXPECT_GT(of_waves.blocked, 500U);
    EXPECT_LT(of_waves.blocked, of_waves.asked - 500);
    EXPECT_GT(of_waves.left_out, 1000U);
    EXPECT_GT(of_waves.above, 200U) << "no ray stands above all blockers: does this test still ask about them?";
    EXPECT_GT(of_ball.in_shadow, 300U) << "no ray starts below a sheet: does this test still ask about them?";
  }
}

// A ball: nothing occludes its lit side.
TEST(FacetOccluders, are_the_half_that_is_turned_away_from_the_light) {
  const TemporaryFolder folder;
  preprocess::NeutralMesh mesh = box_mesh({.cells = {24, 24, 24}, .box = {{-1, -1, -1}, {1, 1, 1}}});
  add_point_field(mesh, "value", [](const Vec3& p) { return 0.7 - p.length(); });
  const render::Dataset dataset = packed(folder, "mesh.rho", mesh);
  const render::RayQuery query{.isovalue = 0.01, .method = render::method_of(render::Accuracy::float32)};
  const LightPlace light{.at = {0, 0, 1}};
  const auto all = render::wide::facets_with_occluders(dataset.implementation(), query, 1);
  ASSERT_TRUE(all);
  const auto of_light =
      render::wide::facet_occluders_of(render::Machine::baseline, all, light, render::wide::Shadows::unknown);
  const render::wide::Occluders* occluders = &of_light->of(StartSide::outside);
  const render::Facets& facets = facets_of(*occluders).facets();
  std::vector<bool> is_left(facets.count(), false);
  for (std::uint32_t f = 0; f < facets_of(*occluders).count(); ++f) is_left[facets_of(*occluders).sources()[f]] = true;
  std::size_t kept_high = 0, kept_low = 0, high = 0, low = 0;
  for (std::uint32_t f = 0; f < facets.count(); ++f) {
    const float z = facets.blocks()[f / 16].corner[0][2][f % 16];
    if (z > 0.1F) ++high, kept_high += is_left[f];
    if (z < -0.1F) ++low, kept_low += is_left[f];
  }
  EXPECT_GT(high, 500U);
  EXPECT_EQ(kept_high, 0U);
  EXPECT_EQ(kept_low, low);
  // Nothing occludes rays from the upper half; from below it, anything may.
  RayBatch rays(64);
  for (std::size_t r = 0; r < 64; ++r)
    rays.set(r, {.origin = {0.05 * static_cast<double>(r % 8), 0.05 * static_cast<double>(r / 8), r % 2 ? 0.69 : -0.9},
                 .direction = {0, 0, 1}});
  EXPECT_EQ(occluders->heights->know(render::Machine::baseline, rays, 0, ~std::uint64_t{0}).asked, 0x5555555555555555U);
  const auto with_shadows = render::wide::with_shadows(render::Machine::baseline, of_light, light);
  const auto known =
      with_shadows->of(StartSide::outside).heights->know(render::Machine::baseline, rays, 0, ~std::uint64_t{0});
  EXPECT_EQ(known.asked, 0U);
  EXPECT_EQ(known.in_shadow, 0x5555555555555555U);
}

TEST(FacetOccluders, are_asked_about_in_single_precision_only) {
  const TemporaryFolder folder;
  preprocess::NeutralMesh mesh = box_mesh({});
  add_point_field(mesh, "value", waves);
  const render::Dataset of_mesh = packed(folder, "mesh.rho", mesh);
  const Index3 samples(5, 5, 5);
  const render::Dataset of_grid =
      packed(folder, "grid.rho", sampled_volume<double>(samples, lattice_over({Vec3(-1), Vec3(1)}, samples), waves));
  const auto kernel = [](const render::Dataset& dataset, render::Accuracy accuracy, render::Machine machine) {
    return render::choose_intersectors(dataset.implementation(), {.method = render::method_of(accuracy)}, machine)
        .any_hit;
  };
  EXPECT_NE(kernel(of_mesh, render::Accuracy::float32, render::Machine::baseline), nullptr);
  EXPECT_EQ(kernel(of_mesh, render::Accuracy::float32, render::Machine::scalar), nullptr);
  EXPECT_EQ(kernel(of_mesh, render::Accuracy::float64, render::Machine::baseline), nullptr);
  EXPECT_EQ(kernel(of_mesh, render::Accuracy::certified, render::Machine::baseline), nullptr);
  EXPECT_EQ(kernel(of_grid, render::Accuracy::float32, render::Machine::baseline), nullptr);
}

}  // namespace
}  // namespace rhoray::tests

#include "render/shadow/occluder_cache.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stop_token>
#include <vector>

#include "render/query/intersectors.h"
#include "tests/agreement/pictures.h"
#include "tests/support/expect_error.h"

namespace rhoray::tests {
namespace {

using render::StartSide;
using render::wide::LightOccluders;
using render::wide::LightPlace;
using render::wide::OccluderCache;

double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z);
}

render::Dataset grid_in(const TemporaryFolder& folder) {
  const Index3 samples(20, 20, 20);
  return packed(folder, "grid.rho", sampled_volume<float>(samples, lattice_over({Vec3(-1), Vec3(1)}, samples), waves));
}
render::Dataset mesh_in(const TemporaryFolder& folder) {
  preprocess::NeutralMesh mesh = box_mesh({.cells = {8, 8, 8}, .box = {{-1, -1, -1}, {1, 1, 1}}});
  add_point_field(mesh, "value", waves);
  return packed(folder, "mesh.rho", mesh);
}

std::shared_ptr<const LightOccluders> occluders_of(OccluderCache& cache, const render::Dataset& dataset,
                                                   double isovalue, const LightPlace& light,
                                                   const std::stop_token& stop = {}) {
  const render::RayQuery query{.isovalue = isovalue, .method = render::method_of(render::Accuracy::float32)};
  const render::LoadedDataset& implementation = dataset.implementation();
  const render::Intersectors chosen = choose_intersectors(implementation, query);
  return chosen.occluders == nullptr
             ? nullptr
             : cache.of(*chosen.occluders, implementation, query, light, render::chosen_machine(), 1, stop);
}

TEST(OccluderCache, finds_those_of_an_isovalue_and_a_light_once) {
  const TemporaryFolder folder;
  for (const render::Dataset& dataset : {grid_in(folder), mesh_in(folder)}) {
    OccluderCache memory;
    const auto of = [&](double isovalue, const LightPlace& light) {
      return occluders_of(memory, dataset, isovalue, light);
    };
    const LightPlace light{.at = {0, 0, 1}};
    const auto first = of(0.2, light), other_isovalue = of(0.3, light), other_light = of(0.2, {.at = {0, 1, 1}});
    ASSERT_TRUE(first && other_isovalue && other_light);
    EXPECT_NE(other_isovalue, first);
    EXPECT_NE(other_light, first);
    const auto second = of(0.2, light);
    EXPECT_EQ(second == first, !dataset.is_mesh()) << "in meshes shadows are added by the second frame";
    EXPECT_EQ(of(0.2, light), second);
    EXPECT_EQ(second->of(StartSide::outside).parts, first->of(StartSide::outside).parts);
    // The oldest of five lights is dropped, and computed again.
    for (int l = 0; l < 4; ++l) of(0.2, {.at = {1, 0, 0.25 * l}});
    EXPECT_NE(of(0.2, light), second);
  }
}

// The cost that would be wasted for an isovalue shown for one frame only arises when the surface is
// requested again; then it covers all lights that follow.
TEST(OccluderCache, knows_shadows_from_the_second_time_on_that_a_surface_is_asked_about) {
  const TemporaryFolder folder;
  preprocess::NeutralMesh mesh = box_mesh({.cells = {24, 24, 24}, .box = {{-1, -1, -1}, {1, 1, 1}}});
  add_point_field(mesh, "value", [](const Vec3& p) { return 0.7 - p.length(); });
  const render::Dataset dataset = packed(folder, "mesh.rho", mesh);
  OccluderCache memory;
  const auto knows_shadows = [&](double isovalue, const LightPlace& light) {
    const auto of_light = occluders_of(memory, dataset, isovalue, light);
    render::RayBatch rays(64);
    for (std::size_t r = 0; r < 64; ++r) rays.set(r, {.origin = {0, 0, -0.9}, .direction = light.at});
    const auto known = of_light->of(StartSide::outside).heights->know(render::Machine::baseline, rays, 0, 1);
    EXPECT_EQ(known.asked + known.in_shadow, 1U) << "the ball stands between";
    return known.in_shadow == 1;
  };
  const LightPlace light{.at = {0, 0, 1}}, moved{.at = {0.1, 0, 1}}, and_again{.at = {0.2, 0, 1}};
  EXPECT_FALSE(knows_shadows(0.01, light));
  EXPECT_TRUE(knows_shadows(0.01, moved));
  EXPECT_TRUE(knows_shadows(0.01, and_again));
  EXPECT_TRUE(knows_shadows(0.01, light));
  EXPECT_FALSE(knows_shadows(0.02, light));
}

/// For rays from a lattice of points, one bit each in words of 64: whether a ray may be occluded,
/// and whether it certainly is.
std::vector<std::uint64_t> known_of(const render::Dataset& dataset, const LightOccluders& of_light, StartSide side,
                                    const LightPlace& light) {
  const Box3& box = dataset.implementation().bounds_data;
  std::vector<std::uint64_t> known;
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y) {
      render::RayBatch rays(64);
      for (int x = 0; x < 64; ++x)
        rays.set(static_cast<std::size_t>(x),
                 {.origin = box.min + Vec3(x / 63.0, y / 7.0, z / 7.0) * box.size(), .direction = light.at});
      const auto of = of_light.of(side).heights->know(render::Machine::baseline, rays, 0, ~std::uint64_t{0});
      known.push_back(of.asked), known.push_back(of.in_shadow);
    }
  return known;
}

// The first request computes no certain shadows, the second one does.
TEST(OccluderCache, keeps_nothing_of_a_search_that_was_stopped) {
  const TemporaryFolder folder, another;
  std::stop_source stop;
  stop.request_stop();
  const LightPlace light{.at = {0.3, 0.2, 1}};
  for (const auto& data_in : {grid_in, mesh_in}) {
    const render::Dataset dataset = data_in(folder), other = data_in(another);
    OccluderCache memory, of_other;
    for (int time = 0; time < 2; ++time)
      expect_error(ErrorCode::interrupted, "interrupted",
                   [&] { occluders_of(memory, dataset, 0.2, light, stop.get_token()); });
    for (int request = 0; request < 2; ++request) {
      const auto of_light = occluders_of(memory, dataset, 0.2, light),
                 expected = occluders_of(of_other, other, 0.2, light);
      ASSERT_TRUE(of_light && expected);
      for (const StartSide side : {StartSide::outside, StartSide::inside}) {
        const bool is_known = request == 1 && !dataset.is_mesh();
        for (int time = 0; time < 2 && !is_known; ++time)
          expect_error(ErrorCode::interrupted, "interrupted", [&] { of_light->of(side, stop.get_token()); });
        EXPECT_EQ(known_of(dataset, *of_light, side, light), known_of(other, *expected, side, light));
        EXPECT_EQ(&of_light->of(side, stop.get_token()), &of_light->of(side));
      }
    }
  }
}

// For a light at a position, or with a size, the facets are known; cells are not.
TEST(OccluderCache, keeps_facets_for_lights_of_all_kinds) {
  const TemporaryFolder folder;
  const render::Dataset grid = grid_in(folder), mesh = mesh_in(folder);
  OccluderCache memory;
  const auto of = [&](const render::Dataset& dataset, const LightPlace& light) {
    return occluders_of(memory, dataset, 0.2, light);
  };
  const LightPlace lights[] = {{.is_place = true, .at = {0, 0, 3}},
                               {.is_place = false, .at = {0, 0, 3}},
                               {.is_place = false, .at = {0, 0, 3}, .reach = 0.1}};
  std::shared_ptr<const LightOccluders> before;
  for (const LightPlace& light : lights) {
    const auto of_mesh = of(mesh, light);
    ASSERT_TRUE(of_mesh);
    EXPECT_NE(of_mesh, before);
    EXPECT_EQ(of_mesh->of(StartSide::inside).heights.has_value(), light.is_one_direction());
    EXPECT_EQ(of(grid, light) != nullptr, light.is_one_direction());
    before = of_mesh;
  }
}

}  // namespace
}  // namespace rhoray::tests

#include "render/grid/shadow/grid_occluders.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "render/ray_caster.h"
#include "tests/agreement/pictures.h"

namespace rhoray::tests {
namespace {

using render::HitBatch;
using render::RayBatch;
using render::StartSide;
using render::wide::SurfaceCells;

constexpr int edge = 64;
constexpr std::size_t ray_count = static_cast<std::size_t>(edge) * edge;

render::RayQuery query_of(double isovalue) {
  return {.isovalue = isovalue, .method = render::method_of(render::Accuracy::float32)};
}

/// Traces shadow rays from every hit that the camera sees, from sides and directions of all kinds.
template <class T, class Field>
void expect_nothing_above_to_be_held_back(const Field& field, double isovalue, const Index3& samples) {
  const TemporaryFolder folder;
  const render::Dataset dataset =
      packed(folder, "grid.rho", sampled_volume<T>(samples, lattice_over({Vec3(-1), Vec3(1)}, samples), field));
  const render::LoadedDataset& implementation = dataset.implementation();
  const render::RayQuery query = query_of(isovalue);
  const render::Kernel kernel = choose_intersectors(implementation, query, render::Machine::baseline).first_hit;
  const auto cells = SurfaceCells::of(implementation, query, 2);
  ASSERT_TRUE(cells);
  render::KernelScratch scratch;
  RayBatch rays(ray_count), light_rays(ray_count);
  HitBatch seen(ray_count), met(ray_count), met_before_ends(ray_count);
  std::size_t blocked = 0, above = 0, asked = 0, ended = 0;
  for (const double azimuth : {33.0, 200.0}) {
    const render::Camera camera =
        render::fit_camera(dataset.bounds(), {.azimuth_deg = azimuth, .elevation_deg = 31, .zoom = 1.3}, 1);
    const std::vector<render::Ray> of_camera = camera_rays(dataset, camera, edge, edge);
    for (std::size_t r = 0; r < ray_count; ++r) rays.set(r, of_camera[r]);
    rays.count = ray_count;
    kernel(implementation, query, rays, seen, scratch);
    light_rays.has_start_sides = true;
    for (const Vec3& light : {Vec3(1, -2, 1.5), Vec3(-1, -1, 0.1), Vec3(0, 0, 1), Vec3(0.3, 0.7, -2), Vec3(-3, 1, 1)})
      for (const StartSide side : {StartSide::outside, StartSide::inside}) {
        const auto by_baseline = render::wide::grid_occluders_of(render::Machine::baseline, cells, {.at = light}),
                   by_chosen = render::wide::grid_occluders_of(render::chosen_machine(), cells, {.at = light});
        ASSERT_TRUE(by_baseline->of(side).heights && by_chosen->of(side).heights);
        std::size_t count = 0;
        for (std::size_t r = 0; r < ray_count; ++r) {
          const render::Hit hit = seen[r];
          if (hit.is_miss()) continue;
          const double along = hit.gradient.dot(of_camera[r].direction);
          const StartSide of_eye = static_cast<StartSide>((along < 0) - (along > 0));
          if (of_eye != side || hit.gradient.dot(light) * static_cast<double>(side) <= 0) continue;
          light_rays.set(count++, {.origin = of_camera[r].at(hit.t), .direction = light, .start_side = side});
        }
        light_rays.count = count;
        kernel(implementation, query, light_rays, met, scratch);
        for (std::size_t first = 0; first < count; first += 64) {
          const std::uint64_t all = count - first < 64 ? (std::uint64_t{1} << (count - first)) - 1 : ~std::uint64_t{0};
          for (const render::Machine machine : {render::Machine::baseline, render::chosen_machine()}) {
            const auto known = by_baseline->of(side).heights->know(machine, light_rays, first, all);
            ASSERT_EQ(by_chosen->of(side).heights->know(machine, light_rays, first, all).asked, known.asked);
            ASSERT_EQ(known.in_shadow, 0U);
            for (std::size_t i = 0; i < 64 && first + i < count; ++i) {
              const bool is_asked = (known.asked >> i & 1) != 0;
              ASSERT_TRUE(is_asked || met[first + i].is_miss()) << first + i;
              ended += is_asked && light_rays[first + i].t_max < std::numeric_limits<double>::infinity();
            }
            above += static_cast<std::size_t>(std::popcount(all & ~known.asked));
          }
        }
        // A ray shortened to end above all its possible occluders hits the same as one without an
        // end.
        kernel(implementation, query, light_rays, met_before_ends, scratch);
        for (std::size_t r = 0; r < count; ++r)
          if (light_rays[r].t_max >= 0) {
            ASSERT_EQ(met_before_ends[r].is_miss(), met[r].is_miss()) << r;
          }
        for (std::size_t r = 0; r < count; ++r) blocked += !met[r].is_miss();
        asked += count;
      }
  }
  EXPECT_GT(asked, 2000U);
  EXPECT_GT(blocked, 100U);
  EXPECT_GT(above, 200U) << "no ray stands above all blockers: does this test still ask about them?";
  EXPECT_GT(ended, 200U);
}

double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z);
}

// A ray that is classified as above all its possible occluders is never occluded.
TEST(GridOccluders, keep_every_ray_that_is_held_back) {
  expect_nothing_above_to_be_held_back<float>(waves, 0.2, {61, 58, 66});
  expect_nothing_above_to_be_held_back<double>([](const Vec3& p) { return 1e6 * waves(p); }, -2e5, {43, 50, 37});
}

// With integer values a surface has steps, and edges along which the field is constant.
TEST(GridOccluders, keep_them_where_values_are_whole_numbers) {
  expect_nothing_above_to_be_held_back<std::uint8_t>([](const Vec3& p) { return 8 + 3 * waves(p); }, 8.5, {49, 49, 49});
}

// A ball: its lit side occludes nothing, and the side facing away does.
TEST(GridOccluders, are_turned_away_from_the_light) {
  const TemporaryFolder folder;
  const Index3 samples(65, 65, 65);
  const render::Dataset dataset = packed(folder, "grid.rho",
                                         sampled_volume<float>(samples, lattice_over({Vec3(-1), Vec3(1)}, samples),
                                                               [](const Vec3& p) { return 0.7 - p.length(); }));
  const auto cells = SurfaceCells::of(dataset.implementation(), query_of(0.01), 1);
  ASSERT_TRUE(cells);
  const auto of_light = render::wide::grid_occluders_of(render::Machine::baseline, cells, {.at = {0, 0, 1}});
  const render::wide::Occluders* occluders = &of_light->of(StartSide::outside);
  ASSERT_TRUE(occluders->heights);
  // In cells: over the middle, half of the rays on the upper side, half below everything.
  RayBatch rays(64);
  for (std::size_t r = 0; r < 64; ++r)
    rays.set(r, {.origin = {28.0 + static_cast<double>(r % 8), 28.0 + static_cast<double>(r / 8), r % 2 ? 54.0 : 4.0},
                 .direction = {0, 0, 1}});
  EXPECT_EQ(occluders->heights->know(render::Machine::baseline, rays, 0, ~std::uint64_t{0}).asked, 0x5555555555555555U);
}

// The field may rise from one side of a gap to the other, and in no cell.
TEST(GridOccluders, are_not_known_where_data_have_gaps) {
  const TemporaryFolder folder;
  const Index3 samples(20, 20, 20);
  const auto with_gap = [](const Vec3& p) {
    return p.length() < 0.3 ? std::numeric_limits<double>::quiet_NaN() : waves(p);
  };
  const render::Dataset dataset =
      packed(folder, "grid.rho", sampled_volume<float>(samples, lattice_over({Vec3(-1), Vec3(1)}, samples), with_gap));
  EXPECT_EQ(SurfaceCells::of(dataset.implementation(), query_of(0.2), 1), nullptr);
}

}  // namespace
}  // namespace rhoray::tests

// Parity. A ray that starts outside a closed surface hits it exactly when the field on the ray
// reaches the isovalue. This holds for noise with up to three roots in a cell (R10, R23) too, and
// wherever the ray runs.
#include <gtest/gtest.h>

#include <cmath>

#include "render/traverse/lattice_walk.h"
#include "render/traverse/ray_box.h"
#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

TEST(ClosedSurfaces, are_hit_exactly_when_the_field_on_the_ray_reaches_the_isovalue) {
  const Index3 count(8, 8, 8), cells(7, 7, 7);
  const Samples samples = [](const Index3& at) {
    if (at.x == 0 || at.y == 0 || at.z == 0 || at.x == 7 || at.y == 7 || at.z == 7) return -1000.0;
    const auto hash = static_cast<std::uint64_t>((at.z * 101 + at.y) * 103 + at.x) * 0x9e3779b97f4a7c15U;
    return static_cast<double>((hash >> 33) % 2000) - 1000;
  };
  TracedDataset traced(volume_of<double>(count, samples), {.macro_factor = 2});
  int hits = 0, misses = 0, too_close = 0, missed_by_ends = 0;
  for (render::Ray ray : stressful_rays({7, 7, 7}, 20000, 1)) {
    if (std::abs(ray.direction.length() - 1) > 0.5 || ray.origin.length() > 1e4) continue;
    ray.origin -= 30.0 * ray.direction;
    ray.t_min = 0;
    ray.t_max = HUGE_VAL;
    const auto largest = largest_by_brute_force(samples, cells, ray);
    if (!largest) continue;
    const double iso = 250;
    if (std::abs(*largest - iso) < 1e-6) {
      ++too_close;
      continue;
    }
    const render::Hit hit = traced.first_crossing(ray, iso);
    ASSERT_EQ(!hit.is_miss(), *largest > iso) << ray.origin << " + t " << ray.direction;
    (hit.is_miss() ? misses : hits)++;
    missed_by_ends += *largest > iso && *largest_by_brute_force(samples, cells, ray, true) < iso;
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 300);
  EXPECT_LT(too_close, 30);
  EXPECT_GT(missed_by_ends, 10) << "values at the faces tell: is this case still the hard one?";
}

}  // namespace
}  // namespace rhoray::tests

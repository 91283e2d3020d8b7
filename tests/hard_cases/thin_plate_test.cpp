// V22. A plate one sample thick: steps of one cell pass through it without seeing it.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

TEST(ThinPlate, is_hit_by_every_ray_through_it) {
  const Index3 count(24, 24, 24), cells(23, 23, 23);
  const Samples samples = [](const Index3& at) { return at.y == 11 ? 100.0 : 0.0; };
  TracedDataset traced(
      volume_of<std::uint8_t>(count, [&](const Index3& at) { return static_cast<std::uint8_t>(samples(at)); }));
  Dice dice(1);
  int missed = 0, missed_by_steps = 0, rays = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Vec3 target = dice.point({6, 11, 6}, {17, 11, 17}), direction = dice.direction();
    if (std::abs(direction.y) < 0.7) continue;
    const render::Ray ray{.origin = target - 30.0 * direction, .direction = direction};
    const render::Hit hit = traced.first_crossing(ray, 80);
    missed += hit.is_miss();
    if (!hit.is_miss()) {
      // The value 80 is a fifth of a cell before the plate.
      EXPECT_NEAR(hit.t, 30 - 0.2 / std::abs(direction.y), 1e-12);
    }
    const auto part = part_in_box(ray, {0, 0, 0}, {23, 23, 23});
    bool seen = false;
    for (double t = (*part)[0]; t <= (*part)[1]; t += 1)
      seen = seen || interpolated(samples, cell_of(ray.at(t), cells), ray.at(t)) >= 80;
    missed_by_steps += !seen;
    ++rays;
  }
  EXPECT_EQ(missed, 0);
  EXPECT_GT(missed_by_steps, rays / 3) << "steps of a cell no longer miss it: is this case still the hard one?";
}

}  // namespace
}  // namespace rhoray::tests

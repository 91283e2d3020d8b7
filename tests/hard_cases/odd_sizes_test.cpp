// V14, V15, V07. Sizes that are not multiples of a brick or macrocell, down to one layer of cells.
// Bricks are padded with copies; a method that looks into the padding finds a surface that does not
// exist.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

TEST(OddSizes, show_the_volume_and_nothing_of_its_padding) {
  int hits = 0, padded = 0;
  for (const Index3& count :
       {Index3(2, 2, 2), Index3(2, 7, 33), Index3(7, 5, 3), Index3(9, 2, 9), Index3(17, 16, 15), Index3(65, 2, 2)}) {
    const Vec3 size(static_cast<double>(count.x - 1), static_cast<double>(count.y - 1),
                    static_cast<double>(count.z - 1));
    const Vec3 slope(1, 1.5, -0.5);
    TracedDataset traced(sampled_volume<double>(count, {}, linear_field(slope)));
    const auto& layout =
        std::get<render::UniformGrid>(traced.dataset().implementation().view).packed()->description().layout;
    padded += volume(layout.padded_count()) > volume(count);
    Dice dice(1);
    for (int trial = 0; trial < 1000; ++trial) {
      Vec3 direction = dice.direction();
      if (dice.below(4) == 0) direction = {1, 0, 0};
      // Rays pass beside the volume too, where the padding would be.
      const double reach = 0.2 * size.length();
      const Vec3 target = dice.point(Vec3(-reach, -reach, -reach), size + Vec3(reach, reach, reach));
      const render::Ray ray{.origin = target - 200.0 * direction, .direction = direction};
      const double iso = slope.dot(dice.point({0, 0, 0}, size));
      const double t = (iso - slope.dot(ray.origin)) / slope.dot(direction);
      const Vec3 p = ray.at(t);
      double inset = HUGE_VAL;
      for (int axis = 0; axis < 3; ++axis) inset = std::min({inset, p[axis], size[axis] - p[axis]});
      if (!(std::abs(inset) > 1e-9)) continue;
      const render::Hit hit = traced.first_crossing(ray, iso);
      ASSERT_EQ(hit.is_miss(), inset < 0) << count;
      if (hit.is_miss()) continue;
      EXPECT_NEAR(hit.t, t, 1e-10);
      ++hits;
      // The linear field is largest at one end of the ray's part in the volume.
      const render::Hit top = traced.largest_value(ray);
      EXPECT_NEAR(slope.dot(ray.at(top.t)), top.value, 1e-10);
      EXPECT_GE(top.value, iso - 1e-10);
    }
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(padded, 3) << "no layout is padded: is this case still the hard one?";
}

}  // namespace
}  // namespace rhoray::tests

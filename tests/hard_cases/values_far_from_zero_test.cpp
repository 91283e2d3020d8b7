// R27, D04, D05. Values of a million that differ by one, and values of any magnitude: the surface
// depends on differences only. A method that forms coefficients before it subtracts the isovalue
// loses those digits. A method that compares with a fixed tolerance sees a surface everywhere, or
// nowhere.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

/// Multiples of a sixteenth, so that a float holds them exactly after a million is added.
float rough(const Index3& at) {
  const auto hash = static_cast<std::uint64_t>((at.z * 101 + at.y) * 103 + at.x) * 0x9e3779b97f4a7c15U;
  return static_cast<float>((hash >> 33) % 33) / 16 - 1;
}

std::vector<render::Ray> some_rays() {
  return stressful_rays({10, 9, 11}, 1500, 1);
}

TEST(ValuesFarFromZero, give_the_hits_of_the_same_values_near_zero_bit_for_bit) {
  TracedDataset near(volume_of<float>({11, 10, 12}, rough));
  TracedDataset far(volume_of<float>({11, 10, 12}, [](const Index3& at) { return rough(at) + 1e6F; }));
  int hits = 0, changed_without_subtraction = 0;
  for (const render::Ray& ray : some_rays()) {
    const render::Hit a = near.first_crossing(ray, 0.3125), b = far.first_crossing(ray, 1e6 + 0.3125);
    EXPECT_EQ(a.t, b.t);
    EXPECT_EQ(a.cell, b.cell);
    EXPECT_EQ(a.gradient, b.gradient);
    hits += !a.is_miss();
  }
  Dice dice(2);
  for (int trial = 0; trial < 1000; ++trial) {
    render::TrilinearCell cell, raised;
    for (std::size_t c = 0; c < 8; ++c)
      raised.corner[c] = (cell.corner[c] = static_cast<double>(dice.below(33)) / 16 - 1) + 1e6;
    const Vec3 p = dice.point({0, 0, 0}, {1, 1, 1});
    changed_without_subtraction += raised.at(p) - 1e6 != cell.at(p);
  }
  EXPECT_GT(hits, 700);
  EXPECT_GT(changed_without_subtraction, 500) << "is this case still the hard one?";
}

TEST(ValuesFarFromZero, scaled_by_a_power_of_two_give_the_same_hits_bit_for_bit) {
  TracedDataset plain(volume_of<double>({11, 10, 12}, rough));
  for (const int power : {-900, -100, -1, 3, 100, 900}) {
    TracedDataset scaled(volume_of<double>(
        {11, 10, 12}, [=](const Index3& at) { return std::ldexp(static_cast<double>(rough(at)), power); }));
    for (const render::Ray& ray : some_rays()) {
      const render::Hit a = plain.first_crossing(ray, 0.3), b = scaled.first_crossing(ray, std::ldexp(0.3, power));
      ASSERT_EQ(a.t, b.t) << "2^" << power;
      ASSERT_EQ(a.cell, b.cell);
      const render::Hit top = plain.largest_value(ray), scaled_top = scaled.largest_value(ray);
      ASSERT_EQ(top.t, scaled_top.t);
      ASSERT_EQ(top.is_miss() ? 0 : std::ldexp(top.value, power), top.is_miss() ? 0 : scaled_top.value);
    }
  }
}

TEST(ValuesFarFromZero, in_space_scaled_by_a_power_of_two_scale_t_exactly) {
  TracedDataset plain(volume_of<float>({11, 10, 12}, rough));
  Affine map;
  map.x_axis = {0x1p-20, 0, 0}, map.y_axis = {0, 0x1p-20, 0}, map.z_axis = {0, 0, 0x1p-20};
  TracedDataset small(volume_of<float>({11, 10, 12}, rough, map));
  for (const render::Ray& ray : some_rays()) {
    const double smallest = std::min({std::abs(ray.direction.x), std::abs(ray.direction.y), std::abs(ray.direction.z)});
    if (smallest != 0 && smallest < 1e-200) continue;  // denormal components do not scale
    render::Ray scaled = ray;                          // the same directions: t is a length
    scaled.origin *= 0x1p-20;
    scaled.t_min *= 0x1p-20;
    scaled.t_max *= 0x1p-20;
    const render::Hit a = plain.first_crossing(ray, 0.3), b = small.first_crossing(scaled, 0.3);
    ASSERT_EQ(a.t * 0x1p-20, b.t);
    ASSERT_EQ(a.cell, b.cell);
  }
}

}  // namespace
}  // namespace rhoray::tests

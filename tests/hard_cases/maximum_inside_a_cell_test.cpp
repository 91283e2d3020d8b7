// M01. Along a ray the trilinear field is a cubic, so its largest value may lie inside a cell. The
// rule of the paper's section 4.3 (values on the faces) does not look there.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

TEST(MaximumInsideACell, is_found_by_the_exact_method_and_missed_by_the_face_rule) {
  const Index3 count(7, 7, 7), cells(6, 6, 6);
  const Samples samples = [](const Index3& at) {
    const auto hash = static_cast<std::uint64_t>((at.z * 101 + at.y) * 103 + at.x) * 0x9e3779b97f4a7c15U;
    return static_cast<double>((hash >> 33) % 1000);
  };
  TracedDataset traced(volume_of<double>(count, samples));
  Dice dice(1);
  int rays = 0, too_low = 0;
  double furthest = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Vec3 direction = dice.direction();
    const render::Ray ray{.origin = dice.point({0, 0, 0}, {6, 6, 6}) - 20.0 * direction, .direction = direction};
    const auto truth = largest_by_brute_force(samples, cells, ray);
    if (!truth) continue;
    const double exact = traced.largest_value(ray).value;
    const double face = traced.largest_value(ray, face_rule).value;
    EXPECT_NEAR(exact, *truth, 1e-8);
    EXPECT_LE(face, exact + 1e-9);
    too_low += face < exact - 1;
    furthest = std::max(furthest, exact - face);
    ++rays;
  }
  EXPECT_GT(rays, 1000);
  EXPECT_GT(too_low, rays / 20) << "the face rule is right: is this case still the hard one?";
  EXPECT_GT(furthest, 50);
}

}  // namespace
}  // namespace rhoray::tests

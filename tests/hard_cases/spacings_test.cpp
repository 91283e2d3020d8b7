// X07. Spacings that are zero, negative, denormal, very small or very large. The map into the grid
// divides by them, and a picture of infinities and NaN is empty. Negative spacings mirror
// (tests/agreement/mirror_test.cpp).
#include <gtest/gtest.h>

#include <cmath>

#include "formats/base/invertible.h"
#include "tests/agreement/pictures.h"
#include "tests/support/expect_error.h"

namespace rhoray::tests {
namespace {

preprocess::NeutralVolume ball_with_spacing(const Vec3& spacing) {
  return volume_of<float>({12, 12, 12},
                          [](const Index3& at) {
                            const Vec3 p(static_cast<double>(at.x), static_cast<double>(at.y),
                                         static_cast<double>(at.z));
                            return static_cast<float>((p - Vec3(5.4, 5.6, 5.5)).length());
                          },
                          {{spacing.x, 0, 0}, {0, spacing.y, 0}, {0, 0, spacing.z}, {0, 0, 0}});
}

TEST(Spacings, without_an_inverse_are_refused) {
  const TemporaryFolder folder;
  int passed_over = 0;
  for (const Vec3& spacing : {Vec3(0, 1, 1), Vec3(1, 1e-320, 1), Vec3(1e-310, 1e300, 1), Vec3(1e-160), Vec3(1e200),
                              Vec3(1, 1, std::nan("")), Vec3(1, HUGE_VAL, 1)}) {
    const preprocess::NeutralVolume ball = ball_with_spacing(spacing);
    EXPECT_FALSE(is_invertible(ball.world_from_grid));
    expect_error(ErrorCode::invalid, "expected three independent, finite axes",
                 [&] { preprocess::pack_volume(ball, folder / "ball.rho"); });
    const double determinant = ball.world_from_grid.determinant();
    passed_over += determinant != 0 && std::isfinite(determinant);
  }
  EXPECT_GT(passed_over, 1) << "the determinant tells them all: is this case still the hard one?";
}

TEST(Spacings, small_and_large_and_negative_ones_show_the_same) {
  const TemporaryFolder folder;
  const render::Dataset unit = packed(folder, "unit.rho", ball_with_spacing(Vec3(1)));
  const render::Framebuffer expected = picture(unit, oblique_scene(unit, 4));
  EXPECT_GT(hit_count(expected), 1000U);
  for (const int power : {-300, -100, 100, 300}) {
    const double scale = std::ldexp(1.0, power);
    const render::Dataset scaled = packed(folder, concat("scaled", power, ".rho"), ball_with_spacing(Vec3(scale)));
    const render::Framebuffer made = picture(scaled, oblique_scene(scaled, 4));
    EXPECT_EQ(made.cell, expected.cell) << power;
  }
  const render::Dataset mirrored = packed(folder, "mirrored.rho", ball_with_spacing({1, -1, 1}));
  const std::size_t hits = hit_count(picture(mirrored, oblique_scene(mirrored, 4)));
  EXPECT_NEAR(static_cast<double>(hits), static_cast<double>(hit_count(expected)), 60);
}

}  // namespace
}  // namespace rhoray::tests

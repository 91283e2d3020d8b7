#include "tools/view/motion_pixels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace rhoray::tests {
namespace {

using tools::MotionPixels;

constexpr render::PictureSize canvas{1000, 1000};

/// A machine and a client.
struct Pace {
  double ms_per_megapixel;
  double preparation_ms;
  double client_ms;              ///< to draw a picture
  double display_ms = 1e3 / 60;  ///< between requests
};

/// Width of the pictures after some seconds of motion, in which a picture that the client cannot
/// draw yet waits there.
int width_at(const Pace& pace) {
  MotionPixels motion;
  int width = 0;
  double now = 0, client_is_free = 0;
  for (int picture = 0; picture < 500; ++picture) {
    const render::PictureSize size = motion.size_for(canvas);
    width = size.width;
    const double ms = pace.preparation_ms + 1e-6 * size.width * size.height * pace.ms_per_megapixel;
    const double sent = now + ms, drawn = std::max(sent, client_is_free) + pace.client_ms;
    motion.took(ms, pace.preparation_ms, size);
    motion.drawn({drawn - now - pace.preparation_ms, drawn - sent, client_is_free <= sent});
    // No more than two pictures are under way.
    now = std::max({now + pace.display_ms, sent, client_is_free});
    client_is_free = drawn;
  }
  return width;
}

TEST(MotionPixels, are_as_many_as_can_be_made_in_13_ms) {
  EXPECT_NEAR(width_at({.ms_per_megapixel = 130, .preparation_ms = 0, .client_ms = 3}), std::sqrt(0.1e6), 5);
  EXPECT_EQ(width_at({.ms_per_megapixel = 1, .preparation_ms = 0, .client_ms = 3}), 1000);
  EXPECT_EQ(width_at({.ms_per_megapixel = 1e9, .preparation_ms = 0, .client_ms = 3}), 63);  // a 16th
}

TEST(MotionPixels, are_fewer_for_a_client_that_draws_slowly) {
  // It draws 50 pictures a second, fewer than there are requests.
  const int width = width_at({.ms_per_megapixel = 130, .preparation_ms = 0, .client_ms = 20});
  EXPECT_NEAR(width, std::sqrt(1e6 * 5 / 130), 10);
}

TEST(MotionPixels, do_not_depend_on_how_far_the_client_is_away) {
  // A picture takes 100 ms to the client, but does not wait there.
  MotionPixels motion;
  for (int picture = 0; picture < 100; ++picture) {
    motion.took(13, 0, {316, 316});
    motion.drawn({113, 100, picture == 0});
  }
  EXPECT_NEAR(motion.size_for(canvas).width, 316, 5);
}

TEST(MotionPixels, have_a_third_of_the_time_where_an_isovalue_takes_more_than_the_rest) {
  EXPECT_NEAR(width_at({.ms_per_megapixel = 130, .preparation_ms = 5, .client_ms = 3}), std::sqrt(1e6 * 8 / 130), 5);
  EXPECT_NEAR(width_at({.ms_per_megapixel = 130, .preparation_ms = 200, .client_ms = 3}), std::sqrt(1e6 * 13 / 3 / 130),
              5);
}

}  // namespace
}  // namespace rhoray::tests

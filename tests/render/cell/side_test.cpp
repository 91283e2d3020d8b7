#include "render/cell/side.h"

#include <gtest/gtest.h>

namespace rhoray::tests {
namespace {

TEST(IsInside, is_true_from_the_isovalue_upwards) {
  EXPECT_TRUE(render::is_inside(0.0));
  EXPECT_TRUE(render::is_inside(-0.0));
  EXPECT_TRUE(render::is_inside(5e-324));
  EXPECT_TRUE(render::is_inside(1e300));
  EXPECT_FALSE(render::is_inside(-5e-324));
  EXPECT_FALSE(render::is_inside(-1e300));
}

}  // namespace
}  // namespace rhoray::tests

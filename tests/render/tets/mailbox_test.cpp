#include "render/tets/reference/mailbox.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <set>

namespace rhoray::tests {
namespace {

TEST(Mailbox, tell_what_is_new_as_a_set_does) {
  // Remainders that separate them, and ones that do not.
  for (const std::uint32_t spread : {1U, 64U, 256U, 4096U}) {
    std::mt19937 random(spread);
    render::Mailbox met;
    std::set<std::uint32_t> expected;
    for (int i = 0; i < 2000; ++i) {
      const std::uint32_t tet = std::uniform_int_distribution<std::uint32_t>(0, 699)(random) * spread;
      ASSERT_EQ(met.add(tet), expected.insert(tet).second) << tet << " as number " << i;
    }
    EXPECT_GT(expected.size(), 600U);
  }
}

TEST(Mailbox, take_the_last_position_for_new_again_and_stay_right_for_others) {
  constexpr auto last = std::numeric_limits<std::uint32_t>::max();
  render::Mailbox met;
  for (int i = 0; i < 300; ++i) ASSERT_TRUE(met.add(last));
  EXPECT_TRUE(met.add(7));
  EXPECT_FALSE(met.add(7));
}

}  // namespace
}  // namespace rhoray::tests

#include "formats/base/nearest_name.h"

#include <gtest/gtest.h>

#include <vector>

namespace rhoray::tests {
namespace {

TEST(Nearest, counts_letters_dropped_added_changed_and_exchanged) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("abc", ""), 3U);
  EXPECT_EQ(edit_distance("bone", "bone"), 0U);
  EXPECT_EQ(edit_distance("bone", "bond"), 1U);
  EXPECT_EQ(edit_distance("bone", "bones"), 1U);
  EXPECT_EQ(edit_distance("bone", "bne"), 1U);
  EXPECT_EQ(edit_distance("bone", "obne"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Nearest, takes_the_closest_name_and_none_that_is_far) {
  const std::vector<std::string> names{"pack", "render", "verify", "--surface-color"};
  EXPECT_EQ(nearest("rendr", names), "render");
  EXPECT_EQ(nearest("VERIFY", names), "verify");
  EXPECT_EQ(nearest("--surf", names), "--surface-color");
  EXPECT_EQ(nearest("pakc", names), "pack");
  EXPECT_EQ(nearest("import", names), std::nullopt);
  EXPECT_EQ(nearest("", names), std::nullopt);
  EXPECT_EQ(nearest("x", {}), std::nullopt);
}

}  // namespace
}  // namespace rhoray::tests

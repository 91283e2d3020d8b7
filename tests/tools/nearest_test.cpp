#include "tools/rhoray/nearest.h"

#include <vector>

#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tools {
namespace {

using tests::expect_error;

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

TEST(Nearest, names_the_file_that_was_probably_meant) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder / "bone.vtu", "");
  tests::write_file(folder / "skin.vtu", "");
  try {
    require_input(folder / "bome.vtu");
    FAIL() << "a missing file was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.trouble(), Trouble::unreadable);
    EXPECT_EQ(error.hint(), "did you mean bone.vtu?");
  }
  EXPECT_NO_THROW(require_input(folder / "bone.vtu"));
  expect_error(Trouble::unreadable, "is a folder", [&] { require_input(folder.path()); });
  expect_error(Trouble::unreadable, "no folder", [&] { require_input(folder / "nowhere/bone.vtu"); });
}

}  // namespace
}  // namespace rhoray::tools

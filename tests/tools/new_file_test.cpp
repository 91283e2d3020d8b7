#include "tools/rhoray/new_file.h"

#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tools {
namespace {

std::size_t file_count(const tests::TemporaryFolder& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder.path()), {}));
}

TEST(NewFile, has_no_name_until_it_is_whole) {
  const tests::TemporaryFolder folder;
  {
    NewFile file(folder / "a.txt");
    file.write("half");
    EXPECT_EQ(file_count(folder), 0U);
  }
  EXPECT_EQ(file_count(folder), 0U);
  write_new_file(folder / "a.txt", "whole", false);
  EXPECT_EQ(tests::read_file(folder / "a.txt"), "whole");
}

TEST(NewFile, replaces_another_only_when_told_to) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder / "a.txt", "old");
  tests::expect_error(Trouble::usage, "is there already", [&] { write_new_file(folder / "a.txt", "new", false); });
  EXPECT_EQ(tests::read_file(folder / "a.txt"), "old");
  write_new_file(folder / "a.txt", "new", true);
  EXPECT_EQ(tests::read_file(folder / "a.txt"), "new");
  EXPECT_EQ(file_count(folder), 1U);
  tests::expect_error(Trouble::resource, "nowhere", [&] { write_new_file(folder / "nowhere/a.txt", "new", true); });
}

TEST(NewFile, can_be_opened_by_a_library_while_it_has_no_name) {
  const tests::TemporaryFolder folder;
  NewFile file(folder / "a.txt");
  tests::write_file(file.open_name(), "from a library");
  file.commit(false);
  EXPECT_EQ(tests::read_file(folder / "a.txt"), "from a library");
}

}  // namespace
}  // namespace rhoray::tools

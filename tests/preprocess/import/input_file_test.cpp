#include "preprocess/input_file.h"

#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using tests::expect_error;

TEST(InputFile, that_is_missing_is_refused_with_the_nearest_name) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder / "bone.vtu", "");
  tests::write_file(folder / "skin.vtu", "");
  try {
    require_input(folder / "bome.vtu");
    FAIL() << "a missing file was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unreadable);
    EXPECT_EQ(error.hint(), "did you mean bone.vtu?");
  }
  EXPECT_NO_THROW(require_input(folder / "bone.vtu"));
  expect_error(ErrorCode::unreadable, "is a folder", [&] { require_input(folder.path()); });
  expect_error(ErrorCode::unreadable, "no folder", [&] { require_input(folder / "nowhere/bone.vtu"); });
}

/// An extension that is read for other content is not called unsupported.
TEST(InputFile, that_is_not_what_its_name_says_is_refused_by_its_content) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder / "a.xyz", "a molecule\n");
  EXPECT_EQ(foreign_kind(folder / "a.xyz"), ForeignKind::unknown);
  EXPECT_EQ(unsupported_type(folder / "a.xyz"),
            concat((folder / "a.xyz").string(), ": the content does not fit the file type \".xyz\""));
  EXPECT_EQ(unsupported_type(folder / "a.cgns"),
            concat((folder / "a.cgns").string(), ": unsupported file type \".cgns\""));
}

}  // namespace
}  // namespace rhoray::preprocess

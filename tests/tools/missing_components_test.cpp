// `rhoray` without the worker programs and the module for pictures, as the preset render-only
// builds it. The environment variable RHORAY_ALONE names a program of that preset; without it, a
// copy of `rhoray` is run in a folder of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class MissingComponents : public testing::Test {
 protected:
  MissingComponents() {
    const char* const alone = std::getenv("RHORAY_ALONE");
    std::filesystem::create_directory(bench_ / "alone");
    std::filesystem::copy_file(alone != nullptr ? alone : RHORAY_PROGRAM, bench_ / "alone/rhoray");
    bench_.make_ball();
  }

  /// Runs the program with these words.
  RunResult alone(const std::string& words) const { return bench_.shell("alone/rhoray " + words); }

  void expect_missing(const std::string& words, const std::string& component) const {
    SCOPED_TRACE(words);
    const auto before = bench_.contents();
    const RunResult run = alone(words);
    EXPECT_EQ(run.exit_code, 7);
    EXPECT_THAT(run.err, AllOf(HasSubstr("this needs the"), HasSubstr(component + ", which is not in "),
                               HasSubstr("hint: the package rhoray-"), HasSubstr("tools/setup/build builds it")));
    EXPECT_EQ(bench_.contents(), before);
  }

  const Workbench bench_;
};

TEST_F(MissingComponents, do_not_keep_packed_files_from_being_drawn) {
  const std::string words = "render ball.rho --iso 100 --shadows --ao --size 32x32 --verify 100 -o ";
  const RunResult drawn = alone(words + "alone.png");
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  ASSERT_EQ(bench_.shell("rhoray " + words + "all.png").exit_code, 0);
  EXPECT_EQ(bench_.shell("rhoray compare alone.png all.png").exit_code, 0);
  for (const char* line : {"info ball.rho", "verify ball.rho --deep", "export ball.rho -o ball.vti"})
    EXPECT_EQ(alone(line).exit_code, 0) << line;
}

TEST_F(MissingComponents, are_named_with_what_builds_them) {
  bench_.make_photo_nrrd();
  write_file(bench_ / "a.vdb", std::string(" BDV\0\0\0\0", 8));
  std::filesystem::create_directory(bench_ / "slices");
  for (const char* name : {"slices/1.png", "slices/2.png"})
    ASSERT_EQ(bench_.rhoray({"render", "ball.rho", "--size", "8x8", "-q", "-o", name}).exit_code, 0);

  expect_missing("info photo.nrrd", "rhoray-import-worker");
  expect_missing("pack photo.nrrd --color -o x.rho", "rhoray-import-worker");
  expect_missing("pack slices -o x.rho", "rhoray-slices-worker");
  expect_missing("info a.vdb", "rhoray-vdb-worker");
  expect_missing("render a.vdb -o x.png", "rhoray-vdb-worker");
  expect_missing("export ball.rho -o x.vdb", "rhoray-vdb-worker");
  expect_missing("validate ball.rho --iso 100", "rhoray-validate-worker");
  expect_missing("render ball.rho -o x.exr", "rhoray-pictures.so");
  expect_missing("render ball.rho --box -o x.png", "rhoray-pictures.so");
  expect_missing("compare slices/1.png slices/2.png", "rhoray-pictures.so");
}

TEST_F(MissingComponents, are_named_where_surfaces_can_be_read) {
  bench_.make_cube();
  std::filesystem::copy_file(std::filesystem::path(RHORAY_PROGRAM).replace_filename("rhoray-import-worker"),
                             bench_ / "alone/rhoray-import-worker");
  expect_missing("tetrahedralize cube.off -o x.vtu", "rhoray-tetgen-worker");
  expect_missing("tetrahedralize cube.off --repair -o x.vtu", "rhoray-repair-worker");
}

}  // namespace
}  // namespace rhoray::tests

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/workbench.h"
#include "tools/pictures/annotations.h"
#include "tools/rhoray/data_choice.h"

/// Texts tell numbers apart that are large beside their differences.
namespace rhoray::tests {
namespace {

using testing::HasSubstr;

/// offset.nrrd: values x + 1e8, and positions 1e6 away from 0 along x, in doubles.
class LargeOffsets : public testing::Test {
 protected:
  void SetUp() override {
    std::string text =
        "NRRD0004\ntype: double\ndimension: 3\nspace dimension: 3\nsizes: 24 24 24\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1000000.5,0,0)\nencoding: raw\nendian: little\n\n";
    for (int n = 0; n < 24 * 24 * 24; ++n) {
      const double value = 1e8 + n % 24;
      text.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    write_file(bench_ / "offset.nrrd", text);
  }

  Workbench bench_;
};

TEST_F(LargeOffsets, info_tells_the_ends_of_ranges_apart) {
  const RunResult info = bench_.rhoray({"info", "offset.nrrd"});
  EXPECT_THAT(info.out, HasSubstr("1e+08 to 100000023"));
  EXPECT_THAT(info.out, HasSubstr("(1000000.5 0 0) to (1000023.5 23 23)"));
}

TEST_F(LargeOffsets, picks_tell_positions) {
  const RunResult run = bench_.rhoray({"render", "offset.nrrd", "--iso", "100000010", "--accuracy", "double", "-o",
                                       "a.png", "--size", "33x33", "--azimuth", "-60", "--pick", "16,16"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("position (1000010.5 "));
}

TEST_F(LargeOffsets, legends_tell_isovalues) {
  render::SceneSpec spec;
  spec.data = {{.name = "", .file = bench_ / "offset.nrrd"}};
  spec.layers = {{.type = render::LayerType::isosurface, .isovalues = {"100000010", "100000020", "100000020.001"}}};
  const std::vector<tools::Legend> legends = tools::annotations_of(tools::resolve_layers(spec), {}).legends;
  ASSERT_EQ(legends.size(), 1U);
  std::vector<std::string> texts;
  for (const tools::Legend::Entry& entry : legends[0].entries) texts.push_back(entry.text);
  EXPECT_THAT(texts, testing::ElementsAre("100000020.001", "100000020", "100000010"));
}

}  // namespace
}  // namespace rhoray::tests

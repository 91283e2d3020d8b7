#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

// Distances between picked points, on a sphere whose points are known.
namespace rhoray::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// sphere.nrrd: the squared distance from the middle, in mm^2, at whole mm. Where all coordinates
/// are whole, the trilinear field is exact: the isosurface at 81 passes through (0 0 9), (4 4 7)
/// and (1 -4 8). A camera above looks down with one pixel per mm.
class Picks : public testing::Test {
 protected:
  void SetUp() override {
    std::string text =
        "NRRD0004\ntype: ushort\ndimension: 3\nspace dimension: 3\nsizes: 33 33 33\nspace units: \"mm\" \"mm\" \"mm\"\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (-16,-16,-16)\nencoding: raw\nendian: little\n\n";
    for (int k = -16; k <= 16; ++k)
      for (int j = -16; j <= 16; ++j)
        for (int i = -16; i <= 16; ++i) {
          const int squared = i * i + j * j + k * k;
          text += static_cast<char>(squared % 256);
          text += static_cast<char>(squared / 256);
        }
    write_file(bench_ / "sphere.nrrd", text);
  }

  /// The pixel that looks at x, y.
  static std::string pixel(int x, int y) { return std::to_string(16 + x) + "," + std::to_string(16 - y); }

  RunResult picked(std::vector<std::string> words) const {
    words.insert(words.begin(),
                 {"render", "sphere.nrrd", "--size", "33x33", "--camera-position", "0,0,40", "--camera-target", "0,0,0",
                  "--camera-up", "0,1,0", "--ortho-height", "33", "-q", "--force", "-o", "p.png"});
    RunResult result = bench_.rhoray(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result;
  }

  Workbench bench_;
};

TEST_F(Picks, give_distances_between_consecutive_ones) {
  for (const std::string accuracy : {"certified", "exact"}) {
    const json report = json::parse(picked({"--iso", "81", "--accuracy", accuracy, "--json", "--pick", pixel(0, 0),
                                            "--pick", pixel(4, 4), "--pick", pixel(1, -4)})
                                        .out);
    ASSERT_EQ(report["picks"].size(), 3U);
    ASSERT_EQ(report["distances"].size(), 2U);
    const double known[] = {6, std::sqrt(9.0 + 64 + 1)};
    for (std::size_t i = 0; i < 2; ++i) {
      const json& line = report["distances"][i];
      EXPECT_EQ(line["from"], report["picks"][i]["pixel"]);
      EXPECT_EQ(line["to"], report["picks"][i + 1]["pixel"]);
      EXPECT_EQ(line["length_unit"], "mm");
      EXPECT_LE(std::abs(line["distance"].get<double>() - known[i]), line["error"].get<double>());
      EXPECT_LT(line["error"].get<double>(), 0.003);  // a thousandth of a cell at each end
    }
  }
}

TEST_F(Picks, keep_their_positions_within_the_proven_error) {
  const json picks = json::parse(
      picked({"--iso", "81", "--accuracy", "certified", "--json", "--pick", pixel(4, 4) + ":" + pixel(-8, 1)})
          .out)["picks"];
  const double known[][3] = {{4, 4, 7}, {-8, 1, 4}};
  for (std::size_t i = 0; i < 2; ++i) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      squared += std::pow(picks[i]["position"][axis].get<double>() - known[i][axis], 2);
    EXPECT_LE(std::sqrt(squared), picks[i]["error"].get<double>());
  }
}

TEST_F(Picks, print_a_distance_after_its_end) {
  const std::string text =
      picked({"--iso", "81", "--accuracy", "exact", "--pick", pixel(0, 0), "--pick", pixel(4, 4)}).out;
  EXPECT_THAT(text, HasSubstr("\ndistance from pixel 16,16 to pixel 20,12: 6"));
  EXPECT_THAT(text, HasSubstr(" mm, error at most "));
  EXPECT_LT(text.find("pixel 20,12: position"), text.find("distance from"));
  EXPECT_THAT(picked({"--iso", "81", "--accuracy", "exact", "--pick", pixel(0, 0)}).out,
              testing::Not(HasSubstr("distance")));
}

TEST_F(Picks, say_where_no_error_is_proven) {
  const std::string fast = picked({"--iso", "81", "--pick", pixel(0, 0) + ":" + pixel(4, 4)}).out;
  EXPECT_THAT(fast, HasSubstr("distance from pixel 16,16 to pixel 20,12: 6 mm, no proven error at both pixels"));
  const std::string beside =
      picked({"--iso", "81", "--accuracy", "exact", "--pick", pixel(0, 0) + ":" + pixel(15, 15)}).out;
  EXPECT_THAT(beside, HasSubstr("distance from pixel 16,16 to pixel 31,1: none, no hit at pixel 31,1"));
}

TEST_F(Picks, take_the_error_of_a_projection_for_that_of_its_value) {
  const std::vector<std::string> words{"--mode", "mip",    "--accuracy",
                                       "exact",  "--pick", pixel(0, 0) + ":" + pixel(4, 4)};
  const std::string text = picked(words).out;
  EXPECT_THAT(text, HasSubstr("no proven error at both pixels"));
  std::vector<std::string> as_json = words;
  as_json.push_back("--json");
  const json report = json::parse(picked(as_json).out);
  EXPECT_FALSE(report["picks"][0].contains("error"));
  EXPECT_NEAR(report["picks"][0]["value"].get<double>(), 256, report["picks"][0]["value_error"].get<double>());
  EXPECT_TRUE(report["distances"][0]["error"].is_null());
}

}  // namespace
}  // namespace rhoray::tests

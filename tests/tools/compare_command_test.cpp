#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/support/expect_error.h"
#include "tests/tools/workbench.h"
#include "tools/analysis/heat_map.h"
#include "tools/analysis/picture_difference.h"
#include "tools/pictures/pictures.h"

namespace rhoray::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using tools::difference_of;
using tools::StoredPicture;
using Json = nlohmann::json;

StoredPicture two_by_one(std::vector<std::string> channels, std::vector<double> numbers) {
  return {.width = 2, .height = 1, .channels = std::move(channels), .numbers = std::move(numbers)};
}

TEST(PictureDifference, is_what_can_be_counted_by_hand) {
  const auto difference =
      difference_of(two_by_one({"R", "G"}, {0, 0.5, 1, 0.25}), two_by_one({"R", "G"}, {0, 0.5, 0.5, 0.5}), "a", "b");
  EXPECT_EQ(difference.differing, 1u);
  EXPECT_EQ(difference.largest.size, 0.5);
  EXPECT_EQ(difference.largest.channel, "R");
  EXPECT_EQ(difference.largest.x, 1);
  EXPECT_EQ(difference.largest.a, 1);
  EXPECT_EQ(difference.largest.b, 0.5);
  EXPECT_EQ(difference.mean, 0.75 / 4);
  EXPECT_DOUBLE_EQ(difference.root_mean_square, std::sqrt((0.25 + 0.0625) / 4));
  EXPECT_DOUBLE_EQ(difference.peak_signal_to_noise(), 20 * std::log10(1 / std::sqrt(0.3125 / 4)));
  EXPECT_EQ(difference.beyond(0.5), 0u);
  EXPECT_EQ(difference.beyond(0.499), 1u);
}

TEST(PictureDifference, takes_the_channels_that_both_have_by_name) {
  const auto difference =
      difference_of(two_by_one({"R", "Z"}, {1, 7, 2, 8}), two_by_one({"Z", "A"}, {7, 0, 9, 0}), "a", "b");
  EXPECT_THAT(difference.channels, ElementsAre("Z"));
  EXPECT_THAT(difference.only_a, ElementsAre("R"));
  EXPECT_THAT(difference.only_b, ElementsAre("A"));
  EXPECT_EQ(difference.largest.size, 1);
}

TEST(PictureDifference, takes_the_same_number_that_is_not_finite_as_equal_and_others_as_infinitely_far) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const auto same = difference_of(two_by_one({"Z"}, {nan, infinity}), two_by_one({"Z"}, {nan, infinity}), "a", "b");
  EXPECT_EQ(same.differing, 0u);
  EXPECT_EQ(same.root_mean_square, 0);
  const auto other = difference_of(two_by_one({"Z"}, {nan, infinity}), two_by_one({"Z"}, {1, -infinity}), "a", "b");
  EXPECT_EQ(other.differing, 2u);
  EXPECT_EQ(other.largest.size, infinity);
}

TEST(PictureDifference, is_refused_between_pictures_that_cannot_be_compared) {
  const StoredPicture a = two_by_one({"R"}, {0, 1});
  expect_error(ErrorCode::invalid, "b.png: found 1x2 pixels; expected 2x1, as in a.png", [&] {
    difference_of(a, {.width = 1, .height = 2, .channels = {"R"}, .numbers = {0, 1}}, "a.png", "b.png");
  });
  expect_error(ErrorCode::invalid, "b.png: found channels Z; expected some of R, as in a.png", [&] {
    difference_of(a, two_by_one({"Z"}, {0, 1}), "a.png", "b.png");
  });
}

TEST(PictureDifference, is_drawn_black_where_there_is_none_and_brightest_where_it_is_largest) {
  const std::vector<float> sizes{0, 0.001f, 0.002f, std::numeric_limits<float>::infinity()};
  const render::Framebuffer map = tools::difference_map(sizes, 4, 1);
  const auto brightness = [&](std::size_t pixel) {
    return map.color[4 * pixel] + map.color[4 * pixel + 1] + map.color[4 * pixel + 2];
  };
  EXPECT_EQ(brightness(0), 0);
  EXPECT_GT(brightness(1), 0);
  EXPECT_GT(brightness(2), brightness(1));
  EXPECT_THAT(std::vector<float>(map.color.begin() + 12, map.color.begin() + 15), ElementsAre(1, 0, 1));
}

/// Renders two pictures of the ball with slightly different isovalues.
void draw_two(const Workbench& bench, const std::string& extension) {
  bench.make_ball();
  for (const auto& [name, isovalue] : {std::pair{"a", "100"}, {"b", "104"}}) {
    const RunResult drawn =
        bench.rhoray({"render", "ball.rho", "--iso", isovalue, "--size", "40x30", "-q", "-o", name + extension});
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  }
}

TEST(CompareCommand, finds_a_picture_equal_to_itself_and_tells_two_apart) {
  const Workbench bench;
  for (const std::string extension : {".png", ".exr", ".tif"}) {
    draw_two(bench, extension);
    const RunResult same = bench.rhoray({"compare", "a" + extension, "a" + extension, "--fail", "0"});
    EXPECT_EQ(same.exit_code, 0) << same.err;
    EXPECT_THAT(same.out, HasSubstr("pixels that differ  0 of 1200"));
    const RunResult other = bench.rhoray({"compare", "a" + extension, "b" + extension, "--json"});
    EXPECT_EQ(other.exit_code, 0) << other.err;
    const Json json = Json::parse(other.out);
    EXPECT_GT(json["differing"], 50);
    EXPECT_LT(json["differing"], 1200);
    // At the rim, one picture shows the surface, the other the background.
    EXPECT_GT(json["largest"]["size"], 0.15);
    std::filesystem::remove(bench / "ball.rho");
  }
}

TEST(CompareCommand, ends_with_6_beyond_its_limit_and_draws_where) {
  const Workbench bench;
  draw_two(bench, ".png");
  const RunResult beyond = bench.rhoray({"compare", "a.png", "b.png", "--fail", "0.1", "--map", "where.png"});
  EXPECT_EQ(beyond.exit_code, 6);
  EXPECT_THAT(beyond.err, HasSubstr("pixels differ by more than 0.1 from a.png"));
  EXPECT_TRUE(std::filesystem::exists(bench / "where.png"));
  const RunResult shared = bench.rhoray({"compare", "a.png", "b.png", "--fail", "0.1", "--fail-share", "0.5"});
  EXPECT_EQ(shared.exit_code, 0) << shared.err;
  EXPECT_EQ(bench.rhoray({"compare", "a.png", "b.png", "--fail", "1"}).exit_code, 0);
}

TEST(CompareCommand, ends_with_6_if_a_channel_is_in_one_picture_only) {
  const Workbench bench;
  draw_two(bench, ".png");
  const std::vector<std::string> render{"render", "ball.rho", "--iso", "100", "--size", "40x30", "-q", "--force", "-o"};
  const auto draw = [&](std::vector<std::string> more) {
    more.insert(more.begin(), render.begin(), render.end());
    const RunResult drawn = bench.rhoray(more);
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  };
  draw({"a.exr"});
  draw({"b.exr", "--channels", "depth"});
  for (const auto& [one, other] : {std::pair{"a.exr", "b.exr"}, {"b.exr", "a.exr"}}) {
    const RunResult refused = bench.rhoray({"compare", one, other, "--fail", "1000"});
    EXPECT_EQ(refused.exit_code, 6);
    EXPECT_THAT(refused.err, HasSubstr("b.exr: has the channel Z, which a.exr has not"));
    EXPECT_EQ(bench.rhoray({"compare", one, other}).exit_code, 0);
  }
}

/// An EXR with these cells and costs in two pixels.
void write_counts(const std::filesystem::path& path, const std::vector<std::uint64_t>& cells,
                  const std::vector<std::uint32_t>& costs) {
  render::Framebuffer picture(2, 1, {.cell = true, .cost = true});
  picture.cell = cells, picture.cost = costs;
  tools::write_picture(picture, {}, path, true);
}

/// OpenImageIO reads 32-bit integers as shares of 2^32 - 1, and their differences were below any
/// limit.
TEST(CompareCommand, compares_whole_numbers_of_exr_files_as_they_are) {
  const Workbench bench;
  write_counts(bench / "a.exr", {25'970'693, 7}, {40, 41});
  write_counts(bench / "b.exr", {25'970'693, 7}, {40, 42});
  const RunResult cost = bench.rhoray({"compare", "a.exr", "b.exr", "--fail", "0.5"});
  EXPECT_EQ(cost.exit_code, 6) << cost.err;
  EXPECT_THAT(cost.out, HasSubstr("largest difference  1: cost at (1, 0), 41 and 42\n"));
  EXPECT_EQ(bench.rhoray({"compare", "a.exr", "b.exr", "--fail", "1"}).exit_code, 0);
  // Floats cannot tell these cells apart.
  write_counts(bench / "c.exr", {25'970'694, 7}, {40, 41});
  const RunResult cell = bench.rhoray({"compare", "a.exr", "c.exr", "--fail", "0"});
  EXPECT_EQ(cell.exit_code, 6) << cell.err;
  EXPECT_THAT(cell.out, HasSubstr("largest difference  1: cell at (0, 0), 25970693 and 25970694\n"));
}

TEST(CompareCommand, says_what_is_wrong_with_its_words_and_files) {
  const Workbench bench;
  draw_two(bench, ".png");
  write_file(bench / "text.png", "no picture");
  const auto ends = [&](std::vector<std::string> words, int code, const std::string& line) {
    words.insert(words.begin(), "compare");
    const RunResult result = bench.rhoray(words);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(line));
  };
  ends({"a.png"}, 2, "found 1; expected 2");
  ends({"a.png", "c.png"}, 3, "c.png");
  write_file(bench / "text.txt", "no picture");
  ends({"a.png", "text.txt"}, 7, "text.txt: is not a picture; expected .png");
  ends({"a.png", "text.png"}, 4, "text.png: found no picture, or a damaged one");
  ends({"a.png", "b.png", "--fail", "-1"}, 2, "--fail: found -1; expected 0 or more");
  ends({"a.png", "b.png", "--fail-share", "0.1"}, 2, "--fail-share: needs --fail");
  ends({"a.png", "b.png", "--fail", "0", "--fail-share", "2"}, 2, "--fail-share: found 2; expected 0 to 1");
  ends({"a.png", "b.png", "--map", "b.png"}, 2, "b.png");
}

}  // namespace
}  // namespace rhoray::tests

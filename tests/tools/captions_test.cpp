#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/blank_picture.h"
#include "tests/tools/workbench.h"
#include "tools/pictures/annotate.h"
#include "tools/pictures/pictures.h"

/// Long captions: a few kilobytes took seconds to minutes, and a viewer answered nobody meanwhile.
namespace rhoray::tests {
namespace {

using namespace tools;
using testing::HasSubstr;

struct DrawnCaption {
  Drawing drawing;
  std::vector<std::string> asked;  ///< the texts whose images were made
};

DrawnCaption drawn(const std::string& caption, int width, int height) {
  DrawnCaption result;
  render::Framebuffer picture = blank(width, height);
  const MakeText make_text = [&](const std::string& text, int pixels) {
    result.asked.push_back(text);
    return blocks(text, pixels);
  };
  result.drawing = annotate({.camera = {}, .caption = caption}, make_text, picture);
  return result;
}

TEST(Caption, that_does_not_fit_shows_its_first_lines_and_ends_in_dots) {
  std::string words = "first";
  for (int i = 1; i < 300; ++i) words += " word";
  for (const std::string& caption : {words, "first\n" + std::string(1990, '\n')})
    for (const int height : {12, 100, 300}) {
      const DrawnCaption caption_drawn = drawn(caption, 200, height);
      const std::vector<Area>& lines = caption_drawn.drawing.texts;
      EXPECT_GE(lines.size(), height == 12 ? 1U : 5U);
      EXPECT_LE(lines.size(), height == 300 ? 24U : 8U);
      EXPECT_LE(caption_drawn.asked.size(), 220U);
      for (const Area& line : lines) {
        EXPECT_GE(line.low.x, 0);
        EXPECT_LE(line.high.x, 200);
        EXPECT_GE(line.low.y, height == 12 ? -12 : 0);
      }
      const std::string& last = caption_drawn.asked.back();
      EXPECT_TRUE(last.ends_with("...")) << last;
      EXPECT_THAT(caption_drawn.asked[caption_drawn.asked.size() - lines.size()], HasSubstr("first"));
    }
}

TEST(Caption, that_just_fits_is_drawn_whole) {
  const DrawnCaption two = drawn("above\nbelow", 200, 100);
  EXPECT_EQ(two.drawing.texts.size(), 2U);
  EXPECT_EQ(two.asked.back(), "below");
  EXPECT_EQ(drawn("alone", 200, 12).asked.back(), "alone");
}

TEST(Caption, has_at_most_2000_characters) {
  const Workbench bench;
  bench.make_ball();
  std::string longest;
  for (int i = 0; i < 1000; ++i) longest += "\u00c4 ";
  const auto draw = [&](const std::string& caption) {
    return bench.rhoray(
        {"render", "ball.rho", "--iso", "100", "--size", "64x48", "--caption", caption, "--force", "-o", "p.png"});
  };
  const RunResult whole = draw(longest);
  EXPECT_EQ(whole.exit_code, 0) << whole.err;
  const RunResult refused = draw(longest + "x");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--caption: found 2001 characters; expected at most 2000\n"));
}

TEST(Text, does_not_depend_on_texts_of_other_sizes_before_it) {
  const std::filesystem::path font = find_font(known_fonts());
  const TextImage first = make_text_image("Wave 17", 23, font);
  for (const int pixels : {8, 64, 9}) make_text_image("Wave 17", pixels, font);
  EXPECT_EQ(make_text_image("Wave 17", 23, font).coverage, first.coverage);
}

}  // namespace
}  // namespace rhoray::tests

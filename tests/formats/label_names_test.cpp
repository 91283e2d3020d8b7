#include "formats/label_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace rhoray::formats {
namespace {

/// A code point in UTF-8, by the table of RFC 3629.
std::string utf8(std::uint32_t letter) {
  const auto tail = [&](int shift) { return static_cast<char>(0x80 | ((letter >> shift) & 0x3f)); };
  if (letter < 0x80) return {static_cast<char>(letter)};
  if (letter < 0x800) return {static_cast<char>(0xc0 | letter >> 6), tail(0)};
  if (letter < 0x10000) return {static_cast<char>(0xe0 | letter >> 12), tail(6), tail(0)};
  return {static_cast<char>(0xf0 | letter >> 18), tail(12), tail(6), tail(0)};
}

TEST(LabelNames, every_code_point_but_controls_and_surrogates_is_a_letter) {
  for (std::uint32_t letter = 0; letter < 0x110000; ++letter) {
    const bool is_control = letter < 0x20 || (letter >= 0x7f && letter < 0xa0);
    const bool is_surrogate = letter >= 0xd800 && letter < 0xe000;
    const std::string text = utf8(letter);
    ASSERT_EQ(first_letter_bytes(text + "x"), is_control || is_surrogate ? 0U : text.size()) << letter;
    ASSERT_EQ(is_label_name("a" + text), !is_control && !is_surrogate) << letter;
    ASSERT_EQ(text.size() > 1 ? first_letter_bytes(text.substr(0, text.size() - 1)) : 0, 0U) << letter << " cut";
  }
}

TEST(LabelNames, bytes_that_are_no_code_point_are_refused) {
  for (const char* text : {"\x80", "\xbf", "\xc0\xa0", "\xc1\xbf", "\xe0\x9f\xbf", "\xf0\x8f\xbf\xbf",
                           "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff", "\xc3(", "\xe2\x82(", "\xc3"})
    EXPECT_FALSE(is_label_name(text)) << testing::PrintToString(text);
}

TEST(LabelNames, have_1_to_128_bytes) {
  EXPECT_FALSE(is_label_name(""));
  EXPECT_TRUE(is_label_name(" "));
  EXPECT_TRUE(is_label_name(std::string(128, 'a')));
  EXPECT_FALSE(is_label_name(std::string(129, 'a')));
  EXPECT_FALSE(is_label_name(std::string("a\0b", 3)));
}

}  // namespace
}  // namespace rhoray::formats

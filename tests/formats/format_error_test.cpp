#include "formats/format_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace rhoray::formats {
namespace {

std::string message(std::string_view place, std::string_view found) {
  try {
    refuse("a.rho", place, found, "another");
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(FormatError, names_file_place_found_and_expected) {
  EXPECT_EQ(message("byte 8", "7"), "a.rho, byte 8: found 7; expected another");
}

/// Found by fuzzing: the name of an entry in a zip archive split a message into two lines, and
/// could have sent any command to a terminal.
TEST(FormatError, shows_control_characters_from_files_as_numbers) {
  EXPECT_EQ(message("folder\na.dcm",
                    "\x1b[2J\x7f"
                    "µ"),
            "a.rho, folder\\x0aa.dcm: found \\x1b[2J\\x7fµ; expected another");
  EXPECT_EQ(message("name",
                    "\xc2\x9b"
                    "2J\xc2\xa0\xc2"),
            "a.rho, name: found \\xc2\\x9b2J\xc2\xa0\xc2; expected another")
      << "the same code for a terminal, as one character";
}

TEST(FormatError, cuts_long_texts_from_files) {
  const std::string text = message("name", std::string(5000, 'n'));
  EXPECT_LT(text.size(), 700U);
  EXPECT_THAT(text, testing::HasSubstr("nnn...; expected another"));
}

}  // namespace
}  // namespace rhoray::formats

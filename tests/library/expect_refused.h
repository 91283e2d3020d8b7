#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <string>

#include "rhoray/error.h"

namespace rhoray::tests {

/// Expects that act() throws an Error with this code whose message is one line that contains
/// `words`. Neither it nor the hint names an option of the program, but for a whole command in
/// backquotes.
template <class Act>
void expect_refused(ErrorCode code, const std::string& words, const Act& act) {
  try {
    act();
    ADD_FAILURE() << "nothing was refused; expected: " << words;
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(code)) << error.what();
    EXPECT_THAT(error.what(), testing::HasSubstr(words));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
    for (const std::string& text : {std::string(error.what()), error.hint()})
      EXPECT_THAT(std::regex_replace(text, std::regex("`[^`]*`"), ""), testing::Not(testing::HasSubstr("--")));
  }
}

}  // namespace rhoray::tests

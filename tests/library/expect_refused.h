#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "rhoray/error.h"

namespace rhoray::tests {

/// Expects that act() throws an Error with this code whose message is one line that contains
/// `words`.
template <class Act>
void expect_refused(ErrorCode code, const std::string& words, const Act& act) {
  try {
    act();
    ADD_FAILURE() << "nothing was refused; expected: " << words;
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(code)) << error.what();
    EXPECT_THAT(error.what(), testing::HasSubstr(words));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
  }
}

}  // namespace rhoray::tests

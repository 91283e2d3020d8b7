#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "formats/base/error.h"

namespace rhoray::tests {

/// Expects that act() throws an Error with this code whose message contains `words`.
template <class Act>
void expect_error(ErrorCode error_code, const std::string& words, Act&& act) {
  try {
    act();
    ADD_FAILURE() << "nothing was refused; expected: " << words;
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(error_code)) << error.what();
    EXPECT_THAT(error.what(), testing::HasSubstr(words));
  }
}

}  // namespace rhoray::tests

#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "formats/base/trouble.h"

namespace rhoray::tests {

/// Expects that act() throws an Error of this kind whose sentence contains `words`.
template <class Act>
void expect_error(Trouble trouble, const std::string& words, Act&& act) {
  try {
    act();
    ADD_FAILURE() << "nothing was refused; expected: " << words;
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.trouble()), static_cast<int>(trouble)) << error.what();
    EXPECT_THAT(error.what(), testing::HasSubstr(words));
  }
}

}  // namespace rhoray::tests

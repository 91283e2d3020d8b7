// The whole catalogue of hard cases, every method that answers them, and the judge (catalogue/hard_case.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "tests/hard_cases/catalogue/trial.h"

namespace rhoray::tests {
namespace {

std::string listed(const std::vector<std::string>& complaints) {
  std::string text;
  for (const std::string& complaint : complaints) text += complaint + '\n';
  return text;
}

TEST(Catalogue, certified_is_right_in_every_case) {
  for (const HardCase& hard_case : catalogue()) {
    Trial trial(hard_case);
    const Tally tally = trial.tally(method_named("certified"));
    EXPECT_EQ(tally.wrong(), 0) << hard_case.id << " of " << tally.questions << '\n' << listed(tally.complaints);
  }
}

TEST(Catalogue, the_judge_says_what_closed_forms_say) {
  for (const HardCase& hard_case : catalogue()) {
    if (!hard_case.known) continue;
    const Tally tally = Trial(hard_case).against_known_answers();
    EXPECT_EQ(tally.wrong(), 0) << hard_case.id << '\n' << listed(tally.complaints);
    EXPECT_GT(tally.questions, static_cast<int>(hard_case.rays.size()) / 2) << hard_case.id;
  }
}

TEST(Catalogue, every_case_is_still_hard) {
  for (const HardCase& hard_case : catalogue()) {
    if (hard_case.naive.method.empty()) {
      EXPECT_FALSE(hard_case.naive.reason.empty()) << hard_case.id;
      continue;
    }
    ASSERT_GT(hard_case.naive.at_least, 0) << hard_case.id;
    const Tally tally = Trial(hard_case).tally(method_named(hard_case.naive.method));
    EXPECT_GE(tally.not_seen(), hard_case.naive.at_least)
        << hard_case.id << ": " << hard_case.naive.method << " no longer fails: is this case still the hard one?";
  }
}

TEST(Catalogue, direct_methods_are_right_where_they_promise_it) {
  for (const HardCase& hard_case : catalogue()) {
    Trial trial(hard_case);
    const Tally tally = trial.tally(method_named("direct double"));
    const int allowed = hard_case.direct_may_fail_by.empty() ? 0 : tally.questions / 10;
    EXPECT_LE(tally.wrong(), allowed) << hard_case.id << " of " << tally.questions << '\n' << listed(tally.complaints);
  }
}

}  // namespace
}  // namespace rhoray::tests

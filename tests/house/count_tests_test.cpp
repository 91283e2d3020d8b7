// .ci/count_tests, on results that this test writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

class CountTests : public testing::Test {
 protected:
  CountTests() { expect("tests 2\ntests-without-shared-data 1 # fewer\ninstruction-sets 2\n"); }

  void expect(const std::string& numbers) { write_file(folder_ / "expected", numbers); }

  static std::string passed(const std::string& name) {
    return "<testcase name=\"" + name + "\" status=\"run\"><system-out>fine</system-out></testcase>";
  }
  static std::string skipped(const std::string& name, const std::string& reason) {
    return "<testcase name=\"" + name +
           "\" status=\"notrun\"><skipped message=\"SKIP_REGULAR_EXPRESSION_MATCHED\"/><system-out>[ RUN      ] " +
           name + "\n/a/b_test.cpp:12: Skipped\n" + reason + "\n\n[  SKIPPED ] " + name +
           " (0 ms)\n</system-out></testcase>";
  }

  RunResult counted(const std::string& cases, bool with_shared_data) const {
    write_file(folder_ / "results.xml", "<?xml version=\"1.0\"?><testsuite>" + cases + "</testsuite>");
    return run_program({"env", with_shared_data ? "RHORAY_SHARED_DATA=/somewhere" : "RHORAY_SHARED_DATA=",
                        RHORAY_SOURCE_DIR "/.ci/count_tests", (folder_ / "results.xml").string(),
                        (folder_ / "expected").string()});
  }

  // With the comment on the parameter that gtest_discover_tests may add.
  const std::string two_sets_ = passed("Of/InstructionSets.answer/scalar  # GetParam() = 4-byte object") +
                                passed("Of/InstructionSets.answer/avx2");

 private:
  TemporaryFolder folder_;
};

TEST_F(CountTests, says_what_ran_what_was_skipped_and_why) {
  const RunResult run = counted(two_sets_ + passed("A.a") + passed("A.b") + skipped("S.x", "no folder &amp; no data") +
                                    skipped("S.y", "no folder &amp; no data") +
                                    skipped("Of/InstructionSets.answer/avx512", "this processor lacks avx512"),
                                true);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("4 tests executed, 0 of them failed, 3 skipped\n"));
  EXPECT_THAT(run.out, HasSubstr("2 skipped: no folder & no data\n    S.x, S.y\n"));
  EXPECT_THAT(run.out, HasSubstr("1 skipped: this processor lacks avx512\n"));
  EXPECT_THAT(run.out, HasSubstr("instruction sets covered: avx2, scalar\n"));
}

TEST_F(CountTests, fails_below_the_expected_number_of_tests) {
  const std::string three = two_sets_ + passed("A.a");
  const RunResult with_data = counted(three + skipped("S.x", "no folder"), true);
  EXPECT_EQ(with_data.exit_code, 1);
  EXPECT_THAT(with_data.err, HasSubstr("1 tests executed besides InstructionSets"));
  EXPECT_THAT(with_data.err, HasSubstr("expects at least 2 (tests)"));
  EXPECT_EQ(counted(three + skipped("S.x", "no folder"), false).exit_code, 0);
  EXPECT_EQ(counted(two_sets_, false).exit_code, 1);
}

TEST_F(CountTests, neither_misses_an_instruction_set_nor_takes_it_for_another_test) {
  const std::string avx512 = "Of/InstructionSets.answer/avx512";
  const std::string rest = passed("A.a") + passed("A.b");
  EXPECT_EQ(counted(two_sets_ + rest + skipped(avx512, "this processor lacks avx512"), true).exit_code, 0);
  EXPECT_EQ(counted(two_sets_ + passed(avx512) + rest, true).exit_code, 0);
  EXPECT_EQ(counted(two_sets_ + passed(avx512) + passed("A.a"), true).exit_code, 1);
}

TEST_F(CountTests, fails_below_the_expected_number_of_instruction_sets) {
  const RunResult run =
      counted(passed("Of/InstructionSets.answer/scalar") + passed("A.a") + passed("A.b") + passed("A.c"), true);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("1 instruction sets covered"));
}

TEST_F(CountTests, fails_where_a_test_failed) {
  const RunResult run = counted(
      two_sets_ + passed("A.a") + "<testcase name=\"A.b\" status=\"fail\"><failure message=\"\"/></testcase>", true);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("A.b failed"));
}

TEST_F(CountTests, refuses_files_that_it_cannot_read) {
  EXPECT_EQ(counted("<testcase", true).exit_code, 2);
  expect("tests 2\n");
  const RunResult missing = counted(two_sets_, true);
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.err, HasSubstr("tests-without-shared-data, instruction-sets: missing"));
  expect("tests many\n");
  EXPECT_EQ(counted(two_sets_, true).exit_code, 2);
}

}  // namespace
}  // namespace rhoray::tests

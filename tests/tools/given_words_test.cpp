#include "tools/rhoray/cli/given_words.h"

#include <gmock/gmock.h>

#include "tests/support/expect_error.h"

namespace rhoray::tools {
namespace {

using testing::ElementsAre;

/// FILE, --iso V, -o FILE, -q, -v and --pick X...
std::vector<Option> rows() {
  const auto row = [](Option::Kind kind, const char* names, const char* value) {
    Option made;
    made.kind = kind;
    made.names = names;
    made.value = value;
    return made;
  };
  using Kind = Option::Kind;
  return {
      row(Kind::file, "FILE", ""),       row(Kind::value, "--iso", "V"),      row(Kind::value, "-o,--output", "FILE"),
      row(Kind::flag, "-q,--quiet", ""), row(Kind::flag, "-v,--verbose", ""), row(Kind::answer, "-h,--help", "")};
}

/// "row=text" of each word that was given.
std::vector<std::string> read(const std::vector<const char*>& words) {
  std::vector<std::string> found;
  const std::vector<Option> all = rows();
  for (const GivenWord& one : given_words("render", all, words))
    found.push_back(concat(long_name(all[one.row]), "=", one.text));
  return found;
}

void expect_refused(const std::vector<const char*>& words, const std::string& fact) {
  SCOPED_TRACE(testing::PrintToString(words));
  tests::expect_error(ErrorCode::usage, fact, [&] { read(words); });
}

TEST(GivenWords, take_values_in_every_spelling) {
  EXPECT_THAT(read({"a.rho", "--iso", "3", "-o", "x"}), ElementsAre("FILE=a.rho", "--iso=3", "--output=x"));
  EXPECT_THAT(read({"--iso=3", "-ox", "a"}), ElementsAre("--iso=3", "--output=x", "FILE=a"));
  EXPECT_THAT(read({"-o=x"}), ElementsAre("--output=x"));
  EXPECT_THAT(read({"-qvo", "x"}), ElementsAre("--quiet=", "--verbose=", "--output=x"));
  EXPECT_THAT(read({"--iso="}), ElementsAre("--iso="));
  EXPECT_THAT(read({"--iso", ""}), ElementsAre("--iso="));
  EXPECT_THAT(read({"--iso", "a=b"}), ElementsAre("--iso=a=b"));
}

TEST(GivenWords, take_negative_numbers_and_a_lone_dash_as_values) {
  EXPECT_THAT(read({"--iso", "-60.5"}), ElementsAre("--iso=-60.5"));
  EXPECT_THAT(read({"--iso", "-.5,-inf"}), ElementsAre("--iso=-.5,-inf"));
  EXPECT_THAT(read({"-o", "-"}), ElementsAre("--output=-"));
  EXPECT_THAT(read({"-"}), ElementsAre("FILE=-"));
}

TEST(GivenWords, behind_two_dashes_are_files) {
  EXPECT_THAT(read({"-q", "--", "--iso"}), ElementsAre("--quiet=", "FILE=--iso"));
  EXPECT_THAT(read({"--iso=--quiet"}), ElementsAre("--iso=--quiet"));
}

TEST(GivenWords, do_not_take_the_next_option_for_a_forgotten_value) {
  expect_refused({"--iso"}, "--iso: found no value at the end; expected V");
  expect_refused({"--iso", "--output", "x"}, "--iso: found no value before --output; expected V");
  expect_refused({"-o", "-q"}, "-o: found no value before -q; expected FILE");
  expect_refused({"-qo"}, "-o: found no value at the end; expected FILE");
  expect_refused({"--iso", "--"}, "--iso: found no value before --; expected V");
}

TEST(GivenWords, refuse_what_no_row_takes) {
  expect_refused({"--ios", "3"}, "unknown option --ios");
  expect_refused({"--ios=3"}, "unknown option --ios");
  expect_refused({"-iso", "3"}, "unknown option -iso");
  expect_refused({"-z=3"}, "unknown option -z");
  expect_refused({"-1"}, "unknown option -1");
  expect_refused({"-qz"}, "unknown option -z");
  expect_refused({"---iso"}, "unknown option ---iso");
  expect_refused({"--=3"}, "unknown option --");
  expect_refused({"--quiet=3"}, "--quiet: takes no value; found '--quiet=3'");
  expect_refused({"-q=3"}, "--quiet: takes no value; found '-q=3'");
  expect_refused({"--help=3"}, "--help: takes no value");
  expect_refused({"a", "b"}, "unexpected argument 'b'");
}

}  // namespace
}  // namespace rhoray::tools

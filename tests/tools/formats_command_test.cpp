#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "preprocess/input_file.h"
#include "tests/tools/workbench.h"
#include "tools/rhoray/export_formats.h"

namespace rhoray::tools {
namespace {

using testing::HasSubstr;

/// The extensions in a list of formats.
std::vector<std::string> extensions_of(const nlohmann::json& list) {
  std::vector<std::string> all;
  for (const auto& format : list)
    for (const std::string extension : format.at("extensions")) all.push_back(extension);
  return all;
}

TEST(Formats, lists_what_is_read_and_written) {
  const tests::Workbench bench;
  const tests::RunResult run = bench.rhoray({"formats", "--json"});
  EXPECT_EQ(run.exit_code, 0);
  const nlohmann::json json = nlohmann::json::parse(run.out);
  const std::vector<std::string> read = extensions_of(json.at("read")), written = extensions_of(json.at("written"));
  for (const preprocess::ForeignFormat& format : preprocess::foreign_formats())
    for (const std::string_view family : format.families)
      EXPECT_TRUE(family.ends_with('/') || std::find(read.begin(), read.end(), family) != read.end()) << family;
  for (const ExportFormat& format : export_formats)
    EXPECT_THAT(written, testing::Contains(std::string(format.extension)));
  for (const auto* list : {&read, &written}) EXPECT_THAT(*list, testing::Contains(".rho"));
  EXPECT_THAT(written, testing::Contains(".png"));

  const tests::RunResult text = bench.rhoray({"formats"});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_EQ(text.err, "");
  EXPECT_THAT(text.out, HasSubstr("  volume          NRRD                            .nrrd .nhdr\n"));
  EXPECT_THAT(text.out, HasSubstr("\nWritten:\n"));
  for (const std::string& extension : read) EXPECT_THAT(text.out, HasSubstr(extension));
}

/// Every volume, mesh or surface that is written for other programs can be read again.
TEST(Formats, that_are_exported_are_read_but_for_nanovdb) {
  for (const ExportFormat& format : export_formats) {
    const bool is_read =
        preprocess::foreign_kind(std::string("a") + format.extension) != preprocess::ForeignKind::unknown;
    EXPECT_EQ(is_read, std::string_view(format.extension) != ".nvdb") << format.extension;
  }
}

}  // namespace
}  // namespace rhoray::tools

// Checks the object files of sources that are compiled once per machine type.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/run_program.h"

namespace rhoray::tests {
namespace {

std::vector<std::filesystem::path> render_objects() {
  std::vector<std::filesystem::path> found;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::filesystem::path(RHORAY_BINARY_DIR) / "render"))
    if (entry.path().extension() == ".o") found.push_back(entry.path());
  return found;
}

/// Functions for which the linker keeps one of several copies, by their linker names.
std::set<std::string> weak_functions(const std::filesystem::path& object) {
  const RunResult listed = run_program({"nm", "--defined-only", object});
  EXPECT_EQ(listed.exit_code, 0) << listed.err;
  std::set<std::string> names;
  std::istringstream lines(listed.out);
  std::string address, kind, name;
  while (lines >> address >> kind >> name)
    if (kind == "W" || kind == "V" || kind == "u") names.insert(name);
  return names;
}

struct Disassembled {
  std::set<std::string> with_avx;  ///< functions
  std::size_t function_count = 0;
};

/// Functions that use instructions or registers that only machines with AVX have.
Disassembled disassembled(const std::filesystem::path& object) {
  const RunResult listed = run_program({"objdump", "-d", "--no-show-raw-insn", object});
  EXPECT_EQ(listed.exit_code, 0) << listed.err;
  const std::regex head(R"(^[0-9a-f]+ <(.+)>:$)");
  Disassembled found;
  std::istringstream lines(listed.out);
  std::string line, function;
  while (std::getline(lines, line)) {
    std::smatch match;
    if (!line.empty() && line.back() == ':' && std::regex_match(line, match, head)) {
      function = match[1];
      ++found.function_count;
      continue;
    }
    const std::size_t tab = line.rfind('\t', line.find('%'));
    if (line.find("%ymm") != line.npos || line.find("%zmm") != line.npos ||
        (tab != line.npos && line.compare(tab + 1, 1, "v") == 0 && line.compare(tab + 1, 3, "ver") != 0))
      found.with_avx.insert(function);
  }
  return found;
}

TEST(ObjectFiles, of_render_hold_no_code_for_one_machine_that_another_may_be_given) {
  std::size_t functions_with_avx = 0;
  for (const std::filesystem::path& object : render_objects()) {
    const std::set<std::string> weak = weak_functions(object);
    const Disassembled code = disassembled(object);
    functions_with_avx += code.with_avx.size();
    for (const std::string& function : code.with_avx) {
      // its name contains the machine type
      const bool is_of_one_machine = function.find("N_AVX") != function.npos;
      EXPECT_TRUE(is_of_one_machine || !weak.contains(function)) << object << ": " << function;
    }
  }
  if (functions_with_avx == 0) GTEST_SKIP() << "these kernels are compiled for no machine with AVX";
}

}  // namespace
}  // namespace rhoray::tests

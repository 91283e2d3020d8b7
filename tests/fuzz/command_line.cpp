// Fuzzes command lines, one word per line. Parses them and takes every value, but runs nothing.
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/checks.h"
#include "tests/fuzz/harness.h"
#include "tools/rhoray/cli/command_line.h"
#include "tools/rhoray/subcommands.h"

using namespace rhoray::tools;

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  RHORAY_CHECK(std::freopen("/dev/null", "w", stdout) != nullptr);  // hides the help
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::string> words{"rhoray", ""};
  for (const char letter : std::string(reinterpret_cast<const char*>(data), size)) {
    if (letter == '\n')
      words.emplace_back();
    else if (letter != '\0')  // no word of a command line contains one
      words.back() += letter;
  }
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());

  // Values stay in what a subcommand's rows point to: each command line gets new subcommands.
  std::vector<Subcommand> subcommands = all_subcommands();
  std::vector<std::function<int()>> not_run;  // own what the rows point to
  bool ran = false;
  for (Subcommand& subcommand : subcommands) {
    not_run.push_back(std::move(subcommand.run));
    subcommand.run = [&ran] {
      ran = true;
      return 0;
    };
  }
  const int code = run_command_line(subcommands, static_cast<int>(arguments.size()), arguments.data());
  RHORAY_CHECK(code == 0 || code == 2 || code == 3 || code == 4 || code == 7);
  RHORAY_CHECK(!ran || code == 0);
  return 0;
}

// Writes the manual pages into a folder: write_manuals FOLDER DATE. Part of the build, not
// installed.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "formats/base/text.h"
#include "tools/rhoray/cli/manual.h"
#include "tools/rhoray/subcommands.h"

int main(int argc, char** argv) try {
  using namespace rhoray;
  if (argc != 3) throw std::runtime_error("expected a folder and a date such as 2026-11-27");
  const std::filesystem::path folder = argv[1];
  const std::string date = argv[2];
  std::filesystem::create_directories(folder);
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream file(folder / (name + ".1"));
    if (!(file << text).flush()) throw std::runtime_error(concat("cannot write ", name));
  };
  const std::vector<tools::Subcommand> subcommands = tools::all_subcommands();
  write("rhoray", tools::manual_page(subcommands, date));
  for (const tools::Subcommand& each : subcommands) write("rhoray-" + each.name, tools::manual_page(each, date));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "write_manuals: %s\n", error.what());
  return 1;
}

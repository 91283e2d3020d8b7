#include "tools/rhoray/subcommands.h"

#include <utility>

namespace rhoray::tools {

namespace {

constexpr std::pair<std::string_view, Subcommand (*)()> makers[] = {{"info", info_subcommand},
                                                                    {"pack", pack_subcommand},
                                                                    {"verify", verify_subcommand},
                                                                    {"export", export_subcommand},
                                                                    {"formats", formats_subcommand},
                                                                    {"import", import_subcommand},
                                                                    {"tetrahedralize", tetrahedralize_subcommand},
                                                                    {"resample", resample_subcommand},
                                                                    {"cache", cache_subcommand},
                                                                    {"render", render_subcommand},
                                                                    {"view", view_subcommand},
                                                                    {"compare", compare_subcommand},
                                                                    {"accuracy", accuracy_subcommand},
                                                                    {"validate", validate_subcommand},
                                                                    {"measure", measure_subcommand},
                                                                    {"selftest", selftest_subcommand},
                                                                    {"bench", bench_subcommand}};

}  // namespace

std::vector<Subcommand> all_subcommands() {
  std::vector<Subcommand> all;
  for (const auto& [name, make] : makers) all.push_back(make());
  return all;
}

std::vector<Subcommand> subcommands_for(std::string_view word) {
  for (const auto& [name, make] : makers)
    if (word == name) return {make()};
  return all_subcommands();
}

}  // namespace rhoray::tools

#include <chrono>
#include <cstdio>
#include <ctime>

#include "formats/base/number_text.h"
#include "preprocess/pack_cache.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct CacheCommand {
  CommonOptions common;
  bool clear = false;
};

/// "2026-11-26 14:05", local time.
std::string time_text(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm local{};
  ::localtime_r(&seconds, &local);
  char text[32];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", &local)};
}

std::uint64_t bytes_of(const std::vector<preprocess::PackCache::Entry>& entries) {
  std::uint64_t sum = 0;
  for (const auto& entry : entries) sum += entry.bytes;
  return sum;
}

Json json_of(const std::vector<preprocess::PackCache::Entry>& entries) {
  Json json = Json::array();
  for (const auto& entry : entries)
    json.push_back({{"input", entry.input.string()},
                    {"options", entry.options},
                    {"bytes", entry.bytes},
                    {"used", std::chrono::duration_cast<std::chrono::seconds>(entry.used.time_since_epoch()).count()}});
  return json;
}

Json json_of(const preprocess::PackCache& cache, const std::vector<preprocess::PackCache::Entry>& entries) {
  return {{"folder", cache.folder().string()},
          {"limit_bytes", cache.limit_bytes()},
          {"bytes", bytes_of(entries)},
          {"entries", json_of(entries)}};
}

int run(const CacheCommand& command) {
  const preprocess::PackCache cache = open_cache();
  if (command.clear) {
    const std::vector<preprocess::PackCache::Entry> removed = cache.clear();
    say(command.common, concat("removed ", counted(removed.size(), "packed copy", "packed copies"), ", ",
                               bytes_text(bytes_of(removed)), ", from ", cache.folder().string()));
    if (!command.common.json) return 0;
    Json json = json_of(cache, cache.entries());
    json["removed"] = json_of(removed);
    std::puts(dump(json).c_str());
    return 0;
  }
  const std::vector<preprocess::PackCache::Entry> entries = cache.entries();
  if (command.common.json) {
    std::puts(dump(json_of(cache, entries)).c_str());
    return 0;
  }
  std::puts(concat(cache.folder().string(), ": ", counted(entries.size(), "packed copy", "packed copies"), ", ",
                   bytes_text(bytes_of(entries)), " of at most ", bytes_text(cache.limit_bytes()))
                .c_str());
  for (const auto& entry : entries)
    std::puts(concat("  ", time_text(entry.used), "  ", bytes_text(entry.bytes), "  ", entry.input.string(),
                     entry.options.empty() ? "" : concat("  (", entry.options, ")"))
                  .c_str());
  return 0;
}

}  // namespace

Subcommand cache_subcommand() {
  const auto command = std::make_shared<CacheCommand>();
  return {.name = "cache",
          .summary = "List or remove the packed copies of files",
          .group = "Files",
          .examples = {"rhoray cache", "rhoray cache --clear", "rhoray cache --json"},
          .sections = {{.heading = "Packed copies",
                        .entries = {{"",
                                     "`rhoray render head.nrrd` packs the file first, and keeps the packed copy. The "
                                     "copy is used as long as the file, and every other file that packing read, is "
                                     "unchanged."},
                                    {"folder", "$XDG_CACHE_HOME/rhoray, default ~/.cache/rhoray"},
                                    {"limit",
                                     "20 GiB, or RHORAY_CACHE_SIZE, such as 5G; copies that were not used for the "
                                     "longest time are removed first"}}}},
          .options = all_options(
              {{flag_option("--clear", "Remove all packed copies", command->clear)},
               message_options(command->common, "Print the list, and what was removed, as JSON to stdout")}),
          .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

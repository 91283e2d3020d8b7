#include <cstdio>
#include <memory>
#include <optional>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "tools/analysis/heat_map.h"
#include "tools/analysis/picture_difference.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct CompareCommand {
  CommonOptions common;
  std::vector<std::filesystem::path> files;
  std::optional<double> limit;  ///< of a pixel's difference
  std::optional<double> share;  ///< of pixels that may be beyond it
  std::filesystem::path map;
};

void check(const CompareCommand& command) {
  if (command.files.size() != 2)
    throw Error(ErrorCode::usage, concat("pictures: found ", command.files.size(), "; expected 2"),
                "rhoray compare a.png b.png");
  if (command.limit && !(*command.limit >= 0))
    throw Error(ErrorCode::usage, concat("--fail: found ", *command.limit, "; expected 0 or more"));
  if (command.share && !(*command.share >= 0 && *command.share <= 1))
    throw Error(ErrorCode::usage, concat("--fail-share: found ", *command.share, "; expected 0 to 1"));
  if (command.share && !command.limit) throw Error(ErrorCode::usage, "--fail-share: needs --fail");
  if (command.map.empty()) return;
  require_picture_format(command.map, {});
  for (const std::filesystem::path& file : command.files) require_writable(command.common, command.map, file);
}

double share_of(std::uint64_t pixels, const PictureDifference& difference) {
  return static_cast<double>(pixels) / static_cast<double>(difference.of_pixel.size());
}

std::string text_of(const PictureDifference& difference, const CompareCommand& command) {
  const auto pixels = [&](std::uint64_t count) {
    return concat(count, " of ", difference.of_pixel.size(), " (", rounded(100 * share_of(count, difference)), " %)\n");
  };
  std::string text = concat("channels            ", listed(difference.channels), "\n");
  if (!difference.only_a.empty())
    text += concat("only in ", command.files[0].string(), ": ", listed(difference.only_a), "\n");
  if (!difference.only_b.empty())
    text += concat("only in ", command.files[1].string(), ": ", listed(difference.only_b), "\n");
  text += concat("pixels that differ  ", pixels(difference.differing));
  if (difference.differing != 0) {
    const LargestDifference& largest = difference.largest;
    text += concat("largest difference  ", rounded(largest.size), ": ", largest.channel, " at (", largest.x, ", ",
                   largest.y, "), ", rounded_within(largest.size, largest.a), " and ",
                   rounded_within(largest.size, largest.b), "\n");
    text += concat("root mean square    ", rounded(difference.root_mean_square), " (",
                   rounded(difference.peak_signal_to_noise()), " dB)\nmean                ", rounded(difference.mean),
                   "\n");
  }
  if (command.limit)
    text += concat("beyond ", rounded(*command.limit), ": ", pixels(difference.beyond(*command.limit)));
  return text;
}

Json difference_json(const PictureDifference& difference, const CompareCommand& command) {
  const LargestDifference& largest = difference.largest;
  Json json{{"a", command.files[0].string()},
            {"b", command.files[1].string()},
            {"channels", difference.channels},
            {"only_a", difference.only_a},
            {"only_b", difference.only_b},
            {"pixels", difference.of_pixel.size()},
            {"differing", difference.differing},
            {"largest", {{"size", largest.size}, {"channel", largest.channel}, {"x", largest.x}, {"y", largest.y}}},
            {"root_mean_square", difference.root_mean_square},
            {"mean", difference.mean}};
  if (command.limit) json["limit"] = *command.limit, json["beyond"] = difference.beyond(*command.limit);
  return json;
}

/// Refuses channels that only one picture has: they are not compared.
void require_same_channels(const PictureDifference& difference, const CompareCommand& command) {
  const auto require_none = [](const std::vector<std::string>& only, const auto& file, const auto& other) {
    if (!only.empty())
      throw Error(ErrorCode::outside_limit, concat(file.string(), ": has the channel", only.size() == 1 ? " " : "s ",
                                                   listed(only), ", which ", other.string(), " has not"));
  };
  require_none(difference.only_a, command.files[0], command.files[1]);
  require_none(difference.only_b, command.files[1], command.files[0]);
}

int run(const CompareCommand& command) {
  check(command);
  const StoredPicture a = read_picture(command.files[0]), b = read_picture(command.files[1]);
  const PictureDifference difference = difference_of(a, b, command.files[0].string(), command.files[1].string());
  std::fputs(command.common.json ? (dump(difference_json(difference, command)) + "\n").c_str()
                                 : text_of(difference, command).c_str(),
             stdout);
  if (!command.map.empty()) {
    write_picture(difference_map(difference.of_pixel, a.width, a.height), {}, command.map, command.common.force);
    say(command.common, concat(command.map.string(), ": black means equal; brighter means a larger difference"));
  }
  if (!command.limit) return 0;
  require_same_channels(difference, command);
  const std::uint64_t beyond = difference.beyond(*command.limit);
  if (share_of(beyond, difference) > command.share.value_or(0))
    throw Error(ErrorCode::outside_limit,
                concat(command.files[1].string(), ": ", beyond, beyond == 1 ? " pixel differs" : " pixels differ",
                       " by more than ", rounded(*command.limit), " from ", command.files[0].string()));
  return 0;
}

}  // namespace

Subcommand compare_subcommand() {
  const auto command = std::make_shared<CompareCommand>();
  return {.name = "compare",
          .summary = "Compare two pictures",
          .group = "Pictures",
          .examples = {"rhoray compare before.png after.png",
                       "rhoray compare before.png after.png --fail 0.01 --fail-share 0.001 --map where.png"},
          .sections = {{.heading = "Notes",
                        .entries = {{"",
                                     "Channels of the same name are compared as stored: integers of 8 and 16 bits as "
                                     "numbers from 0 to 1 (in sRGB), EXR channels without conversion."}},
                        .is_expert = true}},
          .options = all_options(
              {{files_option("A B", "Two pictures of the same size", command->files),
                value_option(
                    "--fail", "E",
                    "Exit code 6 if a pixel differs by more than E, or the channels differ; 0 requires equal pictures",
                    command->limit),
                value_option("--fail-share", "S", "Share of pixels that may differ by more; default 0", command->share),
                value_option("--map", "FILE", "Write a picture of the differences", command->map),
                flag_option("--force", "Overwrite an existing map", command->common.force)},
               message_options(command->common, "Print the results as JSON to stdout")}),
          .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

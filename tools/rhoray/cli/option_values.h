#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/read_value.h"
#include "formats/packed_file.h"
#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

/// A number of bytes, read from 2G, 512M, 64K, 1.5T or a plain number (1K = 1024).
struct ByteCount {
  std::uint64_t bytes = 0;
};

using rhoray::read_value;  // of numbers, vectors and names
void read_value(const std::string& text, ByteCount& out);

/// A row for an option that takes one value.
template <class T>
Option value_option(std::string names, std::string value, std::string help, T& out) {
  return {Option::Kind::value, std::move(names), std::move(value), std::move(help),
          [&out](const std::string& text) { read_value(text, out); }};
}

/// A row for an option that takes a number within limits.
Option number_option(std::string names, std::string value, std::string help, const Interval<double>& limits,
                     std::optional<double>& out);

/// A row for an option that takes one of some words, which become the row's choices.
Option choice_option(std::string names, std::vector<std::string> words, std::string help, std::string& out);

Option flag_option(std::string names, std::string help, bool& out);
/// A row that prints a text to stdout instead of all else.
Option answer_option(std::string names, std::string help, std::string (*text)());
Option file_option(std::string name, std::string help, std::filesystem::path& out);
Option files_option(std::string name, std::string help, std::vector<std::filesystem::path>& out);

// What the help says about rows; see Option.
std::vector<Option> in_group(const std::string& group, std::vector<Option> rows);
Option with_details(Option row, std::string details);
Option for_experts(Option row);
std::vector<Option> for_experts(std::vector<Option> rows);

}  // namespace rhoray::tools

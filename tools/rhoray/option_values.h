#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "formats/packed_file.h"
#include "tools/rhoray/subcommand.h"

namespace rhoray::tools {

struct PictureSize {
  int width = 1280;
  int height = 720;
};

/// Linear RGB. Read from #rrggbb (sRGB) or from three linear numbers r,g,b in [0, 1].
struct Color {
  Vec3 linear;
};

/// A number of bytes, read from 2G, 512M, 64K, 1.5T or a plain number (1K = 1024).
struct ByteCount {
  std::uint64_t bytes = 0;
};

// Parsers of option values. All refuse with ErrorCode::usage and name what was found and what is
// expected. Numbers are finite and take the whole text.
void read_value(const std::string& text, std::string& out);
void read_value(const std::string& text, std::filesystem::path& out);
void read_value(const std::string& text, double& out);
void read_value(const std::string& text, std::int64_t& out);
void read_value(const std::string& text, std::uint64_t& out);
void read_value(const std::string& text, unsigned& out);
void read_value(const std::string& text, int& out);
void read_value(const std::string& text, Vec3& out);              ///< x,y,z
void read_value(const std::string& text, Interval<double>& out);  ///< a,b with a < b
void read_value(const std::string& text, PictureSize& out);       ///< WxH, 720p, 1080p, 4k; sides from 1 to 65,536
void read_value(const std::string& text, Color& out);
void read_value(const std::string& text, ByteCount& out);
void read_value(const std::string& text, formats::ElementType& out);      ///< U8, uint8, f32, float, ...
void read_value(const std::string& text, std::vector<std::string>& out);  ///< a,b,c, none of them empty

template <class T>
void read_value(const std::string& text, std::optional<T>& out) {
  T value;
  read_value(text, value);
  out = std::move(value);
}

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

/// Refuses a number outside [lo, hi] by name (ErrorCode::usage).
void require_within(const std::string& option, double value, double lo, double hi);

}  // namespace rhoray::tools

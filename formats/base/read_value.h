#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/vector.h"

namespace rhoray {

// The number that fills the whole text, or nothing.
std::optional<double> finite_number(std::string_view text);
std::optional<int> whole_number(std::string_view text);

// Values from text. All refuse with ErrorCode::usage and name what was found and what is expected.
// Numbers are finite and take the whole text.
void read_value(const std::string& text, std::string& out);
void read_value(const std::string& text, std::filesystem::path& out);
void read_value(const std::string& text, double& out);
void read_value(const std::string& text, std::int64_t& out);
void read_value(const std::string& text, std::uint64_t& out);
void read_value(const std::string& text, unsigned& out);
void read_value(const std::string& text, int& out);
void read_value(const std::string& text, Vec3& out);                      ///< x,y,z
void read_value(const std::string& text, Interval<double>& out);          ///< a,b with a < b
void read_value(const std::string& text, std::vector<std::string>& out);  ///< a,b,c, none of them empty

template <class T>
void read_value(const std::string& text, std::optional<T>& out) {
  T value;
  read_value(text, value);
  out = std::move(value);
}

/// The parts of a text between separators; at least one.
std::vector<std::string> split(const std::string& text, char separator);

[[noreturn]] void refuse_value(const std::string& text, std::string_view expected, const std::string& hint = {});

/// Refuses a number outside [lo, hi] by name (ErrorCode::usage).
void require_within(const std::string& name, double value, double lo, double hi);

}  // namespace rhoray

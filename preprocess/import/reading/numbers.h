#pragma once

#include <charconv>
#include <concepts>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

namespace rhoray::preprocess {

/// The whole text as a number, or nothing. Accepts a leading plus sign but no spaces.
/// Floating-point numbers may be nan or inf. As with strtod, those too large for T become infinity,
/// those too small become a subnormal or zero.
template <class T>
requires(std::integral<T> || std::floating_point<T>) std::optional<T> parse_number(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, reason] = std::from_chars(text.data(), end, value);
  if (stop != end || text.empty()) return std::nullopt;
  if (reason == std::errc::result_out_of_range) {
    if constexpr (std::floating_point<T>) {
      const std::string terminated(text);
      if constexpr (sizeof(T) == 4)
        return std::strtof(terminated.c_str(), nullptr);
      else
        return std::strtod(terminated.c_str(), nullptr);
    }
    return std::nullopt;
  }
  return reason == std::errc{} ? std::optional(value) : std::nullopt;
}

}  // namespace rhoray::preprocess

#pragma once

#include <charconv>
#include <concepts>
#include <string>
#include <string_view>

namespace rhoray {

namespace text_detail {
inline void append(std::string& out, std::string_view text) {
  out += text;
}
inline void append(std::string& out, char letter) {
  out += letter;
}
template <std::same_as<bool> T>  // a template, so that a string literal does not convert to bool
void append(std::string& out, T value) {
  out += value ? "true" : "false";
}
template <class T>
requires((std::integral<T> && !std::same_as<T, bool>) || std::floating_point<T>) void append(std::string& out,
                                                                                             T number) {
  char digits[64];
  // to_chars gives the shortest text that reads back to the same value.
  out.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}
}  // namespace text_detail

/// The parts as one text; numbers in the shortest form that reads back to the same value.
template <class... Parts>
std::string concat(const Parts&... parts) {
  std::string out;
  (text_detail::append(out, parts), ...);
  return out;
}

/// A count and its noun: "1 cell", "2 cells".
template <std::integral T>
std::string count_text(T count, std::string_view singular, std::string_view plural) {
  return concat(count, " ", count == 1 ? singular : plural);
}

}  // namespace rhoray

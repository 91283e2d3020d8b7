#include "formats/format_error.h"

namespace rhoray::formats {
namespace {

/// A text that may hold anything that stands in a file: control characters as \x1b, and no more of
/// it than a reader needs, so that a message is one line and does nothing to a terminal.
std::string shown(std::string_view text) {
  constexpr std::size_t most = 600;
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out;
  for (const char letter : text.substr(0, most)) {
    const auto code = static_cast<unsigned char>(letter);
    if (code >= 0x20 && code != 0x7f)
      out += letter;
    else
      out += concat("\\x", digits[code >> 4U], digits[code & 0xfU]);
  }
  if (text.size() > most) out += "...";
  return out;
}

}  // namespace

void refuse(std::string_view file, std::string_view place, std::string_view found, std::string_view expected,
            ErrorCode error_code) {
  throw Error(error_code, concat(file, ", ", shown(place), ": found ", shown(found), "; expected ", shown(expected)));
}

}  // namespace rhoray::formats

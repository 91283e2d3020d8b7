#include "formats/format_error.h"

namespace rhoray::formats {
namespace {

/// Makes text from a file safe for messages: control characters become \x1b and so on, and long
/// text is cut. So a message is one line and cannot affect a terminal.
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

#include "formats/base/printable.h"

#include "formats/base/text.h"

namespace rhoray {

std::string printable(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto code = static_cast<unsigned char>(text[i]);
    // U+0080 to U+009F in UTF-8: terminals may obey them, too
    const bool is_wide = code == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) - 0x80U < 0x20U;
    if (code >= 0x20 && code != 0x7f && !is_wide) {
      out += text[i];
      continue;
    }
    for (const char letter : text.substr(i, is_wide ? 2 : 1)) {
      const auto byte = static_cast<unsigned char>(letter);
      out += concat("\\x", digits[byte >> 4U], digits[byte & 0xfU]);
    }
    i += is_wide ? 1 : 0;
  }
  return out;
}

}  // namespace rhoray

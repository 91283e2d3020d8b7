#include "formats/label_names.h"

#include <cstdint>

namespace rhoray::formats {

std::size_t first_letter_bytes(std::string_view text) {
  if (text.empty()) return 0;
  const auto first = static_cast<unsigned char>(text[0]);
  if (first < 0x80) return first < 0x20 || first == 0x7f ? 0 : 1;
  const std::size_t count = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < count) return 0;
  std::uint32_t letter = first & (0xffU >> (count + 1));
  for (std::size_t i = 1; i < count; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xc0U) != 0x80) return 0;
    letter = letter << 6 | (next & 0x3fU);
  }
  constexpr std::uint32_t first_of_three_bytes = 0x800, first_of_four_bytes = 0x10000, last = 0x10ffff;
  if (count == 2) return letter < 0xa0 ? 0 : 2;
  if (count == 3) return letter < first_of_three_bytes || (letter >= 0xd800 && letter <= 0xdfff) ? 0 : 3;
  return letter < first_of_four_bytes || letter > last ? 0 : 4;
}

bool is_label_name(std::string_view text) {
  if (text.empty() || text.size() > longest_label_name_bytes) return false;
  while (!text.empty()) {
    const std::size_t bytes = first_letter_bytes(text);
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

}  // namespace rhoray::formats

#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

namespace rhoray::formats {

/// Names of labels: of integers among a field's values that mark objects, such as organs.
using LabelNames = std::map<int, std::string>;

inline constexpr std::size_t most_label_names = 1024;         ///< of a field
inline constexpr std::size_t longest_label_name_bytes = 128;  ///< of one name

/// Returns the bytes of the first character of a text, 1 to 4. Returns 0 where the text is empty,
/// or begins with a control character (U+0000 to U+001F, U+007F to U+009F) or with bytes that are
/// not UTF-8.
std::size_t first_letter_bytes(std::string_view text);

/// True for 1 to longest_label_name_bytes bytes of UTF-8 without control characters.
bool is_label_name(std::string_view text);

}  // namespace rhoray::formats

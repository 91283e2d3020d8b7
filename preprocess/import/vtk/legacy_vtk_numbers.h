#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "preprocess/import/reading/text_reading.h"
#include "preprocess/neutral.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Reads words and numbers of a legacy VTK file, in text or binary. Every count is checked against
/// the data that follows.
class LegacyVtkNumbers {
 public:
  explicit LegacyVtkNumbers(const ForeignFile& file) : words(file) {}

  WordReader words;
  bool are_binary = false;

  /// The next word, as a number type.
  formats::ElementType type();
  /// The next word, as the type of cell offsets and corners.
  formats::ElementType index_type();

  /// Numbers in native byte order. Binary numbers begin after the end of the line and are
  /// big-endian.
  Array<std::byte> values(formats::ElementType type, std::uint64_t tuples, int components, std::string_view what);

  /// I64 or I32. A negative number becomes too large to be valid.
  Array<std::uint64_t> whole_numbers(formats::ElementType type, std::uint64_t number, std::string_view what);
};

}  // namespace rhoray::preprocess

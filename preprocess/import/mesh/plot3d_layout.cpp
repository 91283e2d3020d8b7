#include "preprocess/import/mesh/plot3d_layout.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats/base/bytes.h"
#include "formats/base/text.h"
#include "preprocess/import/reading/numbers.h"

namespace rhoray::preprocess {
namespace {

constexpr std::string_view separators = " \t\r\n,";

/// Adds the points of a block; false if a size is below 1 or the sum exceeds `most`.
bool add_points(std::uint64_t& sum, const Index3& size, std::uint64_t most) {
  if (size[0] < 1 || size[1] < 1 || size[2] < 1) return false;
  const auto product = checked_product(
      {static_cast<std::uint64_t>(size[0]), static_cast<std::uint64_t>(size[1]), static_cast<std::uint64_t>(size[2])});
  if (!product || *product > most - sum) return false;
  sum += *product;
  return true;
}

std::uint64_t points_in(const Index3& size) {
  return static_cast<std::uint64_t>(size[0] * size[1] * size[2]);
}

/// Walks through a binary file, assuming one layout.
class BinaryWalk {
 public:
  BinaryWalk(std::span<const std::byte> bytes, const Plot3dLayout& layout) : bytes_(bytes), layout_(layout) {}

  /// The layout with its blocks, if the file has these bytes and, with records, their lengths.
  std::optional<Plot3dLayout> fit() {
    std::uint64_t block_count = 1;
    if (layout_.has_block_count) {
      if (!record(4)) return std::nullopt;
      block_count = integer_before(4);
    }
    if (block_count < 1 || block_count > bytes_.size() / 12 || !record(12 * block_count)) return std::nullopt;
    std::uint64_t points = 0;
    for (std::uint64_t i = 3 * block_count; i > 0; i -= 3) {
      const Index3 size(integer_before(4 * i), integer_before(4 * i - 4), integer_before(4 * i - 8));
      // most files that are not PLOT3D end here
      if (!add_points(points, size, bytes_.size())) return std::nullopt;
      layout_.blocks.push_back(size);
    }
    layout_.data_offset = at_;
    for (const Index3& block : layout_.blocks)
      if (!block_fits(points_in(block))) return std::nullopt;
    return layout_;
  }

  /// After a fit: true if nothing follows.
  bool is_exact() const { return at_ == bytes_.size(); }

  /// After a fit: true if only zeros follow, up to the end of a sector, as some writers leave them.
  bool is_padded() const {
    constexpr std::uint64_t sector = 512;
    const std::span<const std::byte> rest = bytes_.subspan(at_);
    return bytes_.size() % sector == 0 && rest.size() < sector &&
           std::all_of(rest.begin(), rest.end(), [](std::byte byte) { return byte == std::byte{0}; });
  }

 private:
  bool block_fits(std::uint64_t points) {
    const auto float_bytes = static_cast<std::uint64_t>(layout_.float_bytes);
    if (layout_.is_solution) return record(4 * float_bytes) && record(5 * points * float_bytes);
    return record(points * (3 * float_bytes + (layout_.has_iblank ? 4 : 0)));
  }

  /// Skips a record of this length.
  bool record(std::uint64_t length) {
    if (!marker(length)) return false;
    if (length > bytes_.size() - at_) return false;
    at_ += length;
    payload_end_ = at_;
    return marker(length);
  }

  bool marker(std::uint64_t length) {
    if (!layout_.has_records) return true;
    if (bytes_.size() - at_ < 4) return false;
    at_ += 4;
    return integer_at(at_ - 4) == length;
  }

  /// The 32-bit integer that starts `distance` bytes before the end of the last record's numbers.
  std::uint32_t integer_before(std::uint64_t distance) const { return integer_at(payload_end_ - distance); }

  std::uint32_t integer_at(std::uint64_t at) const {
    std::uint32_t value;
    std::memcpy(&value, bytes_.data() + at, sizeof value);
    return layout_.is_big_endian ? __builtin_bswap32(value) : value;
  }

  std::span<const std::byte> bytes_;
  Plot3dLayout layout_;
  std::uint64_t at_ = 0, payload_end_ = 0;
};

/// All layouts that are tried for a binary file.
std::vector<Plot3dLayout> binary_candidates() {
  std::vector<Plot3dLayout> candidates;
  for (const bool is_big_endian : {false, true})
    for (const bool has_records : {false, true})
      for (const bool has_block_count : {false, true})
        for (const int float_bytes : {4, 8})
          for (const auto& [is_solution, has_iblank] :
               {std::pair(false, false), std::pair(false, true), std::pair(true, false)})
            candidates.push_back({.is_solution = is_solution,
                                  .is_text = false,
                                  .is_big_endian = is_big_endian,
                                  .has_records = has_records,
                                  .has_block_count = has_block_count,
                                  .has_iblank = has_iblank,
                                  .float_bytes = float_bytes,
                                  .blocks = {},
                                  .data_offset = 0});
  return candidates;
}

std::vector<Plot3dLayout> binary_layouts(std::span<const std::byte> bytes) {
  std::vector<Plot3dLayout> exact, padded;
  for (const Plot3dLayout& candidate : binary_candidates()) {
    BinaryWalk walk(bytes, candidate);
    const std::optional<Plot3dLayout> found = walk.fit();
    if (found && walk.is_exact())
      exact.push_back(*found);
    else if (found && walk.is_padded())
      padded.push_back(*found);
  }
  return exact.empty() ? padded : exact;
}

bool begins_as_text(std::string_view text) {
  constexpr std::string_view letters = "0123456789+-.eEdD*, \t\r\n";
  return text.substr(0, 512).find_first_not_of(letters) == std::string_view::npos;
}

/// A count: an integer from 1 to 2^31 - 1.
std::optional<std::int64_t> next_size(Plot3dNumbers& numbers) {
  const std::optional<double> number = numbers.next();
  if (!number || !(*number >= 1 && *number <= 2147483647.0) || *number != std::floor(*number)) return std::nullopt;
  return static_cast<std::int64_t>(*number);
}

/// The block sizes at the beginning of a text; empty if there are none.
std::vector<Index3> sizes_in_text(std::string_view text, bool has_block_count) {
  Plot3dNumbers numbers(text);
  const std::int64_t count = has_block_count ? next_size(numbers).value_or(0) : 1;
  if (count < 1 || static_cast<std::uint64_t>(count) > text.size() / 6) return {};
  std::vector<Index3> blocks;
  for (std::int64_t block = 0; block < count; ++block) {
    const auto i = next_size(numbers), j = next_size(numbers), k = next_size(numbers);
    if (!i || !j || !k) return {};
    blocks.emplace_back(*i, *j, *k);
  }
  return blocks;
}

/// Number of numbers in a text; nothing if it contains something else, or too many.
std::optional<std::uint64_t> number_count(std::string_view text) {
  Plot3dNumbers numbers(text);
  std::uint64_t sum = 0;
  while (const std::optional<std::uint64_t> count = numbers.skip()) {
    if (*count == 0) return sum;
    if (__builtin_add_overflow(sum, *count, &sum)) return std::nullopt;
  }
  return std::nullopt;
}

std::vector<Plot3dLayout> text_layouts(std::string_view text) {
  std::vector<Plot3dLayout> layouts;
  std::optional<std::uint64_t> total;
  for (const bool has_block_count : {false, true}) {
    Plot3dLayout layout{.is_text = true, .has_block_count = has_block_count, .float_bytes = 8, .blocks = {}};
    layout.blocks = sizes_in_text(text, has_block_count);
    std::uint64_t points = 0;
    // A point takes three numbers. Repeat counts can shorten an array, but hardly all three.
    const bool is_plausible = std::all_of(layout.blocks.begin(), layout.blocks.end(),
                                          [&](const Index3& size) { return add_points(points, size, text.size()); });
    if (layout.blocks.empty() || !is_plausible) continue;
    if (!total) total = number_count(text);
    if (!total) return {};
    layout.data_offset = 3 * layout.blocks.size() + (has_block_count ? 1 : 0);
    const auto fits = [&](std::uint64_t numbers_of_blocks) { return *total == layout.data_offset + numbers_of_blocks; };
    if (fits(3 * points)) layouts.push_back(layout);
    layout.has_iblank = true;
    if (fits(4 * points)) layouts.push_back(layout);
    layout.has_iblank = false;
    layout.is_solution = true;
    if (fits(5 * points + 4 * layout.blocks.size())) layouts.push_back(layout);
  }
  return layouts;
}

}  // namespace

std::string in_words(const Plot3dLayout& layout) {
  std::string text = layout.is_solution ? "a solution of " : "a grid of ";
  const Index3& first = layout.blocks.front();
  text += concat(first[0], " x ", first[1], " x ", first[2], " points");
  if (layout.blocks.size() > 1)
    text += concat(" and ", count_text(layout.blocks.size() - 1, "more block", "more blocks"));
  if (layout.is_text)
    text += ", text";
  else
    text += concat(", ", 8 * layout.float_bytes, " bits, ", layout.is_big_endian ? "big" : "little", "-endian");
  if (layout.has_records) text += ", Fortran records";
  if (layout.has_block_count) text += ", with a block count";
  if (layout.has_iblank) text += ", IBLANK";
  return text;
}

std::vector<Plot3dLayout> plot3d_layouts(const ForeignFile& file) {
  return begins_as_text(file.text()) ? text_layouts(file.text()) : binary_layouts(file.bytes());
}

std::optional<double> Plot3dNumbers::next() {
  if (left_ == 0 && !take_word()) return std::nullopt;
  if (left_ == 0) return std::nullopt;
  --left_;
  return value_;
}

std::optional<std::uint64_t> Plot3dNumbers::skip() {
  if (left_ == 0 && !take_word()) return std::nullopt;
  return std::exchange(left_, 0);
}

/// False where the next word is not a number; at the end, no text is left.
bool Plot3dNumbers::take_word() {
  text_.remove_prefix(std::min(text_.find_first_not_of(separators), text_.size()));
  if (text_.empty()) return true;
  std::string_view word = text_.substr(0, text_.find_first_of(separators));
  text_.remove_prefix(word.size());
  left_ = 1;
  if (const std::size_t star = word.find('*'); star != std::string_view::npos) {
    const auto repetitions = parse_number<std::uint64_t>(word.substr(0, star));
    if (!repetitions || *repetitions == 0) return false;
    left_ = *repetitions;
    word.remove_prefix(star + 1);
  }
  std::optional<double> value = parse_number<double>(word);
  if (!value) {
    std::string with_e(word);
    std::replace_if(
        with_e.begin(), with_e.end(), [](char letter) { return letter == 'D' || letter == 'd'; }, 'e');
    value = parse_number<double>(with_e);
  }
  value_ = value.value_or(0);
  return value.has_value();
}

}  // namespace rhoray::preprocess

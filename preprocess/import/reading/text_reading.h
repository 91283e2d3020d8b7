#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/import/reading/numbers.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Reads a file as words separated by white space, with raw bytes in between for formats that mix
/// them. Every refusal names the line, and every read checks for the end.
class WordReader {
 public:
  explicit WordReader(const ForeignFile& file, std::size_t position = 0)
      : file_(file), text_(file.text()), position_(position) {}

  bool at_end();                                     ///< true if only white space is left
  std::string_view word(std::string_view expected);  ///< refuses at the end of the file
  /// the next word, not consumed; empty at the end
  std::string_view peek() const;
  /// rest of this line, without its line end; refuses at the end
  std::string_view line();
  std::span<const std::byte> bytes(std::uint64_t count, std::string_view expected);

  template <class T>
  T number(std::string_view expected) {
    const std::string_view text = word(expected);
    const std::optional<T> value = parse_number<T>(text);
    if (!value) refuse(text, expected);
    return *value;
  }

  std::array<double, 3> point() {
    std::array<double, 3> result;
    for (double& coordinate : result) coordinate = number<double>("three coordinates");
    return result;
  }

  /// The next bytes as a number.
  template <class T>
  T binary(std::string_view expected, bool is_big_endian) {
    std::array<std::byte, sizeof(T)> raw;
    const std::span<const std::byte> found = bytes(sizeof(T), expected);
    std::copy(found.begin(), found.end(), raw.begin());
    if (is_big_endian != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

  std::uint64_t bytes_left() const { return text_.size() - position_; }
  std::size_t position() const { return position_; }

  /// Refuses at the position where the last word began.
  [[noreturn]] void refuse(std::string_view found, std::string_view expected,
                           ErrorCode error_code = ErrorCode::invalid) const;

 private:
  void skip_space();

  const ForeignFile& file_;
  std::string_view text_;
  std::size_t position_;
  std::size_t last_ = 0;
};

/// Numbers of a file: words, or binary numbers of known width in either byte order.
class NumberReader {
 public:
  explicit NumberReader(const ForeignFile& file, std::size_t position = 0) : words(file, position) {}

  template <class T>
  T next(std::string_view expected) {
    return is_binary ? words.binary<T>(expected, is_big_endian) : words.number<T>(expected);
  }

  /// Binary numbers follow, the first one a 32-bit 1 from which the byte order is seen.
  void begin_binary() {
    is_binary = true;
    is_big_endian = false;
    const auto one = next<std::int32_t>("the number 1");
    is_big_endian = one != 1;
    if (one != 1 && one != 0x01000000) words.refuse(concat(one), "1, in one byte order or the other");
  }

  WordReader words;
  bool is_binary = false;
  bool is_big_endian = false;
};

/// Where the words of a line end.
enum class WordEnds { at_spaces_and_commas, at_spaces };

/// Reads a file line by line and splits each line into words. A comment begins with '#'. Skips
/// lines that are empty or contain only a comment.
class LineReader {
 public:
  explicit LineReader(const ForeignFile& file, WordEnds ends = WordEnds::at_spaces_and_commas)
      : file_(file), text_(file.text()), ends_(ends) {}

  /// moves to the next line with words; false at the end
  bool next();
  void need(std::string_view expected);  ///< like next, but refuses at the end
  const std::vector<std::string_view>& words() const { return words_; }
  /// The line from word i on, with commas and comments, without white space at its end.
  std::string_view text_from(std::size_t i) const;
  std::size_t line_number() const { return line_number_; }

  /// Word i of this line as a number; refuses if there is no such word.
  template <class T>
  T number(std::size_t i, std::string_view expected) const {
    if (i >= words_.size()) refuse("the line ends too early", expected);
    const std::optional<T> value = parse_number<T>(words_[i]);
    if (!value) refuse(words_[i], expected);
    return *value;
  }

  /// The point in the words from i on.
  std::array<double, 3> point(std::size_t i) const {
    constexpr std::string_view expected = "three coordinates";
    return {number<double>(i, expected), number<double>(i + 1, expected), number<double>(i + 2, expected)};
  }

  std::uint64_t bytes_left() const { return text_.size() - position_; }

  /// Adds a note if there are lines after the last record. Reads to the end.
  /// @param records  their name, in the plural
  void note_rest(std::string_view records, std::vector<std::string>& notes);

  /// Bytes after the current line, for formats that continue in binary.
  std::span<const std::byte> rest() const { return file_.bytes().subspan(position_); }

  [[noreturn]] void refuse(std::string_view found, std::string_view expected,
                           ErrorCode error_code = ErrorCode::invalid) const;

 private:
  const ForeignFile& file_;
  std::string_view text_;
  WordEnds ends_;
  std::size_t position_ = 0;
  std::size_t line_number_ = 0;
  std::string_view line_;
  std::vector<std::string_view> words_;
};

/// Text from a damaged file, shortened and cleaned for use in a message.
std::string in_quotes(std::string_view text);

std::string in_capitals(std::string_view text);

/// The text without spaces, tabs and line ends around it.
std::string_view trimmed(std::string_view text);

/// Takes the first word off a text, with the separators before it. Empty at the end.
std::string_view take_word(std::string_view& text, std::string_view separators);

}  // namespace rhoray::preprocess

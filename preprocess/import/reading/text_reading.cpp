#include "preprocess/import/reading/text_reading.h"

#include <algorithm>
#include <cctype>

namespace rhoray::preprocess {
namespace {

bool is_space(char letter) {
  return letter == ' ' || (letter >= '\t' && letter <= '\r');
}

}  // namespace

std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string result = "'";
  for (const char letter : text.substr(0, longest)) result += letter >= ' ' && letter <= '~' ? letter : '?';
  return result + (text.size() > longest ? "...'" : "'");
}

std::string in_capitals(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](char letter) { return static_cast<char>(std::toupper(static_cast<unsigned char>(letter))); });
  return result;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view spaces = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(spaces), text.size()));
  return text.substr(0, text.find_last_not_of(spaces) + 1);
}

std::string_view take_word(std::string_view& text, std::string_view separators) {
  text.remove_prefix(std::min(text.find_first_not_of(separators), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(separators));
  text.remove_prefix(word.size());
  return word;
}

void WordReader::skip_space() {
  while (position_ < text_.size() && is_space(text_[position_])) ++position_;
}

bool WordReader::at_end() {
  skip_space();
  return position_ == text_.size();
}

std::string_view WordReader::peek() const {
  std::size_t begin = position_;
  while (begin < text_.size() && is_space(text_[begin])) ++begin;
  std::size_t end = begin;
  while (end < text_.size() && !is_space(text_[end])) ++end;
  return text_.substr(begin, end - begin);
}

std::string_view WordReader::word(std::string_view expected) {
  const std::string_view found = peek();
  skip_space();
  last_ = position_;
  if (found.empty()) refuse("the end of the file", expected);
  position_ += found.size();
  return found;
}

std::string_view WordReader::line() {
  last_ = position_;
  if (position_ == text_.size()) refuse("the end of the file", "another line");
  const std::size_t end = std::min(text_.find('\n', position_), text_.size());
  std::string_view found = text_.substr(position_, end - position_);
  position_ = std::min(end + 1, text_.size());
  if (found.ends_with('\r')) found.remove_suffix(1);
  return found;
}

std::span<const std::byte> WordReader::bytes(std::uint64_t count, std::string_view expected) {
  last_ = position_;
  if (count > bytes_left())
    refuse(concat("the end of the file after ", bytes_left(), " bytes"), concat(count, " bytes of ", expected));
  const std::span<const std::byte> found = file_.bytes().subspan(position_, count);
  position_ += count;
  return found;
}

void WordReader::refuse(std::string_view found, std::string_view expected, ErrorCode error_code) const {
  const auto line_number = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(last_), '\n');
  const bool is_word = last_ < text_.size() && found.data() == text_.data() + last_;
  refuse_input(file_.path(), concat("line ", line_number), is_word ? in_quotes(found) : std::string(found), expected,
               error_code);
}

bool LineReader::next() {
  words_.clear();
  while (words_.empty()) {
    if (position_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', position_), text_.size());
    line_ = text_.substr(position_, end - position_);
    position_ = end + 1 > text_.size() ? text_.size() : end + 1;
    ++line_number_;
    const std::string_view line = line_.substr(0, line_.find('#'));
    for (std::size_t i = 0; i < line.size();) {
      const auto separates = [&](std::size_t k) {
        return is_space(line[k]) || (ends_ == WordEnds::at_spaces_and_commas && line[k] == ',');
      };
      while (i < line.size() && separates(i)) ++i;
      const std::size_t begin = i;
      while (i < line.size() && !separates(i)) ++i;
      if (i > begin) words_.push_back(line.substr(begin, i - begin));
    }
  }
  return true;
}

std::string_view LineReader::text_from(std::size_t i) const {
  std::string_view text = line_.substr(static_cast<std::size_t>(words_[i].data() - line_.data()));
  while (is_space(text.back())) text.remove_suffix(1);
  return text;
}

void LineReader::note_rest(std::string_view records, std::vector<std::string>& notes) {
  std::uint64_t count = 0;
  while (next()) ++count;
  if (count > 0)
    notes.push_back(concat(file_.path().filename().string(), ": ", count_text(count, "line", "lines"), " after the ",
                           records, count == 1 ? " was" : " were", " left out"));
}

void LineReader::need(std::string_view expected) {
  if (!next()) refuse("the end of the file", expected);
}

void LineReader::refuse(std::string_view found, std::string_view expected, ErrorCode error_code) const {
  const bool is_word =
      std::any_of(words_.begin(), words_.end(), [&](std::string_view word) { return word.data() == found.data(); });
  refuse_input(file_.path(), concat("line ", line_number_), is_word ? in_quotes(found) : std::string(found), expected,
               error_code);
}

}  // namespace rhoray::preprocess

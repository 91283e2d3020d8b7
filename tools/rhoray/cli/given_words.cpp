#include "tools/rhoray/cli/given_words.h"

#include <algorithm>

#include "formats/base/error.h"
#include "tools/rhoray/cli/synonyms.h"

namespace rhoray::tools {

namespace {

bool is_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-';
}

/// Reads the words from left to right.
class WordReader {
 public:
  WordReader(const std::string& subcommand, std::span<const Option> rows, std::span<const char* const> words)
      : subcommand_(subcommand), rows_(rows), words_(words.begin(), words.end()) {}

  std::vector<GivenWord> read() {
    bool all_are_positional = false;
    while (at_ < words_.size()) {
      const std::string word = words_[at_++];
      if (word == "--" && !all_are_positional)
        all_are_positional = true;
      else if (all_are_positional || !is_option(word))
        take_positional(word);
      else if (word.starts_with("--"))
        take_long(word);
      else
        take_short(word);
    }
    return given_;
  }

 private:
  /// The first row that passes; the count of rows if none does.
  template <class Passes>
  std::size_t find_row(const Passes& passes) const {
    return static_cast<std::size_t>(std::find_if(rows_.begin(), rows_.end(), passes) - rows_.begin());
  }

  /// The number of the row; the count of rows if there is none.
  std::size_t row_named(const std::string& name) const {
    const Option* const row = option_named(rows_, name);
    return row == nullptr ? rows_.size() : static_cast<std::size_t>(row - rows_.data());
  }

  void take_positional(const std::string& word) {
    const std::size_t row = find_row([&](const Option& each) {
      return each.kind == Option::Kind::files ||
             (each.kind == Option::Kind::file && std::none_of(given_.begin(), given_.end(), [&](const GivenWord& one) {
                return &rows_[one.row] == &each;
              }));
    });
    if (row == rows_.size())
      throw Error(ErrorCode::usage, concat("unexpected argument '", word, "'"),
                  concat("`rhoray ", subcommand_, " --help` shows what is expected"));
    given_.push_back({row, word});
  }

  void take_long(const std::string& word) {
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const std::size_t row = row_named(name);
    if (row == rows_.size()) refuse_unknown(name, name);
    if (equals == std::string::npos) return take(row, name);
    if (takes_no_value(rows_[row])) refuse_value_of(row, word);
    given_.push_back({row, word.substr(equals + 1)});
  }

  /// One letter with its value, or several letters without values.
  void take_short(const std::string& word) {
    for (std::size_t i = 1; i < word.size(); ++i) {
      const std::string name{'-', word[i]};
      const std::size_t row = row_named(name);
      if (row == rows_.size()) refuse_unknown(i == 1 ? word.substr(0, word.find('=')) : name, concat("-", word));
      const std::string rest = word.substr(i + 1);
      if (takes_no_value(rows_[row])) {
        if (rest.starts_with("=")) refuse_value_of(row, word);
        given_.push_back({row, {}});
        continue;
      }
      if (rest.empty()) return take(row, name);
      given_.push_back({row, rest.substr(rest.starts_with("=") ? 1 : 0)});
      return;
    }
  }

  /// An option alone in its word, and the value in the next word.
  void take(std::size_t row, const std::string& name) {
    if (takes_no_value(rows_[row])) {
      given_.push_back({row, {}});
      return;
    }
    if (at_ == words_.size())
      refuse_missing(row, name, "at the end", concat("`rhoray ", subcommand_, " --help` shows an example"));
    const std::string& value = words_[at_];
    if (value.starts_with("--") || row_named(value) != rows_.size())
      refuse_missing(row, name, concat("before ", value), concat("write ", name, "=", value, " if it is the value"));
    given_.push_back({row, value});
    ++at_;
  }

  [[noreturn]] void refuse_missing(std::size_t row, const std::string& name, const std::string& place,
                                   const std::string& hint) const {
    throw Error(ErrorCode::usage, concat(name, ": found no value ", place, "; expected ", rows_[row].value), hint);
  }

  [[noreturn]] void refuse_value_of(std::size_t row, const std::string& word) const {
    throw Error(ErrorCode::usage, concat(long_name(rows_[row]), ": takes no value; found '", word, "'"));
  }

  /// @param meant  the word as a long option
  [[noreturn]] void refuse_unknown(const std::string& name, const std::string& meant) const {
    std::vector<std::string> known;
    for (const Option& row : rows_)
      if (!is_positional(row)) known.push_back(long_name(row));
    const std::string hint = option_hint(meant.substr(0, meant.find('=')), known);
    throw Error(ErrorCode::usage, concat("unknown option ", name),
                hint.empty() ? concat("`rhoray ", subcommand_, " --help` lists the options") : hint);
  }

  const std::string& subcommand_;
  std::span<const Option> rows_;
  std::vector<std::string> words_;
  std::size_t at_ = 0;  ///< of the next word
  std::vector<GivenWord> given_{};
};

}  // namespace

std::vector<GivenWord> given_words(const std::string& subcommand, std::span<const Option> rows,
                                   std::span<const char* const> words) {
  return WordReader(subcommand, rows, words).read();
}

std::string short_name(const Option& row) {
  return row.names.size() > 2 && row.names[2] == ',' ? row.names.substr(0, 2) : std::string();
}

const Option* option_named(std::span<const Option> rows, std::string_view name) {
  const auto row = std::find_if(rows.begin(), rows.end(), [name](const Option& each) {
    return !is_positional(each) && (long_name(each) == name || (!name.empty() && short_name(each) == name));
  });
  return row == rows.end() ? nullptr : &*row;
}

std::string long_name(const Option& row) {
  return row.names.substr(row.names.find(',') + 1);
}

bool takes_no_value(const Option& row) {
  return row.kind == Option::Kind::flag || row.kind == Option::Kind::answer;
}

bool is_positional(const Option& row) {
  return row.kind == Option::Kind::file || row.kind == Option::Kind::files;
}

}  // namespace rhoray::tools

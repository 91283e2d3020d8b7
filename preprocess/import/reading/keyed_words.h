#pragma once

#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

#include "preprocess/import/reading/text_reading.h"

namespace rhoray::preprocess {

/// A header of lines that give words to a key.
class KeyedWords {
 public:
  explicit KeyedWords(const std::filesystem::path& path) : path_(path) {}

  /// Refuses a key that has words already.
  void set(const std::string& key, std::vector<std::string> words) {
    if (!values_.try_emplace(key, std::move(words)).second) refuse(key, "a second one", "each key once");
  }

  const std::filesystem::path& path() const { return path_; }
  bool has(const std::string& key) const { return values_.contains(key); }
  const std::vector<std::string>& words(const std::string& key) const {
    static const std::vector<std::string> none;
    const auto found = values_.find(key);
    return found == values_.end() ? none : found->second;
  }
  std::string word(const std::string& key, const std::string& otherwise) const {
    return words(key).empty() ? otherwise : words(key).front();
  }
  std::string need(const std::string& key) const {
    if (word(key, "").empty()) refuse(key, "nothing", "a value");
    return word(key, "");
  }
  /// Numbers of the first of these keys that is present; empty if none is.
  template <class T>
  std::vector<T> numbers(std::initializer_list<const char*> keys, std::size_t count) const {
    for (const char* key : keys) {
      if (!has(key)) continue;
      std::vector<T> result;
      for (const std::string& text : words(key)) {
        const std::optional<T> value = parse_number<T>(text);
        if (!value) refuse(key, in_quotes(text), "a number");
        result.push_back(*value);
      }
      if (result.size() != count) refuse(key, concat(result.size(), " numbers"), concat(count));
      return result;
    }
    return {};
  }
  template <class T>
  T number(const char* key, T otherwise) const {
    const std::vector<T> found = numbers<T>({key}, 1);
    return found.empty() ? otherwise : found.front();
  }

  [[noreturn]] void refuse(const std::string& key, std::string_view found, std::string_view expected,
                           ErrorCode error_code = ErrorCode::invalid) const {
    refuse_input(path_, concat("key ", key), found, expected, error_code);
  }

 private:
  std::filesystem::path path_;
  std::map<std::string, std::vector<std::string>> values_;
};

}  // namespace rhoray::preprocess

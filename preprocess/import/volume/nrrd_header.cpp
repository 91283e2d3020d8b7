#include "preprocess/import/volume/nrrd_header.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <sstream>

#include "formats/base/lower_case.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

constexpr std::string_view spaces = " \t\r";

struct HeaderLine {
  std::size_t number;      ///< from 1
  std::string text;        ///< without spaces at its end
  std::string key, value;  ///< "data file" of "Data File: a.raw"; both empty where the line has none
};

std::vector<HeaderLine> lines_of(std::string_view header) {
  constexpr std::size_t longest_header = std::size_t{16} << 20;
  std::istringstream all{std::string(header.substr(0, longest_header))};
  std::vector<HeaderLine> lines;
  for (std::string line; std::getline(all, line);) {
    line.resize(line.find_last_not_of(spaces) + 1);
    HeaderLine& read = lines.emplace_back(HeaderLine{lines.size() + 1, line, {}, {}});
    const std::size_t colon = line.find(':');
    if (colon == line.npos || line.starts_with('#') || line.substr(colon).starts_with(":=")) continue;
    read.key = lower_case(line.substr(0, colon));
    if (read.key == "datafile") read.key = "data file";
    const std::size_t begin = line.find_first_not_of(spaces, colon + 1);
    if (begin != line.npos) read.value = line.substr(begin);
  }
  return lines;
}

std::vector<std::string> files_named_by(const std::vector<HeaderLine>& lines) {
  std::vector<std::string> names;
  bool in_list = false;
  for (const HeaderLine& line : lines) {
    if (in_list) names.push_back(line.text);
    if (in_list || line.key != "data file" || line.value.empty()) continue;
    if (line.value.starts_with("LIST")) {
      in_list = true;
      continue;
    }
    std::istringstream words(line.value);
    std::string pattern;
    std::int64_t first = 0, last = 0, step = 0;
    constexpr std::int64_t most_files = 1 << 16;
    if (line.value.find('%') == std::string::npos || !(words >> pattern >> first >> last >> step) || step == 0 ||
        std::abs(first) > most_files || std::abs(last) > most_files) {
      names.push_back(line.value);
      continue;
    }
    for (std::int64_t number = first; step > 0 ? number <= last : number >= last; number += step)
      if (const auto name = numbered_name(pattern, number)) names.push_back(*name);
  }
  return names;
}

const HeaderLine* line_with(const std::vector<HeaderLine>& lines, std::string_view key) {
  const auto found = std::find_if(lines.begin(), lines.end(), [&](const HeaderLine& line) { return line.key == key; });
  return found == lines.end() ? nullptr : &*found;
}

void refuse_missing_keys(const std::filesystem::path& path, const std::vector<HeaderLine>& lines) {
  for (const auto& [key, expected] : {std::pair{"dimension", "dimension: 3"},
                                      {"type", "a type, such as type: short"},
                                      {"sizes", "the number of samples on each axis, such as sizes: 256 256 100"},
                                      {"encoding", "an encoding, such as encoding: raw"}})
    if (line_with(lines, key) == nullptr) refuse_input(path, "header", concat("no key '", key, "'"), expected);
}

void refuse_repeated_keys(const std::filesystem::path& path, const std::vector<HeaderLine>& lines) {
  std::set<std::string_view> seen;
  for (const HeaderLine& line : lines)
    if (!line.key.empty() && !seen.insert(line.key).second)
      refuse_input(path, concat("line ", line.number), concat("a second key '", line.key, "'"), "each key once");
}

/// Refuses the line that Teem quotes, as in `type info |shrt|` or `in "foo: bar"`.
void refuse_quoted_line(const std::filesystem::path& path, const std::vector<HeaderLine>& lines,
                        std::string_view reason) {
  for (const HeaderLine& line : lines) {
    if (line.key.empty()) continue;
    const bool has_bad_value = reason.find(concat(line.key, " info |", line.value, "|")) != reason.npos;
    if (has_bad_value && line.value.starts_with("LIST"))
      refuse_input(path, concat("line ", line.number), concat(files_named_by(lines).size(), " data files"),
                   "as many as the sizes need");
    if (has_bad_value)
      refuse_input(path, concat("line ", line.number), in_quotes(line.text),
                   concat("a value that the key '", line.key, "' takes"));
    if (reason.find(concat("\"", line.text, "\"")) != reason.npos)
      refuse_input(path, concat("line ", line.number), in_quotes(line.text), "a key of NRRD files");
  }
}

void refuse_missing_files(const std::filesystem::path& path, const std::vector<HeaderLine>& lines) {
  for (const std::string& name : files_named_by(lines))
    if (!is_there(path.parent_path() / name))
      refuse_input(path, "key data file", concat("no file '", name, "'"), "it relative to the header's folder");
}

}  // namespace

std::string_view nrrd_header(std::string_view text) {
  const std::size_t plain = text.find("\n\n"), with_returns = text.find("\n\r\n");
  if (plain == text.npos && with_returns == text.npos) return text;
  return text.substr(0, plain < with_returns ? plain + 2 : with_returns + 3);
}

std::vector<std::string> files_named_by(std::string_view header) {
  return files_named_by(lines_of(header));
}

void check_nrrd_magic(const std::filesystem::path& path) {
  constexpr std::string_view magic = "NRRD000", expected = "NRRD0001 to NRRD0005";
  const ForeignFile file(path);
  const std::string_view found = file.text().substr(0, magic.size() + 1);
  if (!found.starts_with(magic)) refuse_input(path, "byte 0", "another beginning", expected);
  if (found.size() == magic.size() || found.back() < '1' || found.back() > '5')
    refuse_input(path, "byte 0", in_quotes(found), expected, ErrorCode::unsupported);
}

void refuse_nrrd(const std::filesystem::path& path, std::string_view reason) {
  const ForeignFile file(path);
  const std::vector<HeaderLine> lines = lines_of(nrrd_header(file.text()));
  refuse_missing_keys(path, lines);
  refuse_repeated_keys(path, lines);
  refuse_quoted_line(path, lines, reason);
  const std::string& encoding = line_with(lines, "encoding")->value;
  if (reason.find("require endian") != reason.npos)
    refuse_input(path, "header", "no key 'endian'", "endian: little or endian: big");
  refuse_missing_files(path, lines);
  refuse_input(path, "samples", "damaged data, or too little of it",
               concat("all samples of the sizes, in the encoding ", in_quotes(encoding)));
}

}  // namespace rhoray::preprocess

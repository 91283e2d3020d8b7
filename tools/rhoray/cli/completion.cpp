#include "tools/rhoray/cli/completion.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "formats/base/text.h"
#include "tools/rhoray/cli/given_words.h"
#include "tools/rhoray/cli/help.h"

namespace rhoray::tools {

namespace {

using Candidates = std::vector<Completion::Candidate>;

bool is_field(const Option& row) {
  constexpr std::array<std::string_view, 3> fields{"--field", "--color-by", "--size-field"};
  return std::find(fields.begin(), fields.end(), long_name(row)) != fields.end();
}

Completion::Paths paths_of(const Option& row) {
  const std::string_view value = is_positional(row) ? row.names : row.value;
  if (value.starts_with("FOLDER") || value.starts_with("DIR")) return Completion::Paths::folders;
  return value.starts_with("FILE") || is_positional(row) ? Completion::Paths::files : Completion::Paths::none;
}

/// The positional arguments among the words.
std::vector<std::filesystem::path> files_in(std::span<const Option> rows, std::span<const std::string> words) {
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!words[i].starts_with("-"))
      files.emplace_back(words[i]);
    else if (const Option* row = option_named(rows, words[i]); row != nullptr && !takes_no_value(*row))
      ++i;
  }
  return files;
}

/// Candidates for the value of an option, or for a positional argument.
Completion values_of(const Option& row, const std::vector<std::filesystem::path>& files,
                     const FieldsOfFile& fields_of) {
  Completion completion{.candidates = {}, .paths = paths_of(row)};
  for (const std::string& choice : row.choices) completion.candidates.push_back({choice, {}});
  if (is_field(row))
    for (const std::filesystem::path& file : files)
      for (const std::string& field : fields_of(file))
        completion.candidates.push_back({field, concat("field of ", file.string())});
  return completion;
}

/// Keeps each candidate with this beginning once, sorted.
Completion beginning_with(const std::string& begin, Completion completion) {
  Candidates& candidates = completion.candidates;
  std::erase_if(candidates, [&](const auto& candidate) { return !candidate.word.starts_with(begin); });
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.word < b.word; });
  candidates.erase(
      std::unique(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.word == b.word; }),
      candidates.end());
  return completion;
}

Completion names_of_subcommands(std::span<const Subcommand> subcommands) {
  Completion completion;
  for (const Subcommand& each : subcommands) completion.candidates.push_back({each.name, each.summary});
  return completion;
}

Completion of_subcommand(const Subcommand& subcommand, std::span<const std::string> words,
                         const FieldsOfFile& fields_of) {
  const std::vector<Option> rows = rows_with_help(subcommand);
  const std::string& last = words.back();
  const std::span<const std::string> before = words.first(words.size() - 1);
  const std::vector<std::filesystem::path> files = files_in(rows, before);
  const bool is_behind_dashes = std::find(before.begin(), before.end(), "--") != before.end();
  if (!is_behind_dashes && !before.empty())
    if (const Option* row = option_named(rows, before.back()); row != nullptr && !takes_no_value(*row))
      return beginning_with(last, values_of(*row, files, fields_of));
  if (const std::size_t sign = last.find('=');
      !is_behind_dashes && last.starts_with("--") && sign != std::string::npos) {
    const Option* const row = option_named(rows, std::string_view(last).substr(0, sign));
    if (row == nullptr || takes_no_value(*row)) return {};
    return beginning_with(last.substr(sign + 1), values_of(*row, files, fields_of));
  }
  Completion completion;
  if (!is_behind_dashes && last.starts_with("-")) {
    for (const Option& row : rows)
      if (!is_positional(row))
        for (const std::string& name : {short_name(row), long_name(row)})
          if (!name.empty()) completion.candidates.push_back({name, row.help});
  } else {
    for (const Option& row : rows)
      if (is_positional(row)) completion = values_of(row, files, fields_of);
  }
  return beginning_with(last, std::move(completion));
}

}  // namespace

Completion completion_of(std::span<const Subcommand> subcommands, std::span<const std::string> words,
                         const FieldsOfFile& fields_of) {
  if (words.empty()) return {};
  const bool asks_for_help = words.size() == 2 && words.front() == "help";
  if (words.size() == 1 || asks_for_help) {
    Completion completion = names_of_subcommands(subcommands);
    if (!asks_for_help)
      for (const char* const other : {"help", "--help", "--version"}) completion.candidates.push_back({other, {}});
    return beginning_with(words.back(), std::move(completion));
  }
  for (const Subcommand& each : subcommands)
    if (each.name == words.front()) return of_subcommand(each, words.subspan(1), fields_of);
  return {};
}

std::string text_of(const Completion& completion) {
  std::string text;
  for (const Completion::Candidate& candidate : completion.candidates)
    text += concat(candidate.word, candidate.help.empty() ? "" : "\t", candidate.help, "\n");
  if (completion.paths == Completion::Paths::files) text += ":files\n";
  if (completion.paths == Completion::Paths::folders) text += ":folders\n";
  return text;
}

}  // namespace rhoray::tools

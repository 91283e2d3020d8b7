#include "tools/rhoray/cli/help.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "formats/base/text.h"

namespace rhoray::tools {

namespace {

constexpr std::size_t narrowest = 60, widest = 100, usual = 80;
constexpr std::size_t indent = 2, text_column = 22;
constexpr std::size_t common_examples = 3;

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  std::size_t at = 0;
  while ((at = text.find_first_not_of(" \n", at)) != std::string_view::npos) {
    const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
    words.emplace_back(text.substr(at, end - at));
    at = end;
  }
  return words;
}

/// Lines of at most `width` columns, filled with these pieces in order; a longer piece is cut,
/// behind a "|" if it has one there.
std::vector<std::string> filled(const std::vector<std::string>& pieces, std::size_t width) {
  std::vector<std::string> lines;
  for (std::string piece : pieces) {
    if (!lines.empty() && lines.back().size() + 1 + piece.size() <= width) {
      lines.back() += " " + piece;
      continue;
    }
    while (piece.size() > width) {
      const std::size_t bar = piece.rfind('|', width - 1), cut = bar == std::string::npos ? width : bar + 1;
      lines.push_back(piece.substr(0, cut));
      piece.erase(0, cut);
    }
    lines.push_back(piece);
  }
  return lines;
}

std::string paragraph(std::string_view text, std::size_t from_column, std::size_t width) {
  std::string lines;
  for (const std::string& line : wrapped(text, width - from_column))
    lines += concat(std::string(from_column, ' '), line, "\n");
  return lines;
}

std::string entry_text(const HelpSection::Entry& entry, std::size_t width) {
  if (entry.term.empty()) return paragraph(entry.text, indent, width);
  std::string lines = paragraph(entry.term, indent, width);
  std::string text = paragraph(entry.text, text_column, width);
  const std::size_t term_end = indent + entry.term.size();
  if (term_end + 2 > text_column || text.empty()) return lines + text;
  lines.pop_back();
  return lines + text.substr(term_end);
}

bool is_positional(const Option& row) {
  return row.kind == Option::Kind::file || row.kind == Option::Kind::files;
}

std::string usage(const Subcommand& subcommand) {
  std::string line = concat("Usage: rhoray ", subcommand.name);
  for (const Option& row : subcommand.options)
    if (is_positional(row)) {
      line += " " + row.names;
      // A name of several words lists all arguments.
      if (row.kind == Option::Kind::files && row.names.find(' ') == std::string::npos) line += "...";
    }
  return line + " [OPTIONS]";
}

HelpSection::Entry entry_of(const Option& row, HelpLevel level) {
  HelpSection::Entry entry{.term = row.names, .text = row.help};
  if (const std::size_t comma = entry.term.find(','); comma != std::string::npos) entry.term.insert(comma + 1, " ");
  if (!row.value.empty()) entry.term += " " + row.value;
  if (level == HelpLevel::all && !row.details.empty()) entry.text += ". " + row.details;
  return entry;
}

HelpSection& section_named(const std::string& heading, std::vector<HelpSection>& sections) {
  const auto found = std::find_if(sections.begin(), sections.end(),
                                  [&](const HelpSection& section) { return section.heading == heading; });
  return found != sections.end() ? *found : sections.emplace_back(HelpSection{.heading = heading, .entries = {}});
}

std::string text_of(const std::vector<HelpSection>& sections, std::size_t width) {
  std::string text;
  for (const HelpSection& section : sections) text += "\n" + section_text(section, width);
  return text;
}

}  // namespace

std::vector<Option> rows_with_help(const Subcommand& subcommand) {
  std::vector<Option> rows = subcommand.options;
  const std::string group = rows.empty() ? Option{}.group : rows.back().group;
  rows.push_back({.kind = Option::Kind::answer,
                  .names = "-h,--help",
                  .value = {},
                  .help = "Print this help",
                  .take = {},
                  .group = group});
  rows.push_back({.kind = Option::Kind::answer,
                  .names = "--help-all",
                  .value = {},
                  .help = "Print all options, with details, and all examples",
                  .take = {},
                  .group = group,
                  .is_expert = true});
  return rows;
}

std::size_t help_width() {
  const char* const text = std::getenv("COLUMNS");
  const std::string_view digits = text ? text : "";
  std::size_t columns = 0;
  const auto [end, error_code] = std::from_chars(digits.data(), digits.data() + digits.size(), columns);
  if (error_code != std::errc{} || end != digits.data() + digits.size()) columns = 0;
  if (winsize terminal{}; columns == 0 && ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &terminal) == 0) columns = terminal.ws_col;
  return columns == 0 ? usual : std::clamp(columns, narrowest, widest);
}

std::string help_text(const Subcommand& subcommand, HelpLevel level, std::size_t width) {
  std::string text = paragraph(subcommand.summary, 0, width) + paragraph(usage(subcommand), 0, width);
  const std::vector<std::string>& examples = subcommand.examples;
  const std::size_t shown = level == HelpLevel::all ? examples.size() : std::min(examples.size(), common_examples);
  if (shown > 0) text += "\nExamples:\n";
  for (std::size_t i = 0; i < shown; ++i) text += example_text(examples[i], width);

  std::vector<HelpSection> sections;
  const auto is_shown = [level](const auto& part) { return level == HelpLevel::all || !part.is_expert; };
  for (const Option& row : rows_with_help(subcommand))
    if (is_shown(row)) section_named(row.group, sections).entries.push_back(entry_of(row, level));
  std::copy_if(subcommand.sections.begin(), subcommand.sections.end(), std::back_inserter(sections), is_shown);
  text += text_of(sections, width);
  if (level == HelpLevel::common)
    text += "\n" + paragraph(concat("More options and examples: rhoray ", subcommand.name, " --help-all"), 0, width);
  return text;
}

std::vector<HelpSection> sections_of_program(std::span<const Subcommand> subcommands) {
  std::vector<HelpSection> sections;
  for (const Subcommand& each : subcommands)
    section_named(each.group, sections).entries.push_back({.term = each.name, .text = each.summary});
  sections.push_back(
      {.heading = "Options",
       .entries = {{"-h, --help", "Print this help"}, {"--version", "Print version, commit and compiler"}}});
  sections.push_back(
      {.heading = "Limits",
       .entries = {
           {"", "Worker processes read foreign files and run TetGen and CGAL. They have limits:"},
           {"memory",
            "--memory; default 8 GiB plus 1024 times the size of the input file, at most 90 % of the memory of the "
            "machine or of the control group; 90 % if an input names other files"},
           {"files", "256 open; each at most as large as the worker's memory, or as the output that it must write"},
           {"idle time", "60 s without CPU time, reading or writing"},
           {"", "Inputs must be files or folders; pipes and devices are refused."}}});
  sections.push_back({.heading = "Exit codes",
                      .entries = {{"0", "success"},
                                  {"1", "internal error"},
                                  {"2", "wrong usage"},
                                  {"3", "input missing or unreadable"},
                                  {"4", "input invalid or damaged"},
                                  {"5", "out of memory, disk or time"},
                                  {"6", "a comparison is outside its limit"},
                                  {"7", "unknown file type or version"},
                                  {"130, 143, 129", "ended by SIGINT, SIGTERM, SIGHUP"},
                                  {"141", "the reader of a pipe has ended"}}});
  sections.push_back(
      {.heading = "Environment",
       .entries = {{"RHORAY_CACHE_SIZE", "Size of all packed copies at most, such as 5G; default 20 GiB"},
                   {"XDG_CACHE_HOME", "Folder in which the folder rhoray holds packed copies; default ~/.cache"},
                   {"RHORAY_WORKER_DIR", "Folder of the worker programs; default the one where they were installed"},
                   {"RHORAY_MACHINE", "Instruction set of kernels: scalar, baseline, avx2 or avx512; default the best"},
                   {"COLUMNS", "Width of help texts"}},
       .is_expert = true});
  return sections;
}

std::string overview(std::span<const Subcommand> subcommands, std::size_t width) {
  std::vector<HelpSection> sections = sections_of_program(subcommands);
  std::erase_if(sections, [](const HelpSection& section) { return section.is_expert; });
  return concat("Ray tracing of volumes and tetrahedral meshes\n", "Usage: rhoray SUBCOMMAND FILE... [OPTIONS]\n",
                "\nExamples:\n", example_text("rhoray pack head.nrrd -o head.rho", width),
                example_text("rhoray render head.rho -o head.png", width), text_of(sections, width),
                "\nOptions of a subcommand: rhoray SUBCOMMAND --help\n");
}

std::string section_text(const HelpSection& section, std::size_t width) {
  std::string text = section.heading + ":\n";
  for (const HelpSection::Entry& entry : section.entries) text += entry_text(entry, width);
  return text;
}

std::string example_text(std::string_view command, std::size_t width) {
  if (indent + command.size() <= width) return concat(std::string(indent, ' '), command, "\n");
  std::vector<std::string> pieces;
  bool is_value = false;
  for (const std::string& word : words_of(command)) {
    if (is_value)
      pieces.back() += " " + word;
    else
      pieces.push_back(word);
    is_value = !is_value && word.starts_with("-") && word.find('=') == std::string::npos;
  }
  constexpr std::size_t further_indent = 6;
  constexpr std::string_view continued = " \\\n";
  std::string text;
  for (const std::string& line : filled(pieces, width - further_indent - 2))
    text += concat(text.empty() ? std::string(indent, ' ') : concat(continued, std::string(further_indent, ' ')), line);
  return text + "\n";
}

std::vector<std::string> wrapped(std::string_view text, std::size_t width) {
  std::vector<std::string> pieces;
  for (const std::string& word : words_of(text)) {
    if (word.starts_with("%") && !pieces.empty())
      pieces.back() += " " + word;
    else
      pieces.push_back(word);
  }
  return filled(pieces, width);
}

}  // namespace rhoray::tools

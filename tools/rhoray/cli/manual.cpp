#include "tools/rhoray/cli/manual.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "formats/base/text.h"
#include "tools/rhoray/cli/given_words.h"
#include "tools/rhoray/cli/help.h"

namespace rhoray::tools {

namespace {

constexpr std::size_t page_width = 76;  // of lines in the source; mandoc's limit is 80

/// Escapes the characters that roff interprets. Commands in backticks get double quotes. A line may
/// break behind a bar: lists of words are longer than lines.
std::string escaped(std::string_view text) {
  std::string out;
  bool is_quoted = false;
  for (const char letter : text) {
    switch (letter) {
      case '\\':
        out += "\\e";
        break;
      case '-':
        out += "\\-";
        break;
      case '~':
        out += "\\(ti";
        break;
      case '^':
        out += "\\(ha";
        break;
      case '\'':
        out += "\\(aq";
        break;
      case '|':
        out += "|\\:";
        break;
      case '`':
        is_quoted = !is_quoted;
        out += is_quoted ? "\\(lq" : "\\(rq";
        break;
      default:
        out += letter;
    }
  }
  return out;
}

/// Splits a text into lines. mdoc requires a new line for each sentence.
std::string paragraph(std::string_view text) {
  std::string lines;
  while (!text.empty()) {
    std::size_t end = text.find(". ");
    const bool is_last = end == std::string_view::npos;
    end = is_last ? text.size() : end + 1;
    for (const std::string& line : wrapped(escaped(text.substr(0, end)), page_width))
      lines += concat(line.starts_with(".") ? "\\&" : "", line, "\n");
    text.remove_prefix(is_last ? end : end + 1);
  }
  return lines;
}

/// "November 27, 2026" of "2026-11-27".
std::string long_date(const std::string& date) {
  constexpr std::array<std::string_view, 12> months{"January",   "February", "March",    "April",
                                                    "May",       "June",     "July",     "August",
                                                    "September", "October",  "November", "December"};
  return concat(months.at(std::stoul(date.substr(5, 2)) - 1), " ", std::stoul(date.substr(8, 2)), ", ",
                date.substr(0, 4));
}

std::string upper_case(std::string text) {
  for (char& letter : text)
    if (letter >= 'a' && letter <= 'z') letter = static_cast<char>(letter - 'a' + 'A');
  return text;
}

std::string beginning(const std::string& name, const std::string& summary, const std::string& date) {
  return concat(".Dd ", long_date(date), "\n.Dt ", upper_case(name), " 1\n.Os\n.Sh NAME\n.Nm ", name, "\n.Nd ",
                escaped(summary), "\n");
}

/// ".It Fl o , Fl \-output Ar FILE"
std::string item_of(const Option& row) {
  if (is_positional(row)) return concat(".It Ar ", escaped(row.names), "\n");
  std::string item = ".It";
  if (const std::string name = short_name(row); !name.empty()) item += concat(" Fl ", name.substr(1), " ,");
  item += concat(" Fl ", escaped(long_name(row).substr(1)));
  if (!row.value.empty()) item += concat(" Ar ", escaped(row.value));
  return item + "\n";
}

/// The help and the details of an option, with full stops.
std::string sentences_of(const Option& row) {
  std::string text = concat(row.help, ".");
  if (!row.details.empty()) text += concat(" ", row.details, ".");
  return text;
}

std::string list_of(const std::vector<HelpSection::Entry>& entries) {
  std::string list;
  bool is_open = false;
  for (const HelpSection::Entry& entry : entries) {
    if (entry.term.empty() && is_open) list += ".El\n.Pp\n";
    if (!entry.term.empty() && !is_open) list += ".Bl -tag -width Ds\n";
    is_open = !entry.term.empty();
    if (is_open) list += concat(".It ", escaped(entry.term), "\n");
    list += paragraph(entry.text);
  }
  return list + (is_open ? ".El\n" : "");
}

std::string examples_of(const std::vector<std::string>& examples) {
  std::string text = ".Sh EXAMPLES\n.Bd -literal -offset indent\n";
  for (const std::string& example : examples) text += escaped(example_text(example, page_width));
  return text + ".Ed\n";
}

}  // namespace

std::string manual_page(const Subcommand& subcommand, const std::string& date) {
  std::string page = beginning(concat("rhoray-", subcommand.name), subcommand.summary, date);
  page += concat(".Sh SYNOPSIS\n.Nm rhoray ", subcommand.name, "\n");
  std::vector<std::string> groups;  // in the order of the table
  const std::vector<Option> rows = rows_with_help(subcommand);
  for (const Option& row : rows) {
    if (is_positional(row))
      page += concat(".Ar ", escaped(row.names), row.kind == Option::Kind::files ? " ...\n" : "\n");
    if (std::find(groups.begin(), groups.end(), row.group) == groups.end()) groups.push_back(row.group);
  }
  page += concat(".Op Ar OPTIONS\n.Sh DESCRIPTION\n", paragraph(concat(subcommand.summary, ".")));
  page += ".Sh OPTIONS\n";
  for (const std::string& group : groups) {
    if (group != Option{}.group) page += concat(".Ss ", escaped(group), "\n");
    page += ".Bl -tag -width Ds\n";
    for (const Option& row : rows)
      if (row.group == group) page += item_of(row) + paragraph(sentences_of(row));
    page += ".El\n";
  }
  for (const HelpSection& section : subcommand.sections)
    page += concat(".Sh ", escaped(upper_case(section.heading)), "\n", list_of(section.entries));
  page += concat(".Sh EXIT STATUS\nSee\n.Xr rhoray 1 .\n", examples_of(subcommand.examples));
  return page + ".Sh SEE ALSO\n.Xr rhoray 1\n";
}

std::string manual_page(std::span<const Subcommand> subcommands, const std::string& date) {
  std::string page = beginning("rhoray", "ray tracing of volumes and tetrahedral meshes", date);
  page += ".Sh SYNOPSIS\n.Nm\n.Ar SUBCOMMAND\n.Ar FILE ...\n.Op Ar OPTIONS\n.Sh DESCRIPTION\n";
  page += paragraph(
      "Packs meshes and volumes into memory-mapped files, and ray traces them: isosurfaces of volumes and of "
      "tetrahedral meshes, maximum intensity projections, slices and boundaries. Any file that can be packed can also "
      "be rendered directly.");
  std::string environment, status;
  for (const HelpSection& section : sections_of_program(subcommands)) {
    const std::string list = list_of(section.entries);
    if (section.heading == "Environment")
      environment = ".Sh ENVIRONMENT\n" + list;
    else if (section.heading == "Exit codes")
      status = ".Sh EXIT STATUS\n" + list;
    else
      page += concat(".Ss ", escaped(section.heading), "\n", list);
  }
  page += environment + status;
  page +=
      examples_of({"rhoray pack head.nrrd -o head.rho", "rhoray render head.rho -o head.png", "rhoray view head.rho"});
  std::vector<std::string> names;
  for (const Subcommand& each : subcommands) names.push_back(each.name);
  std::sort(names.begin(), names.end());
  page += ".Sh SEE ALSO\n";
  for (const std::string& name : names) page += concat(".Xr rhoray-", name, " 1", name == names.back() ? "\n" : " ,\n");
  return page;
}

}  // namespace rhoray::tools

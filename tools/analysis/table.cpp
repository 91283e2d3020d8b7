#include "tools/analysis/table.h"

#include <algorithm>

#include "formats/base/number_text.h"

namespace rhoray::tools {

namespace {

std::vector<std::string> columns(const Table& table) {
  std::vector<std::string> names;
  if (!table.rows.empty())
    for (const auto& [name, value] : table.rows.front().items()) names.push_back(name);
  return names;
}

std::string shown(const Json& value) {
  if (value.is_null()) return "-";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return rounded(value.get<double>());
  return value.dump();
}

std::string csv_field(const Json& value) {
  if (value.is_null()) return {};
  if (!value.is_string()) return value.dump();
  std::string text = value.get<std::string>();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char letter : text) quoted += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return quoted + "\"";
}

}  // namespace

std::string text_of(const Table& table) {
  const std::vector<std::string> names = columns(table);
  std::vector<std::vector<std::string>> lines{names};
  for (const Json& row : table.rows) {
    std::vector<std::string>& line = lines.emplace_back();
    for (const std::string& name : names) line.push_back(shown(row.at(name)));
  }
  std::vector<std::size_t> widths(names.size(), 0);
  for (const auto& line : lines)
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());

  std::string text = table.title + "\n";
  for (const auto& line : lines) {
    std::string padded;
    for (std::size_t c = 0; c < line.size(); ++c) padded += line[c] + std::string(widths[c] - line[c].size() + 2, ' ');
    padded.erase(padded.find_last_not_of(' ') + 1);
    text += padded + "\n";
  }
  return text;
}

std::string csv_of(const Table& table) {
  const std::vector<std::string> names = columns(table);
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
  text += "\n";
  for (const Json& row : table.rows) {
    std::string line;
    for (std::size_t c = 0; c < names.size(); ++c) line += (c == 0 ? "" : ",") + csv_field(row.at(names[c]));
    text += line + "\n";
  }
  return text;
}

Json json_of(const Table& table) {
  return {{"table", table.name}, {"title", table.title}, {"context", table.context}, {"rows", table.rows}};
}

}  // namespace rhoray::tools

#include "tools/analysis/page_template.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <regex>
#include <utility>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/number_text.h"

namespace rhoray::tools {

namespace {

/// An item, and what surrounds it; outermost first.
using Scopes = std::vector<const Json*>;

/// Null if nothing has this name.
const Json* find(std::string_view name, const Scopes& scopes) {
  if (name == ".") return scopes.back();
  for (auto scope = scopes.rbegin(); scope != scopes.rend(); ++scope)
    if (const auto found = (*scope)->find(std::string(name)); (*scope)->is_object() && found != (*scope)->end())
      return &*found;
  return nullptr;
}

std::string shown(std::string_view tag, const Scopes& scopes) {
  const std::size_t bar = std::min(tag.find('|'), tag.size());
  const std::string_view name = tag.substr(0, bar), format = tag.substr(std::min(bar + 1, tag.size()));
  const Json* const found = find(name, scopes);
  if (found == nullptr) throw Error(ErrorCode::internal, concat("the report's template: no value '", name, "'"));
  if (found->is_null()) return "–";
  if (format == "grouped") return grouped(found->get<std::uint64_t>());
  if (format == "bytes") return bytes_text(found->get<std::uint64_t>());
  const std::string text = found->is_string() ? found->get<std::string>() : found->dump();
  if (format == "html") return text;
  if (format == "powers") return with_powers(html_text(text));
  return format.empty() ? html_text(text) : with_powers(short_number(found->get<double>(), format[0] - '0'));
}

/// What a section is repeated for.
Scopes items_of(std::string_view tag, const Scopes& scopes) {
  const Json* const found = find(tag.substr(1), scopes);
  const bool is_text = found != nullptr && found->is_string(), is_list = found != nullptr && found->is_array();
  const bool is_empty = found == nullptr || found->is_null() || *found == false || (is_list && found->empty()) ||
                        (is_text && found->get_ref<const std::string&>().empty());
  if (is_empty != (tag[0] == '^')) return {};
  if (is_empty) return {scopes.back()};
  if (!is_list) return {found};
  Scopes items;
  for (const Json& item : *found) items.push_back(&item);
  return items;
}

/// Fills from `at` to the end of the text or of the section; moves `at` behind it.
/// @param is_left_out  skips it
std::string fill(std::string_view text, std::size_t& at, Scopes& scopes, bool is_left_out) {
  std::string out;
  for (;;) {
    const std::size_t open = std::min(text.find("{{", at), text.size());
    out += text.substr(at, open - at);
    if (open == text.size()) {
      at = open;
      return out;
    }
    const std::size_t close = text.find("}}", open);
    const std::string_view tag = text.substr(open + 2, close - open - 2);
    at = close + 2;
    if (tag[0] == '/') return out;
    if (tag[0] == '#' || tag[0] == '^') {
      const std::size_t begin = at;
      const Scopes items = is_left_out ? Scopes{} : items_of(tag, scopes);
      for (const Json* const item : items) {
        at = begin;
        scopes.push_back(item);
        out += fill(text, at, scopes, false);
        scopes.pop_back();
      }
      if (items.empty()) fill(text, at, scopes, true);
    } else if (!is_left_out) {
      out += shown(tag, scopes);
    }
  }
}

}  // namespace

std::string html_text(std::string_view text) {
  static const std::map<char, const char*> escapes{{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string out;
  bool is_code = false;
  for (const char letter : text)
    if (const auto escape = escapes.find(letter); escape != escapes.end())
      out += escape->second;
    else if (letter == '`')
      out += std::exchange(is_code, !is_code) ? "</code>" : "<code>";
    else
      out += letter;
  return is_code ? out + "</code>" : out;
}

std::string with_powers(std::string_view html) {
  static const std::regex code_or_number("<code>[^<]*</code>|<[^>]*>|([0-9]+(?:\\.[0-9]+)?)e([+-])0*([0-9]+)");
  std::string out;
  std::size_t at = 0;
  for (std::cregex_iterator found(html.data(), html.data() + html.size(), code_or_number), end; found != end; ++found) {
    const std::cmatch& match = *found;
    out += html.substr(at, static_cast<std::size_t>(match.position()) - at);
    at = static_cast<std::size_t>(match.position() + match.length());
    if (!match[1].matched) {
      out += match.str();
      continue;
    }
    if (match[1] != "1") out += concat(match[1].str(), " × ");
    out += concat("10<sup>", match[2] == "-" ? "−" : "", match[3].str(), "</sup>");
  }
  return out.append(html.substr(at));
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 3; ++i) word = word << 8 | (i < count ? static_cast<std::uint8_t>(bytes[at + i]) : 0U);
    for (std::size_t i = 0; i < 4; ++i) out += i <= count ? letters[word >> (18 - 6 * i) & 63] : '=';
  }
  return out;
}

std::string short_number(double number, int digits) {
  const double size = std::abs(number);
  return size >= std::pow(10, digits) && size < 1e7 ? concat(std::llround(number)) : rounded(number, digits);
}

std::string fill_template(std::string_view text, const Json& values) {
  Scopes scopes{&values};
  std::size_t at = 0;
  return fill(text, at, scopes, false);
}

}  // namespace rhoray::tools

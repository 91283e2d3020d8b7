#include "preprocess/import/vtk/xml_outline.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <utility>

namespace rhoray::preprocess {
namespace {

constexpr std::string_view spaces = " \t\r\n";

/// Reads a character's number, such as `&#233;` or `&#xE9;`, and appends it in UTF-8. Returns the
/// bytes read; 0 if there is no such number.
std::size_t append_numbered(std::string& to, std::string_view text) {
  if (!text.starts_with("&#")) return 0;
  const std::size_t end = text.find(';');
  const bool is_hexadecimal = text.substr(2).starts_with('x');
  const std::string_view digits = text.substr(0, end).substr(is_hexadecimal ? 3 : 2);
  std::uint32_t code = 0;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), code, is_hexadecimal ? 16 : 10);
  if (end == text.npos || read.ec != std::errc() || read.ptr != digits.data() + digits.size() || code > 0x10FFFF)
    return 0;
  // bytes behind the first
  const int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
  constexpr std::uint32_t marks[] = {0, 0xC0, 0xE0, 0xF0};
  to += static_cast<char>(marks[more] | code >> (6 * more));
  for (int left = more - 1; left >= 0; --left) to += static_cast<char>(0x80 | (code >> (6 * left) & 0x3F));
  return end + 1;
}

}  // namespace

std::optional<std::string> without_entities(std::string_view text) {
  constexpr std::pair<std::string_view, char> entities[] = {
      {"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}};
  std::string result;
  while (!text.empty()) {
    if (text.front() != '&') {
      result += text.front();
      text.remove_prefix(1);
      continue;
    }
    if (const std::size_t read = append_numbered(result, text); read > 0) {
      text.remove_prefix(read);
      continue;
    }
    const auto* entity = std::find_if(std::begin(entities), std::end(entities),
                                      [&](const auto& known) { return text.starts_with(known.first); });
    if (entity == std::end(entities)) return std::nullopt;
    result += entity->second;
    text.remove_prefix(entity->first.size());
  }
  return result;
}

namespace {

class Parser {
 public:
  Parser(std::string_view text, std::string_view last) : text_(text), last_(last) {}

  std::optional<XmlElement> root() {
    XmlElement root;
    if (!next_tag() || is_at("</") || !element(root, 0)) return std::nullopt;
    return root;
  }

  std::size_t position() const { return std::min(at_, text_.size()); }

 private:
  static constexpr int deepest = 32;

  bool is_at(std::string_view word) const { return text_.substr(at_).starts_with(word); }

  bool skip_behind(std::string_view word) {
    const std::size_t found = text_.find(word, at_);
    if (found == text_.npos) return false;
    at_ = found + word.size();
    return true;
  }

  /// Moves to the next '<' that begins or ends an element.
  /// @param parts  receives the text up to there, cut at comments; may be null
  bool next_tag(std::vector<std::string_view>* parts = nullptr) {
    for (;;) {
      const std::size_t begin = at_;
      at_ = text_.find('<', at_);
      if (at_ == text_.npos) return false;
      if (parts != nullptr) parts->push_back(text_.substr(begin, at_ - begin));
      if (is_at("<?")) {
        if (!skip_behind("?>")) return false;
      } else if (is_at("<!--")) {
        if (!skip_behind("-->")) return false;
      } else if (is_at("<!DOCTYPE")) {
        if (!skip_document_type()) return false;
      } else {
        return !is_at("<!");
      }
    }
  }

  /// Moves behind a DOCTYPE that declares nothing, or has empty brackets. False for any other.
  bool skip_document_type() {
    const std::size_t end = std::min(text_.find_first_of("[>", at_), text_.size());
    const bool has_brackets = end < text_.size() && text_[end] == '[';
    at_ = end;
    if (has_brackets) {
      ++at_;
      skip_spaces();
      if (!is_at("]")) return false;
      ++at_;
      skip_spaces();
    }
    if (!is_at(">")) return false;
    ++at_;
    return true;
  }

  void skip_spaces() { at_ = std::min(text_.find_first_not_of(spaces, at_), text_.size()); }

  /// Returns the text from here to `end`, and moves there.
  std::string_view up_to(std::size_t end) {
    const std::string_view text = text_.substr(at_, end - at_);
    at_ = end;
    return text;
  }

  std::string_view word() { return up_to(std::min(text_.find_first_of(" \t\r\n=/><\"'", at_), text_.size())); }

  /// name = "value"
  bool attribute(XmlElement& element) {
    const std::string_view name = word();
    skip_spaces();
    if (name.empty() || !is_at("=")) return false;
    ++at_;
    skip_spaces();
    if (!is_at("\"") && !is_at("'")) return false;
    const char quote = text_[at_++];
    const std::size_t end = text_.find(quote, at_);
    if (end == text_.npos) return false;
    std::optional<std::string> value = without_entities(up_to(end));
    ++at_;
    return value && element.attributes.emplace(name, *std::move(value)).second;
  }

  /// Parses an element, from its '<' to its end.
  bool element(XmlElement& element, int depth) {
    ++at_;
    element.name = word();
    if (element.name.empty() || depth > deepest) return false;
    for (skip_spaces(); !is_at(">") && !is_at("/>"); skip_spaces())
      if (!attribute(element)) return false;
    if (is_at("/>")) {
      at_ += 2;
      return true;
    }
    ++at_;
    if (element.name == last_) {
      element.content = text_.substr(at_);
      at_ = text_.size();
      is_cut_ = true;
      return true;
    }
    return inside(element, depth);
  }

  bool inside(XmlElement& element, int depth) {
    std::vector<std::string_view> parts;
    if (!next_tag(&parts)) return false;
    element.content = parts.back();
    if (parts.size() > 1) {
      std::string joined;
      for (const std::string_view part : parts) joined += part;
      element.joined = std::make_shared<const std::string>(std::move(joined));
      element.content = *element.joined;
    }
    while (!is_at("</")) {
      if (!this->element(element.children.emplace_back(), depth + 1)) return false;
      if (is_cut_) return true;
      if (!next_tag()) return false;
    }
    at_ += 2;
    if (word() != element.name) return false;
    skip_spaces();
    if (!is_at(">")) return false;
    ++at_;
    return true;
  }

  std::string_view text_, last_;
  std::size_t at_ = 0;
  bool is_cut_ = false;  ///< the element `last` was reached
};

}  // namespace

std::string_view XmlElement::attribute(std::string_view name_of_attribute) const {
  const auto found = attributes.find(name_of_attribute);
  return found == attributes.end() ? std::string_view() : std::string_view(found->second);
}

const XmlElement* XmlElement::child(std::string_view name_of_child) const {
  const auto found = std::find_if(children.begin(), children.end(),
                                  [&](const XmlElement& element) { return element.name == name_of_child; });
  return found == children.end() ? nullptr : &*found;
}

std::optional<XmlElement> xml_outline(std::string_view text, std::string_view last, std::size_t& end) {
  Parser parser(text, last);
  std::optional<XmlElement> root = parser.root();
  end = parser.position();
  return root;
}

}  // namespace rhoray::preprocess

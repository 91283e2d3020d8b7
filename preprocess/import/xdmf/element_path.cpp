#include "preprocess/import/xdmf/element_path.h"

#include <algorithm>

#include "preprocess/import/reading/numbers.h"

namespace rhoray::preprocess {
namespace {

using Elements = std::vector<const XmlElement*>;

struct Step {
  bool at_any_depth = false;
  std::string_view name;  ///< or "*"
  std::vector<std::string_view> predicates{};
};

std::string_view without_spaces(std::string_view text) {
  constexpr std::string_view spaces = " \t\r\n";
  const std::size_t begin = std::min(text.find_first_not_of(spaces), text.size());
  return text.substr(begin, text.find_last_not_of(spaces) + 1 - begin);
}

/// The position of the bracket that ends a predicate; text.size() when there is none.
std::size_t end_of_predicate(std::string_view text) {
  char quote = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (quote != 0)
      quote = text[at] == quote ? '\0' : quote;
    else if (text[at] == '"' || text[at] == '\'')
      quote = text[at];
    else if (text[at] == ']')
      return at;
  }
  return text.size();
}

/// True for "*" and names of elements, not for axes, attributes and functions.
bool is_name(std::string_view text) {
  constexpr std::string_view others = "@.*()=\"' ";
  return text == "*" || (!text.empty() && text.find_first_of(others) == text.npos && text.find("::") == text.npos);
}

std::optional<std::vector<Step>> steps_of(std::string_view path) {
  std::vector<Step> steps;
  while (!path.empty()) {
    if (path.front() != '/') return std::nullopt;
    path.remove_prefix(1);
    Step& step = steps.emplace_back();
    step.at_any_depth = path.starts_with('/');
    if (step.at_any_depth) path.remove_prefix(1);
    const std::size_t end = std::min(path.find_first_of("/["), path.size());
    step.name = without_spaces(path.substr(0, end));
    if (!is_name(step.name)) return std::nullopt;
    for (path.remove_prefix(end); path.starts_with('[');) {
      const std::size_t close = end_of_predicate(path);
      if (close == path.size()) return std::nullopt;
      step.predicates.push_back(without_spaces(path.substr(1, close - 1)));
      path = path.substr(close + 1);
    }
    path = without_spaces(path);
  }
  return steps.empty() ? std::nullopt : std::optional(std::move(steps));
}

/// self::A or self::B
std::optional<bool> is_named(const XmlElement& element, std::string_view names) {
  constexpr std::string_view self = "self::", separator = " or ";
  bool result = false;
  while (!names.empty()) {
    const std::size_t end = std::min(names.find(separator), names.size());
    const std::string_view name = without_spaces(names.substr(0, end));
    if (!name.starts_with(self)) return std::nullopt;
    result = result || name.substr(self.size()) == element.name;
    names = names.substr(std::min(end + separator.size(), names.size()));
  }
  return result;
}

/// @Name="value"
std::optional<bool> has_attribute(const XmlElement& element, std::string_view predicate) {
  const std::size_t equals = std::min(predicate.find('='), predicate.size());
  const std::string_view name = without_spaces(predicate.substr(1, equals - 1));
  const std::string_view value = without_spaces(predicate.substr(std::min(equals + 1, predicate.size())));
  const bool is_quoted = value.size() > 1 && (value.front() == '"' || value.front() == '\'') &&
                         value.find(value.front(), 1) == value.size() - 1;
  if (!is_quoted) return std::nullopt;
  const auto found = element.attributes.find(name);
  return found != element.attributes.end() && found->second == value.substr(1, value.size() - 2);
}

/// @param position  of the element among those that passed so far, from 1
std::optional<bool> holds(const XmlElement& element, std::uint64_t position, std::string_view predicate) {
  if (const auto number = parse_number<std::uint64_t>(predicate)) return *number == position;
  if (predicate.starts_with('@')) return has_attribute(element, predicate);
  return predicate.empty() ? std::nullopt : is_named(element, predicate);
}

class Selection {
 public:
  Selection(const XmlElement& root, std::uint64_t& visits_left) : root_(root), visits_left_(visits_left) {}

  std::optional<Elements> by_names(std::string_view path) {
    const std::optional<std::vector<Step>> steps = steps_of(path);
    if (!steps) return std::nullopt;
    Elements contexts{nullptr};  // the document, whose only child is the root
    for (const Step& step : *steps) {
      Elements next;
      for (const XmlElement* context : contexts)
        if (!take(context, step, next)) return std::nullopt;
      contexts = std::move(next);
    }
    return contexts;
  }

  std::optional<Elements> by_positions(std::string_view path) {
    const XmlElement* found = nullptr;
    while (!path.empty()) {
      const std::size_t end = std::min(path.find('/', 1), path.size());
      const auto position = parse_number<std::uint64_t>(path.substr(1, end - 1));
      if (path.front() != '/' || !position) return std::nullopt;
      const std::size_t count = found == nullptr ? 1 : found->children.size();
      if (*position < 1 || *position > count) return Elements();
      found = found == nullptr ? &root_ : &found->children[*position - 1];
      path.remove_prefix(end);
    }
    return found == nullptr ? std::nullopt : std::optional(Elements{found});
  }

 private:
  /// Appends the children of a context that a step selects, and if asked those of all below it.
  bool take(const XmlElement* context, const Step& step, Elements& to) {
    Elements passed;
    const auto visit = [&](const XmlElement& child) {
      if (visits_left_ == 0) return false;
      --visits_left_;
      if (step.name == "*" || step.name == child.name) passed.push_back(&child);
      return true;
    };
    if (context == nullptr) {
      if (!visit(root_)) return false;
    } else {
      for (const XmlElement& child : context->children)
        if (!visit(child)) return false;
    }
    for (const std::string_view predicate : step.predicates)
      if (!keep_where(predicate, passed)) return false;
    to.insert(to.end(), passed.begin(), passed.end());
    if (!step.at_any_depth) return true;
    if (context == nullptr) return take(&root_, step, to);
    return std::all_of(context->children.begin(), context->children.end(),
                       [&](const XmlElement& child) { return take(&child, step, to); });
  }

  static bool keep_where(std::string_view predicate, Elements& elements) {
    Elements kept;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const std::optional<bool> is_kept = holds(*elements[i], i + 1, predicate);
      if (!is_kept) return false;
      if (*is_kept) kept.push_back(elements[i]);
    }
    elements = std::move(kept);
    return true;
  }

  const XmlElement& root_;
  std::uint64_t& visits_left_;
};

/// The text between the brackets of `name(...)`; nothing for other text.
std::optional<std::string_view> argument_of(std::string_view name, std::string_view text) {
  if (!text.starts_with(name) || !text.substr(name.size()).starts_with('(') || !text.ends_with(')'))
    return std::nullopt;
  return without_spaces(text.substr(name.size() + 1, text.size() - name.size() - 2));
}

}  // namespace

std::optional<std::vector<const XmlElement*>> select_elements(const XmlElement& root, std::string_view path,
                                                              std::uint64_t& visits_left) {
  path = without_spaces(path);
  Selection selection(root, visits_left);
  if (const auto positions = argument_of("element", path)) return selection.by_positions(*positions);
  return selection.by_names(argument_of("xpointer", path).value_or(path));
}

}  // namespace rhoray::preprocess

#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/text.h"

namespace rhoray {

/// The items as one text, with a separator between them and a mark before and after each.
template <class Items>
std::string joined(const Items& items, std::string_view separator = ", ", std::string_view mark = "") {
  std::string text;
  bool is_first = true;
  for (const auto& item : items) {
    text += concat(is_first ? "" : separator, mark, item, mark);
    is_first = false;
  }
  return text;
}

/// The names in the rows of a table.
/// @param name  which member of a row, or a function of it, is the name
template <class Rows, class Name>
std::vector<std::string> names_in(const Rows& rows, const Name& name) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.emplace_back(std::invoke(name, row));
  return names;
}

}  // namespace rhoray

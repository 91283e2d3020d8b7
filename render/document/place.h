#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "formats/base/json.h"

namespace rhoray::render {

/// Where in a scene document a value stands: the document's name and a JSON pointer (RFC 6901).
struct Place {
  std::string document;
  std::string pointer;  ///< empty: the whole document

  Place at(std::string_view key) const;
  Place at(std::size_t index) const;
  std::string text() const;  ///< torso.json: /layers/0

  /// `torso.json: /image/size: found 7; expected ...` (ErrorCode::invalid).
  [[noreturn]] void refuse(const Json& found, const std::string& expected, const std::string& hint = {}) const;
};

/// A value as messages show it: short, and on one line.
std::string found_text(const Json& value);

}  // namespace rhoray::render

#pragma once

#include <string>

#include "formats/base/json.h"

namespace rhoray::render {

/// JSON of at most 16 levels, in which no object has a key twice and every number is finite.
/// Refuses other texts with line and column, or with the JSON pointer of what is wrong
/// (ErrorCode::invalid).
/// @param name  of the document, for messages
Json read_json(const std::string& text, const std::string& name);

}  // namespace rhoray::render

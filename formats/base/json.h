#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "formats/base/interval.h"
#include "formats/base/vector.h"

namespace rhoray {

/// Objects keep the order of their keys.
using Json = nlohmann::ordered_json;

// Numbers that are not finite become null.
Json json_of(const Vec3& v);
Json json_of(const Interval<double>& interval);  ///< null when empty

/// On one line; bytes that are not UTF-8 are replaced.
std::string dump(const Json& json);

/// The same over several lines for people: one for each member, lists that hold no objects on one
/// line. Ends with a line's end.
std::string dump_lines(const Json& json);

}  // namespace rhoray

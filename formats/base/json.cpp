#include "formats/base/json.h"

#include <algorithm>

namespace rhoray {

namespace {

/// Without objects, and lists only in the innermost place.
bool is_short(const Json& json) {
  return !json.is_structured() || json.empty() ||
         (json.is_array() &&
          std::none_of(json.begin(), json.end(), [](const Json& item) { return item.is_structured(); }));
}

void append_lines(const Json& json, std::size_t indent, std::string& out) {
  if (json.is_array() && !json.empty() && is_short(json)) {
    out += '[';
    for (std::size_t i = 0; i < json.size(); ++i) out += (i == 0 ? "" : ", ") + dump(json[i]);
    out += ']';
    return;
  }
  if (is_short(json)) {
    out += dump(json);
    return;
  }
  const std::string start(indent + 2, ' ');
  out += json.is_object() ? "{\n" : "[\n";
  std::size_t left = json.size();
  for (const auto& [key, value] : json.items()) {
    out += start;
    if (json.is_object()) out += dump(Json(key)) + ": ";
    append_lines(value, indent + 2, out);
    out += --left > 0 ? ",\n" : "\n";
  }
  out += std::string(indent, ' ') + (json.is_object() ? '}' : ']');
}

}  // namespace

Json json_of(const Vec3& v) {
  return {v.x, v.y, v.z};
}

Json json_of(const Interval<double>& interval) {
  if (interval.is_empty()) return nullptr;
  return {interval.lo, interval.hi};
}

std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string dump_lines(const Json& json) {
  std::string out;
  append_lines(json, 0, out);
  return out + "\n";
}

}  // namespace rhoray

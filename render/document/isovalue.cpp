#include "render/isovalue.h"

#include <optional>

#include "formats/base/error.h"
#include "formats/base/read_value.h"
#include "formats/shape_field.h"

namespace rhoray::render {

namespace {

/// "0 to 255 HU of field 'density'".
std::string range_text(const formats::FieldSummary& field) {
  return concat(field.range.lo, " to ", field.range.hi, field.unit.empty() ? "" : " ", field.unit, " of field '",
                field.name, "'");
}

}  // namespace

Isovalue choose_isovalue(const std::string& text, const formats::FieldSummary& field) {
  if (field.range.is_empty()) throw Error(ErrorCode::invalid, concat("field '", field.name, "' holds no finite value"));
  if (text == "auto" && field.name == formats::boundary_distance && field.range.hi > 0)
    return {formats::shape_share_of_distance * field.range.hi, "1/10000 of the largest distance"};
  if (text == "auto") {
    const std::optional<double> threshold = formats::otsu_threshold(field);
    if (!threshold)
      throw Error(ErrorCode::usage,
                  concat("field '", field.name, "' is constant (", field.range.lo, "), so it has no isosurface"));
    return {*threshold, "Otsu's threshold"};
  }
  const bool is_percentile = text.starts_with("p");
  const std::optional<double> number = finite_number(is_percentile ? text.substr(1) : text);
  if (!number)
    throw Error(ErrorCode::usage,
                concat("--iso: found '", text, "'; expected a number, a percentile such as p95, or auto"));
  const double value = *number;
  if (is_percentile) {
    if (!(value >= 0 && value <= 100))
      throw Error(ErrorCode::usage, concat("--iso ", text, ": percentiles run from 0 to 100"));
    return {formats::percentile(field, value / 100), concat("percentile ", value)};
  }
  if (!field.range.contains(value))
    throw Error(ErrorCode::usage, concat("isovalue ", value, " is outside the range ", range_text(field)),
                "auto chooses one from the histogram");
  return {value, "given"};
}

bool is_outside(const std::string& isovalue, const formats::FieldSummary& field) {
  const std::optional<double> value = finite_number(isovalue);
  return value && !field.range.contains(*value);
}

}  // namespace rhoray::render

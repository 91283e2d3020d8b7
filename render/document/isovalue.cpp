#include "render/isovalue.h"

#include <optional>
#include <vector>

#include "formats/automatic_isovalue.h"
#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/read_value.h"
#include "formats/base/word_list.h"
#include "formats/shape_field.h"

namespace rhoray::render {

namespace {

/// "0 to 255 HU of field 'density'".
std::string range_text(const formats::FieldSummary& field) {
  return concat(field.range.lo, " to ", field.range.hi, field.unit.empty() ? "" : " ", field.unit, " of field '",
                field.name, "'");
}

/// "other valleys: 1150, 2100; Otsu's threshold 700"
std::string alternatives_text(const formats::AutomaticIsovalue& chosen) {
  constexpr int digits = 6;
  std::vector<std::string> values;
  for (const double value : chosen.other_valleys) values.push_back(rounded(value, digits));
  std::string text;
  if (!values.empty())
    text = concat(chosen.is_valley ? "other " : "", values.size() == 1 ? "valley: " : "valleys: ", joined(values));
  if (!chosen.is_valley) return text;
  return concat(text, text.empty() ? "" : "; ", "Otsu's threshold ", rounded(chosen.otsu_threshold, digits));
}

/// "to within 40, a bin of the histogram", where one bin has more than 5 % of the values around a
/// percentile; else empty.
std::string coarse_text(const formats::FieldSummary& field, double share) {
  const double error = formats::percentile_error(field);
  const double width = formats::percentile(field, share + 0.025) - formats::percentile(field, share - 0.025);
  return width < error ? concat("to within ", rounded(error, 2), ", a bin of the histogram") : std::string();
}

}  // namespace

Isovalue choose_isovalue(const std::string& text, const formats::FieldSummary& field) {
  if (field.range.is_empty()) throw Error(ErrorCode::invalid, concat("field '", field.name, "' holds no finite value"));
  if (field.histogram.empty() && (text == "auto" || text.starts_with("p")))
    throw Error(ErrorCode::usage, concat("field '", field.name, "' has no histogram to choose an isovalue from"),
                concat("a number in its range: --iso ", field.range.lo / 2 + field.range.hi / 2));
  if (text == "auto" && field.name == formats::boundary_distance && field.range.hi > 0)
    return {formats::shape_share_of_distance * field.range.hi, "1/10000 of the largest distance"};
  if (text == "auto") {
    const std::optional<formats::AutomaticIsovalue> chosen = formats::automatic_isovalue(field);
    if (!chosen)
      throw Error(ErrorCode::usage,
                  concat("field '", field.name, "' is constant (", field.range.lo, "), so it has no isosurface"));
    return {chosen->value, chosen->is_valley ? "strongest gradient among the histogram's valleys" : "Otsu's threshold",
            alternatives_text(*chosen)};
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
    return {formats::percentile(field, value / 100), concat("percentile ", value), coarse_text(field, value / 100)};
  }
  if (!field.range.contains(value))
    throw Error(ErrorCode::usage, concat("isovalue ", value, " is outside the range ", range_text(field)),
                "auto chooses one from the histogram");
  return {value, "given"};
}

std::string isovalue_text(const Isovalue& isovalue, const formats::FieldSummary& field) {
  return concat("isovalue ", isovalue.value, " (", isovalue.from, " of field '", field.name, "')",
                isovalue.alternatives.empty() ? "" : "; ", isovalue.alternatives);
}

bool is_outside(const std::string& isovalue, const formats::FieldSummary& field) {
  const std::optional<double> value = finite_number(isovalue);
  return value && !field.range.contains(*value);
}

}  // namespace rhoray::render

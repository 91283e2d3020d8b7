#pragma once

#include <string>

#include "formats/field_summary.h"

namespace rhoray::render {

/// The isovalue that `text` names, and its origin: "given", "percentile 95", "Otsu's threshold".
/// Refuses a value outside the field's range and percentages outside [0, 100] (ErrorCode::usage).
struct Isovalue {
  double value = 0;
  std::string from;
};
Isovalue choose_isovalue(const std::string& text, const formats::FieldSummary& field);

/// True for a number outside the field's range, which choose_isovalue refuses.
bool is_outside(const std::string& isovalue, const formats::FieldSummary& field);

}  // namespace rhoray::render

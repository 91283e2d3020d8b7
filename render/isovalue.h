#pragma once

#include <string>
#include <string_view>

#include "formats/field_summary.h"

namespace rhoray::render {

/// The isovalue that `text` names, and its origin: "given", "percentile 95", "strongest gradient
/// among the histogram's valleys", "Otsu's threshold". Refuses a value outside the field's range
/// and percentages outside [0, 100] (ErrorCode::usage).
struct Isovalue {
  double value = 0;
  std::string from;
  /// of "auto": "other valleys: 1150, 2100; Otsu's threshold 700"; may be empty
  std::string alternatives{};
};
Isovalue choose_isovalue(const std::string& text, const formats::FieldSummary& field);

/// "isovalue 500 (Otsu's threshold of field 'density'); valley: 1150", for the program to print.
std::string isovalue_text(const Isovalue& isovalue, const formats::FieldSummary& field);

/// Describes the isovalue "auto" in help texts. The valley is one of the histogram.
inline constexpr std::string_view auto_isovalue_words = "valley with the strongest gradient, or Otsu's threshold";

/// True for a number outside the field's range, which choose_isovalue refuses.
bool is_outside(const std::string& isovalue, const formats::FieldSummary& field);

}  // namespace rhoray::render

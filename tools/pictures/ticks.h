#pragma once

#include <string>
#include <vector>

#include "formats/base/interval.h"

namespace rhoray::tools {

/// Replaces hyphens by the typographic minus sign (U+2212).
std::string with_minus_signs(std::string text);

/// A marked position on an axis, and its label.
struct Tick {
  double value;
  std::string text;  ///< with typographic minus signs; empty: a smaller mark, without label
};

/// Returns the multiples of 1, 2 or 5 times a power of ten that lie in the range: as many as
/// possible, but at most `most`. A range without width gives its one value. Labels have as many
/// decimals as the step. They use powers of ten where numbers are above 99999, or the step is below
/// 0.0001.
std::vector<Tick> ticks_of(const Interval<double>& range, int most);

/// The same for a logarithmic axis over a range above 0: powers of ten, or every so many of them. Over
/// less than three decades also 2 and 5 times these; over less than one octave as above. Where there
/// is room, the other multiples stand between them without a label.
std::vector<Tick> log_ticks_of(const Interval<double>& range, int most);

/// Ticks at the borders of bands, which increase; every so many have a label. Labels are within 1/200
/// of a band.
/// @param are_even  all bands have the same width, and labels have as many decimals
std::vector<Tick> border_ticks(const std::vector<double>& borders, bool are_even, int most);

}  // namespace rhoray::tools

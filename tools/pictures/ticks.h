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
/// possible, but at most `most`. A range without width, or whose width is too small or too large
/// for a double, gives its lower value. Labels have as many decimals as the step. They use powers
/// of ten where numbers are above 99999, or the step is below 0.0001.
std::vector<Tick> ticks_of(const Interval<double>& range, int most);

/// Returns the ticks of a logarithmic axis over a range above 0: powers of ten, or every nth of
/// them. Over less than three decades it also returns 2 and 5 times these, and over less than one
/// octave the ticks of a linear axis. Where there is room, ticks without a label mark the other
/// multiples.
std::vector<Tick> log_ticks_of(const Interval<double>& range, int most);

/// Returns a tick for each border of bands; the borders increase. Every nth tick has a label, which
/// differs from the border by at most 1/200 of a band.
/// @param are_even  all bands have the same width, and labels have as many decimals
std::vector<Tick> border_ticks(const std::vector<double>& borders, bool are_even, int most);

}  // namespace rhoray::tools

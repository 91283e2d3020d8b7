#pragma once

#include <string>
#include <vector>

#include "formats/base/interval.h"

namespace rhoray::tools {

/// A marked position on an axis, and its label.
struct Tick {
  double value;
  std::string text;  ///< with the typographic minus sign (U+2212)
};

/// Returns the multiples of 1, 2 or 5 times a power of ten that lie in the range: as many as
/// possible, but at most `most`. A range without width gives its one value. Labels have as many
/// decimals as the step. They use powers of ten where numbers are above 99999, or the step is below
/// 0.0001.
std::vector<Tick> ticks_of(const Interval<double>& range, int most);

}  // namespace rhoray::tools

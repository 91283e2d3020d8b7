#pragma once

#include <string>
#include <vector>

#include "formats/base/interval.h"

namespace rhoray::tools {

/// Numbers at which an axis is marked, and how they are written.
struct Tick {
  double value;
  std::string text;  ///< with a minus sign of its own (U+2212)
};

/// The multiples of 1, 2 or 5 times a power of ten that lie in the range, at most `most` of them and as many as that
/// allows; of a range without width its one value. Written with as many decimals as the step has; in powers of ten
/// where the numbers are above 99999, or the step is below 0.0001.
std::vector<Tick> ticks_of(const Interval<double>& range, int most);

}  // namespace rhoray::tools

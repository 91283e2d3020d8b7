#pragma once

#include <cstdint>
#include <limits>

#include "render/query/batch.h"

namespace rhoray::render {

/// The largest value found so far on a ray through a mesh. Of equal values the nearest counts, and
/// at equal t the one in the cell with the smallest id.
struct LargestSoFar {
  static constexpr double nothing = -std::numeric_limits<double>::infinity();

  double value = nothing;
  double t = std::numeric_limits<double>::infinity();
  std::uint64_t id = 0;

  RHORAY_INLINE void offer(double other, double at, std::uint64_t in) {
    const bool is_better = other > value || (other == value && (at < t || (at == t && in < id)));
    if (is_better) value = other, t = at, id = in;
  }
  Hit hit() const {
    Hit hit;
    if (value == nothing) return hit;
    hit.t = t;
    hit.value = value;
    hit.cell = id;
    return hit;
  }
};

}  // namespace rhoray::render

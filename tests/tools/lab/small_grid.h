#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>

#include "preprocess/neutral.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// 16-bit samples: 1000 at the centre, 100 less for each sample of distance from it.
inline preprocess::NeutralVolume ball_grid(std::int64_t edge) {
  preprocess::NeutralVolume grid;
  grid.sample_count = Index3(edge);
  grid.type = formats::ElementType::U16;
  grid.field_name = "value";
  const double middle = static_cast<double>(edge - 1) / 2;
  for (std::int64_t k = 0; k < edge; ++k)
    for (std::int64_t j = 0; j < edge; ++j)
      for (std::int64_t i = 0; i < edge; ++i) {
        const Vec3 p(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        const auto value = static_cast<std::uint16_t>(std::max(0.0, 1000 - 100 * (p - Vec3(middle)).length()));
        const std::size_t at = grid.owned_samples.size();
        grid.owned_samples.resize(at + sizeof value);
        std::memcpy(grid.owned_samples.data() + at, &value, sizeof value);
      }
  grid.samples = grid.owned_samples;
  return grid;
}

}  // namespace rhoray::tests

#include "preprocess/import/reading/grid_cover.h"

#include <array>
#include <map>

namespace rhoray::preprocess {

Index3 owner_count(const GridExtent& extent, bool in_cells) {
  Index3 count;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t steps = extent.last[axis] - extent.first[axis];
    count[axis] = in_cells ? std::max<std::int64_t>(steps, 1) : steps + 1;
  }
  return count;
}

// The function that is 1 in the cells of a box and 0 elsewhere is a sum of steps at its corners, of
// height 1 or -1. So the parts cover the whole once if the sum of their steps has the steps of the
// whole.
bool cover_once(const GridExtent& whole, std::span<const GridExtent> parts) {
  std::map<std::array<std::int64_t, 3>, std::int64_t> steps;
  const auto add = [&](const GridExtent& extent, std::int64_t height) {
    const Index3 size = owner_count(extent, true);
    for (unsigned corner = 0; corner < 8; ++corner) {
      std::array<std::int64_t, 3> at{};
      std::int64_t sign = height;
      for (int axis = 0; axis < 3; ++axis) {
        const bool is_end = (corner >> axis & 1) != 0;
        at[static_cast<std::size_t>(axis)] = extent.first[axis] + (is_end ? size[axis] : 0);
        if (is_end) sign = -sign;
      }
      steps[at] += sign;
    }
  };
  add(whole, 1);
  for (const GridExtent& part : parts) {
    for (int axis = 0; axis < 3; ++axis)
      if (part.first[axis] < whole.first[axis] || part.last[axis] > whole.last[axis]) return false;
    add(part, -1);
  }
  return std::all_of(steps.begin(), steps.end(), [](const auto& step) { return step.second == 0; });
}

}  // namespace rhoray::preprocess

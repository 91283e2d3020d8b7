#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::render {

/// The boxes of up to sixteen nodes or items of the level below, side by side; unused ones are
/// empty boxes.
struct alignas(64) BoxNode {
  static constexpr std::uint32_t size = 16;
  static constexpr float nowhere = 1e30f;  ///< an empty box begins here and ends at the opposite
  float low[3][size], high[3][size];

  static BoxNode of_empty_boxes();
};

/// Levels of a tree of boxes, lowest first: child c of node n of a level is node 16 n + c of the
/// level below. The last level has one node, or none where there are no boxes.
using BoxLevels = std::vector<std::vector<BoxNode>>;

/// Adds the levels above the first.
void add_upper_levels(BoxLevels& levels);

/// A tree of boxes that together contain every point where a query of a volume can have a hit.
///
/// A box (low, high) of the tree stands for the points anchor + unit * p in the data's frame,
/// with p from low - margin to high + margin. The margin covers how far outside an item's box a
/// kernel may still see it, in addition to the rounding of rays.
struct SurfaceBoxes {
  static constexpr int largest_level_count = 8;

  std::shared_ptr<const void> owner;  ///< owns the nodes
  std::array<const BoxNode*, largest_level_count> levels{};
  int level_count = 0;  ///< 0: no boxes
  Vec3 anchor{0, 0, 0};
  double unit = 1;
  double margin = 0;
};

/// The tree with these levels; `owner` owns them.
SurfaceBoxes boxes_of(std::shared_ptr<const void> owner, const BoxLevels& levels);

/// A single box. Its margin is a thousandth of its longest edge, which must be finite and above 0.
SurfaceBoxes box_around(const Box3& box);

}  // namespace rhoray::render

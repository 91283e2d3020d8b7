#include "render/traverse/surface_boxes.h"

#include <algorithm>

#include "formats/base/checks.h"

namespace rhoray::render {

BoxNode BoxNode::of_empty_boxes() {
  BoxNode node;
  std::fill_n(&node.low[0][0], 3 * size, nowhere);
  std::fill_n(&node.high[0][0], 3 * size, -nowhere);
  return node;
}

void add_upper_levels(BoxLevels& levels) {
  while (levels.back().size() > 1) {
    const std::vector<BoxNode>& below = levels.back();
    std::vector<BoxNode> nodes((below.size() + BoxNode::size - 1) / BoxNode::size, BoxNode::of_empty_boxes());
    for (std::size_t n = 0; n < below.size(); ++n)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float *low = below[n].low[axis], *high = below[n].high[axis];
        nodes[n / BoxNode::size].low[axis][n % BoxNode::size] = *std::min_element(low, low + BoxNode::size);
        nodes[n / BoxNode::size].high[axis][n % BoxNode::size] = *std::max_element(high, high + BoxNode::size);
      }
    levels.push_back(std::move(nodes));
  }
}

SurfaceBoxes boxes_of(std::shared_ptr<const void> owner, const BoxLevels& levels) {
  RHORAY_CHECK(levels.size() <= SurfaceBoxes::largest_level_count);
  SurfaceBoxes boxes{.owner = std::move(owner)};
  if (levels.empty() || levels.back().empty()) return boxes;
  boxes.level_count = static_cast<int>(levels.size());
  for (std::size_t l = 0; l < levels.size(); ++l) boxes.levels[l] = levels[l].data();
  return boxes;
}

SurfaceBoxes box_around(const Box3& box) {
  auto levels = std::make_shared<BoxLevels>();
  const Vec3 size = box.size();
  const double longest = std::max({size.x, size.y, size.z});
  BoxNode& node = levels->emplace_back(1, BoxNode::of_empty_boxes()).front();
  for (int axis = 0; axis < 3; ++axis) {
    node.high[axis][0] = static_cast<float>(0.5 * size[axis] / longest);
    node.low[axis][0] = -node.high[axis][0];
  }
  SurfaceBoxes boxes = boxes_of(levels, *levels);
  boxes.anchor = box.center();
  boxes.unit = longest;
  boxes.margin = 1e-3;
  return boxes;
}

}  // namespace rhoray::render

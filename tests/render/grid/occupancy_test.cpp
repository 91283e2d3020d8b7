#include "render/grid/occupancy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stop_token>
#include <vector>

#include "tests/render/support/rays.h"
#include "tests/support/expect_error.h"

namespace rhoray::tests {
namespace {

using render::BoxNode;
using render::Occupancy;

/// Ranges of a grid's blocks. One in every so many blocks has values on both sides of 0, and so
/// have all its ancestors.
struct MadeLevels {
  std::vector<std::vector<float>> ranges;
  formats::MacroLevelsView<float> view;

  MadeLevels(const Index3& cells, std::int64_t one_of) {
    Dice dice(7);
    view.shape = {.leaf_count = cells, .factor = 4, .level_count = 3};
    for (int level = 1; level <= 3; ++level) {
      const Index3 count = view.shape.count(level);
      std::vector<float>& of_level = ranges.emplace_back();
      for (std::int64_t i = 0; i < count.x * count.y * count.z; ++i) {
        of_level.push_back(level > 1 || dice.below(one_of) == 0 ? -1.0F : 1.0F);
        of_level.push_back(1);
      }
    }
    for (const auto& of_level : ranges) view.ranges.emplace_back(of_level);
  }
};

/// Returns the boxes of the lowest level; checks that each level contains the one below.
std::vector<Box3> boxes_in(const Occupancy& occupancy) {
  std::vector<Box3> lowest, below;
  for (const auto& level : occupancy.boxes()) {
    std::vector<Box3> boxes;
    for (const BoxNode& node : level)
      for (std::size_t i = 0; i < BoxNode::size; ++i)
        boxes.push_back(node.low[0][i] > node.high[0][i] ? Box3()
                                                         : Box3({node.low[0][i], node.low[1][i], node.low[2][i]},
                                                                {node.high[0][i], node.high[1][i], node.high[2][i]}));
    for (std::size_t b = 0; b < below.size(); ++b)
      if (!below[b].isEmpty()) {
        EXPECT_TRUE(boxes[b / BoxNode::size].intersects(below[b].min) &&
                    boxes[b / BoxNode::size].intersects(below[b].max));
      }
    if (lowest.empty()) lowest = boxes;
    below = boxes;
  }
  std::erase_if(lowest, [](const Box3& box) { return box.isEmpty(); });
  return lowest;
}

TEST(Occupancy, has_boxes_around_all_its_blocks_of_an_edge_that_keeps_them_few) {
  struct Case {
    Index3 cells;
    std::int64_t one_of;
    double edge;
  };
  for (const Case& made : {Case{{61, 40, 83}, 5, 4}, Case{{130, 129, 127}, 1, 16}, Case{{448, 448, 448}, 3, 64}}) {
    const MadeLevels levels(made.cells, made.one_of);
    const Occupancy occupancy(levels.view, 0);
    const std::vector<Box3> boxes = boxes_in(occupancy);
    EXPECT_LE(boxes.size(), std::size_t{1} << 14);
    // Count the boxes that contain each block; each block must be in one.
    const Index3 count = levels.view.shape.count(1);
    std::vector<char> held(static_cast<std::size_t>(count.x * count.y * count.z));
    const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      return static_cast<std::size_t>((k * count.y + j) * count.x + i);
    };
    double longest = 0;
    for (const Box3& box : boxes) {
      for (int a = 0; a < 3; ++a) {
        longest = std::max(longest, box.size()[a]);
        ASSERT_LE(box.max[a], static_cast<double>(made.cells[a]));
      }
      for (auto k = static_cast<std::int64_t>(box.min.z) / 4; 4.0 * static_cast<double>(k) < box.max.z; ++k)
        for (auto j = static_cast<std::int64_t>(box.min.y) / 4; 4.0 * static_cast<double>(j) < box.max.y; ++j)
          for (auto i = static_cast<std::int64_t>(box.min.x) / 4; 4.0 * static_cast<double>(i) < box.max.x; ++i)
            held[at(i, j, k)] = 1;
    }
    EXPECT_EQ(longest, made.edge);
    int lost = 0, empty = 0;
    for (std::int64_t k = 0; k < count.z; ++k)
      for (std::int64_t j = 0; j < count.y; ++j)
        for (std::int64_t i = 0; i < count.x; ++i) {
          const bool straddles = levels.view.range(1, i, j, k).lo < 0;
          lost += straddles && !held[at(i, j, k)];
          empty += !straddles && held[at(i, j, k)];
        }
    EXPECT_EQ(lost, 0);
    EXPECT_TRUE(made.edge > 4 || empty == 0);
  }
}

TEST(Occupancy, has_no_boxes_where_there_is_no_surface) {
  const MadeLevels levels({61, 40, 83}, 5);
  for (const double isovalue : {-2.0, 2.0}) EXPECT_TRUE(boxes_in(Occupancy(levels.view, isovalue)).empty());
}

TEST(Occupancy, is_not_kept_if_its_search_was_stopped) {
  std::stop_source stop;
  stop.request_stop();
  const MadeLevels levels({130, 129, 127}, 5);
  render::OccupancyCache cache;
  for (int time = 0; time < 2; ++time)
    expect_error(ErrorCode::interrupted, "interrupted", [&] { cache.of(levels.view, 0, stop.get_token()); });
  const auto kept = cache.of(levels.view, 0);
  EXPECT_EQ(boxes_in(*kept), boxes_in(Occupancy(levels.view, 0)));
  EXPECT_EQ(cache.of(levels.view, 0, stop.get_token()), kept);
}

}  // namespace
}  // namespace rhoray::tests

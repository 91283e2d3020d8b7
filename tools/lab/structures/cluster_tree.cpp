#include "tools/lab/structures/cluster_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rhoray::study {
namespace {

using formats::BoxBlock;
using formats::RangeBlock;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr std::size_t width = formats::ClusterShape::width;

template <class Block>
void fill_empty(Block& block) {
  if constexpr (requires { block.lo[0][0]; }) {
    for (std::size_t axis = 0; axis < 3; ++axis) block.lo[axis].fill(infinity), block.hi[axis].fill(-infinity);
  } else {
    block.lo.fill(infinity), block.hi.fill(-infinity);
  }
}

/// The given number of blocks of a level, with entries that no ray meets.
template <class Block>
std::vector<Block> empty_level(std::uint64_t block_count) {
  std::vector<Block> level(block_count);
  for (Block& block : level) fill_empty(block);
  return level;
}

float rounded_down(double x) {
  const float nearest = static_cast<float>(x);
  return static_cast<double>(nearest) <= x ? nearest : std::nextafter(nearest, -infinity);
}

void take_in(BoxBlock& block, std::size_t entry, std::size_t axis, float lo, float hi) {
  block.lo[axis][entry] = std::min(block.lo[axis][entry], lo);
  block.hi[axis][entry] = std::max(block.hi[axis][entry], hi);
}

void take_in(RangeBlock<float>& block, std::size_t entry, float lo, float hi) {
  block.lo[entry] = std::min(block.lo[entry], lo);
  block.hi[entry] = std::max(block.hi[entry], hi);
}

}  // namespace

ClusterTree::ClusterTree(const PlainMesh& mesh, std::uint64_t cluster_size) {
  view_.shape = {.cell_count = mesh.cell_count(), .cluster_size = cluster_size};
  for (int level = 0; level <= view_.shape.top_level(); ++level) {
    boxes_.push_back(empty_level<BoxBlock>(view_.shape.block_count(level)));
    ranges_.push_back(empty_level<RangeBlock<float>>(view_.shape.block_count(level)));
  }
  for (std::uint32_t cell = 0; cell < mesh.cell_count(); ++cell) {
    const std::uint64_t cluster = cell / cluster_size;
    const Box3 box = mesh.box(cell);
    for (int axis = 0; axis < 3; ++axis)
      take_in(boxes_[0][cluster / width], cluster % width, static_cast<std::size_t>(axis), rounded_down(box.min[axis]),
              -rounded_down(-box.max[axis]));
    const Interval<float> range = mesh.range(cell);
    take_in(ranges_[0][cluster / width], cluster % width, range.lo, range.hi);
  }
  for (std::size_t level = 1; level < boxes_.size(); ++level)
    for (std::size_t entry = 0; entry < boxes_[level - 1].size(); ++entry)
      for (std::size_t e = 0; e < width; ++e) {
        const BoxBlock& box = boxes_[level - 1][entry];
        for (std::size_t axis = 0; axis < 3; ++axis)
          take_in(boxes_[level][entry / width], entry % width, axis, box.lo[axis][e], box.hi[axis][e]);
        const RangeBlock<float>& range = ranges_[level - 1][entry];
        take_in(ranges_[level][entry / width], entry % width, range.lo[e], range.hi[e]);
      }
  view_.boxes.assign(boxes_.begin(), boxes_.end());
  range_views_.assign(ranges_.begin(), ranges_.end());
}

std::uint64_t ClusterTree::bytes() const {
  std::uint64_t bytes = 0;
  for (std::size_t level = 0; level < boxes_.size(); ++level)
    bytes += boxes_[level].size() * sizeof(BoxBlock) + ranges_[level].size() * sizeof(RangeBlock<float>);
  return bytes;
}

}  // namespace rhoray::study

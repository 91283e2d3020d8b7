#include "render/grid/leaf_bricks.h"

#include <algorithm>
#include <limits>

#include "formats/base/parallel.h"

namespace rhoray::render {

namespace {

constexpr std::int64_t voxels_of_leaf = LeafBricks::edge * LeafBricks::edge * LeafBricks::edge;
constexpr int shift = 9;
static_assert(voxels_of_leaf == 1 << shift);

nanovdb::Coord coord(const Index3& voxel) {
  return {static_cast<std::int32_t>(voxel.x), static_cast<std::int32_t>(voxel.y), static_cast<std::int32_t>(voxel.z)};
}

}  // namespace

LeafBricks::LeafBricks(const nanovdb::NanoTree<float>& tree, const Index3& first_voxel, const Index3& voxel_count) {
  for (int axis = 0; axis < 3; ++axis) {
    low_[axis] = leaf_start(first_voxel[axis]);
    count_[axis] = (leaf_start(first_voxel[axis] + voxel_count[axis] - 1) - low_[axis]) / edge + 1;
  }
  find_addresses(first_voxel, voxel_count);
  find_slots(tree);
}

void LeafBricks::find_addresses(const Index3& first_voxel, const Index3& voxel_count) {
  const Index3 brick_step(1, count_.x, count_.x * count_.y);
  const Index3 step(edge * edge, edge, 1);  // z varies fastest in a leaf node
  for (int axis = 0; axis < 3; ++axis)
    for (std::int64_t i = 0; i < voxel_count[axis]; ++i) {
      const std::int64_t at = first_voxel[axis] + i - low_[axis];
      address_[static_cast<std::size_t>(axis)].push_back(
          static_cast<std::uint64_t>(at / edge * brick_step[axis] * voxels_of_leaf + at % edge * step[axis]));
    }
}

void LeafBricks::find_slots(const nanovdb::NanoTree<float>& tree) {
  struct Brick {
    const Leaf* leaf;
    float value;
  };
  std::vector<Brick> bricks(static_cast<std::size_t>(volume(count_)));
  for_each_range(bricks.size(), 1024, 0, [&](std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t b = first; b < last; ++b) {
      const auto number = static_cast<std::int64_t>(b);
      const Index3 place(number % count_.x, number / count_.x % count_.y, number / count_.x / count_.y);
      const nanovdb::Coord at = coord(low_ + place * edge);
      bricks[b].leaf = tree.root().probeLeaf(at);
      if (bricks[b].leaf == nullptr) bricks[b].value = tree.root().getValue(at);
    }
  });

  const auto place_of = [](const Leaf* leaf) { return reinterpret_cast<std::uintptr_t>(leaf); };
  for (const Brick& brick : bricks)
    if (brick.leaf != nullptr && (first_leaf_ == nullptr || place_of(brick.leaf) < place_of(first_leaf_)))
      first_leaf_ = brick.leaf;
  const auto distance = [&](const Leaf* leaf) { return place_of(leaf) - place_of(first_leaf_); };
  for (const Brick& brick : bricks) {
    if (brick.leaf == nullptr) continue;
    const std::uintptr_t number = distance(brick.leaf) / sizeof(Leaf);
    if (distance(brick.leaf) % sizeof(Leaf) != 0 || number >= std::numeric_limits<std::uint32_t>::max() / 2) return;
    leaf_count_ = std::max(leaf_count_, static_cast<std::uint32_t>(number) + 1);
  }
  slots_.reserve(bricks.size());
  for (const Brick& brick : bricks) {
    if (brick.leaf != nullptr) {
      slots_.push_back(static_cast<std::uint32_t>(distance(brick.leaf) / sizeof(Leaf)));
      continue;
    }
    // Consecutive bricks without a leaf share a value; most have the background's.
    if (values_.empty() || values_.back() != brick.value) values_.push_back(brick.value);
    slots_.push_back(leaf_count_ + static_cast<std::uint32_t>(values_.size()) - 1);
  }
  if (values_.empty()) values_.push_back(0);
}

std::optional<SampleSource> LeafBricks::source() const {
  static_assert(sizeof(Leaf) % sizeof(float) == 0);
  if (slots_.empty()) return std::nullopt;
  const auto count = [&](std::size_t axis) { return static_cast<std::int64_t>(address_[axis].size()); };
  return SampleSource(formats::ElementType::F32, first_leaf_ == nullptr ? nullptr : first_leaf_->data()->mValues,
                      {address_[0].data(), address_[1].data(), address_[2].data()},
                      {.slots = slots_.data(),
                       .shift = shift,
                       .stride = sizeof(Leaf) / sizeof(float),
                       .stored_count = leaf_count_,
                       .last_value = static_cast<std::uint32_t>(values_.size() - 1),
                       .values = values_.data()},
                      {count(0), count(1), count(2)});
}

}  // namespace rhoray::render

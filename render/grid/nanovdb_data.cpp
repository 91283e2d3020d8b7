#include "render/grid/nanovdb_data.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/format_error.h"
#include "render/grid/leaf_bricks.h"

namespace rhoray::render {

namespace {

/// Checks that every node that the tree points to lies inside the buffer, so that looking up a
/// voxel stays in it.
class NodeCheck {
 public:
  explicit NodeCheck(const formats::VdbGrid& grid) : file_(grid.file()), buffer_(grid.buffer()) {}

  const nanovdb::NanoTree<float>& checked_tree() const {
    const auto& grid = *at<nanovdb::NanoGrid<float>>(buffer_.data());
    if (!grid.isValid() || grid.gridType() != nanovdb::GridType::Float || grid.gridSize() != buffer_.size())
      refuse("another kind of buffer");
    const auto& tree = *at<nanovdb::NanoTree<float>>(&grid.tree());
    const auto& root =
        *at<nanovdb::NanoRoot<float>>(tree.data(), static_cast<std::int64_t>(tree.data()->mNodeOffset[3]));
    const auto* data = root.data();
    for (std::uint32_t n = 0; n < data->mTableSize; ++n) {
      const auto* tile = at<std::decay_t<decltype(*data->tile(n))>>(data->tile(n));
      if (tile->isChild()) check_upper(*at<nanovdb::NanoUpper<float>>(data, tile->child));
    }
    return tree;
  }

 private:
  void check_upper(const nanovdb::NanoUpper<float>& upper) const {
    for (auto child = upper.data()->mChildMask.beginOn(); child; ++child) {
      const auto& lower = *at<nanovdb::NanoLower<float>>(upper.data(), upper.data()->mTable[*child].child);
      for (auto grandchild = lower.data()->mChildMask.beginOn(); grandchild; ++grandchild)
        at<nanovdb::NanoLeaf<float>>(lower.data(), lower.data()->mTable[*grandchild].child);
    }
  }

  /// The node at this byte offset from an address. Computed with integers, so that no pointer or
  /// reference to anything outside the buffer exists.
  template <class Node>
  const Node* at(const void* place, std::int64_t offset = 0) const {
    const auto begin = reinterpret_cast<std::uintptr_t>(buffer_.data()),
               found = reinterpret_cast<std::uintptr_t>(place) + static_cast<std::uintptr_t>(offset);
    if (buffer_.size() < sizeof(Node) || found < begin || found - begin > buffer_.size() - sizeof(Node) ||
        found % alignof(Node) != 0)
      refuse("a node that lies outside");
    return reinterpret_cast<const Node*>(found);
  }

  [[noreturn]] void refuse(const char* found) const {
    formats::refuse(file_.name(), concat("array '", formats::VdbGrid::buffer_array, "'"), found,
                    "a NanoVDB grid of floats");
  }

  const formats::PackedFile& file_;
  std::span<const std::byte> buffer_;
};

constexpr std::int64_t leaf_edge = LeafBricks::edge;

/// Macrocells of the lowest level have 4^3 cells, as SIMD kernels need them. They have more where a
/// sparse grid spans so much space that this many macrocells would not fit into memory.
formats::MacroShape choose_shape(const Index3& sample_count, const formats::PackedFile& file) {
  constexpr std::int64_t most_macrocells = std::int64_t{1} << 24;
  formats::MacroShape shape{.leaf_count = sample_count - Index3(1, 1, 1), .factor = 4, .level_count = 1};
  // Each count is at most 2^30 / 4, so the product of three is first computed in double precision.
  const auto too_many = [&] {
    const Index3 count = shape.count(1);
    return static_cast<double>(count.x) * static_cast<double>(count.y) * static_cast<double>(count.z) >
           static_cast<double>(most_macrocells);
  };
  constexpr std::int64_t largest_factor = 32;
  while (shape.factor < largest_factor && too_many()) shape.factor *= 2;
  if (too_many())
    throw Error(ErrorCode::resource,
                concat(file.name(), ": the active voxels span ", sample_count.x, " x ", sample_count.y, " x ",
                       sample_count.z, " samples; expected a box of at most 2^24 macrocells of 32^3 samples"),
                "remove voxels that lie far from the others");
  const auto is_large = [&](const Index3& count) { return std::max({count.x, count.y, count.z}) > shape.factor; };
  while (is_large(shape.count(shape.level_count))) ++shape.level_count;
  return shape;
}

void put(std::vector<float>& ranges, const Index3& size, const Index3& cell, const Interval<float>& range) {
  const auto at = static_cast<std::size_t>(2 * ((cell.z * size.y + cell.y) * size.x + cell.x));
  ranges[at] = range.lo;
  ranges[at + 1] = range.hi;
}

template <class Act>
void for_each_index(const Index3& first, const Index3& end, Act&& act) {
  Index3 c;
  for (c.z = first.z; c.z < end.z; ++c.z)
    for (c.y = first.y; c.y < end.y; ++c.y)
      for (c.x = first.x; c.x < end.x; ++c.x) act(c);
}

Index3 smaller(const Index3& a, const Index3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}

/// The tree, the ranges of its macrocells, and its leaf nodes as bricks.
class NanoVdb {
 public:
  explicit NanoVdb(const formats::VdbGrid& grid);

  TrilinearCell cell(const Index3& c) const {
    constexpr std::int32_t last = Leaf::DIM - 1;
    const nanovdb::Coord low = voxel(c);
    TrilinearCell out;
    // For seven eighths of the cells on each axis, all corners lie in one leaf node, found once.
    if ((low[0] & last) != last && (low[1] & last) != last && (low[2] & last) != last)
      if (const Leaf* leaf = tree_->root().probeLeaf(low)) {
        const float* values = leaf->data()->mValues + Leaf::CoordToOffset(low);
        for (std::size_t corner = 0; corner < 8; ++corner)
          out.corner[corner] =
              static_cast<double>(values[(corner & 1) * x_stride + (corner >> 1 & 1) * y_stride + (corner >> 2)]);
        return out;
      }
    const nanovdb::DefaultReadAccessor<float> accessor(tree_->root());
    for (std::size_t corner = 0; corner < 8; ++corner)
      out.corner[corner] = static_cast<double>(accessor.getValue(
          low.offsetBy(static_cast<std::int32_t>(corner & 1), static_cast<std::int32_t>(corner >> 1 & 1),
                       static_cast<std::int32_t>(corner >> 2))));
    return out;
  }

  const formats::MacroLevelsView<float>& levels() const { return levels_; }
  const Interval<float>& values() const { return values_; }
  bool has_gaps() const { return has_gaps_; }
  std::optional<SampleSource> source() const { return bricks_ ? bricks_->source() : std::nullopt; }

 private:
  using Leaf = nanovdb::NanoLeaf<float>;
  // z varies fastest in a leaf.
  static constexpr std::size_t x_stride = Leaf::DIM * Leaf::DIM, y_stride = Leaf::DIM;

  nanovdb::Coord voxel(const Index3& sample) const {
    return {static_cast<std::int32_t>(first_sample_.x + sample.x),
            static_cast<std::int32_t>(first_sample_.y + sample.y),
            static_cast<std::int32_t>(first_sample_.z + sample.z)};
  }
  Interval<float> sample_range(const Index3& first, const Index3& last, std::atomic<bool>& has_gaps) const;
  Interval<float> cell_range(const Index3& first, const Index3& last) const;
  void build_lowest_level();

  formats::VdbGrid grid_;  ///< keeps the buffer alive
  const nanovdb::NanoTree<float>* tree_;
  Index3 first_sample_;
  std::vector<std::vector<float>> ranges_;  ///< [level - 1]: in the layout of MacroLevelsView
  formats::MacroLevelsView<float> levels_;
  Interval<float> values_;
  bool has_gaps_ = false;
  std::optional<LeafBricks> bricks_;  ///< nothing where macrocells of the lowest level are larger
};

NanoVdb::NanoVdb(const formats::VdbGrid& grid)
    : grid_(grid), tree_(&NodeCheck(grid_).checked_tree()), first_sample_(grid.description().first_sample) {
  const formats::MacroShape shape = choose_shape(grid.description().sample_count, grid.file());
  const Index3& cells = shape.leaf_count;
  // Limit for tables with an entry for each sample on an axis.
  constexpr std::int64_t longest = 1 << 16;
  if (shape.factor < leaf_edge && std::max({cells.x, cells.y, cells.z}) < longest)
    bricks_.emplace(*tree_, first_sample_, grid.description().sample_count);
  for (int level = 1; level <= shape.level_count; ++level)
    ranges_.emplace_back(static_cast<std::size_t>(2 * volume(shape.count(level))));
  levels_ = {.shape = shape, .first_level = 1, .ranges = {ranges_.begin(), ranges_.end()}};
  build_lowest_level();
  for (int level = 2; level <= shape.level_count; ++level)
    for_each_index({0, 0, 0}, shape.count(level), [&](const Index3& c) {
      Interval<float> range;
      const Index3 end = smaller((c + Index3(1, 1, 1)) * shape.factor, shape.count(level - 1));
      for_each_index(c * shape.factor, end,
                     [&](const Index3& child) { range.include(levels_.range(level - 1, child.x, child.y, child.z)); });
      put(ranges_[static_cast<std::size_t>(level - 1)], shape.count(level), c, range);
    });
  for_each_index({0, 0, 0}, shape.count(shape.level_count),
                 [&](const Index3& c) { values_.include(levels_.range(shape.level_count, c.x, c.y, c.z)); });
}

void NanoVdb::build_lowest_level() {
  const formats::MacroShape& shape = levels_.shape;
  const Index3 count = shape.count(1);
  std::atomic<bool> has_gaps = false;
  for_each_range(static_cast<std::uint64_t>(count.z), 1, 0, [&](std::uint64_t first, std::uint64_t last) {
    const Index3 low(0, 0, static_cast<std::int64_t>(first)), high(count.x, count.y, static_cast<std::int64_t>(last));
    for_each_index(low, high, [&](const Index3& c) {
      const Index3 from = c * shape.factor;
      const Index3 to = smaller(from + Index3(1, 1, 1) * shape.factor, shape.leaf_count);
      put(ranges_.front(), count, c, sample_range(from, to, has_gaps));
    });
  });
  has_gaps_ = has_gaps;
}

/// The range of the samples from first to last. A leaf-sized block of voxels without a leaf node
/// has one value.
Interval<float> NanoVdb::sample_range(const Index3& first, const Index3& last,
                                      std::atomic<bool>& has_gaps_anywhere) const {
  Interval<float> range;
  bool has_gaps = false;
  const auto include = [&](float value) {
    has_gaps = has_gaps || !std::isfinite(value);
    range.include(value);
  };
  const Index3 low = first_sample_ + first, high = first_sample_ + last;
  Index3 block;
  for (block.z = leaf_start(low.z); block.z <= high.z; block.z += leaf_edge)
    for (block.y = leaf_start(low.y); block.y <= high.y; block.y += leaf_edge)
      for (block.x = leaf_start(low.x); block.x <= high.x; block.x += leaf_edge) {
        const nanovdb::Coord at(static_cast<std::int32_t>(block.x), static_cast<std::int32_t>(block.y),
                                static_cast<std::int32_t>(block.z));
        const Leaf* leaf = tree_->root().probeLeaf(at);
        if (leaf == nullptr) {
          include(tree_->root().getValue(at));
          continue;
        }
        const Index3 edge(leaf_edge, leaf_edge, leaf_edge);
        const Index3 from(std::max(low.x, block.x), std::max(low.y, block.y), std::max(low.z, block.z));
        for_each_index(from, smaller(high + Index3(1, 1, 1), block + edge), [&](const Index3& v) {
          const Index3 in = v - block;
          include(leaf->data()->mValues[static_cast<std::size_t>(in.x) * x_stride +
                                        static_cast<std::size_t>(in.y) * y_stride + static_cast<std::size_t>(in.z)]);
        });
      }
  if (!has_gaps) return range;
  has_gaps_anywhere = true;
  return cell_range(first, last);
}

/// The range of those cells between the samples from first to last that have data.
Interval<float> NanoVdb::cell_range(const Index3& first, const Index3& last) const {
  Interval<float> range;
  for_each_index(first, last, [&](const Index3& c) {
    const TrilinearCell corners = cell(c);
    if (!corners.has_data()) return;
    range.include(static_cast<float>(corners.smallest()));
    range.include(static_cast<float>(corners.largest()));
  });
  return range;
}

}  // namespace

UniformGrid nanovdb_data(const formats::VdbGrid& grid) {
  const auto memory = std::make_shared<const NanoVdb>(grid);
  const Interval<float>& values = memory->values();
  GridData::Parts parts{
      .ranges = memory->levels(),
      .fetch_cell = [](const GridData& data,
                       const Index3& cell) { return static_cast<const NanoVdb*>(data.memory())->cell(cell); },
      .source = memory->source(),
      .values = {static_cast<double>(values.lo), static_cast<double>(values.hi)},
      .has_gaps = memory->has_gaps(),
      .memory = memory,
      .packed = std::nullopt};
  if (parts.source) parts.source->has_gaps = parts.has_gaps;
  return UniformGrid(std::move(parts));
}

}  // namespace rhoray::render

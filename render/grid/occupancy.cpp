#include "render/grid/occupancy.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "formats/base/stopping.h"

namespace rhoray::render {

namespace {

/// The smallest number of type T that is not below the isovalue; nothing when all are below it.
/// Then lo < isovalue <= hi is equivalent to lo < threshold <= hi.
template <class T>
std::optional<T> threshold_in(double isovalue) {
  if constexpr (std::is_integral_v<T>) {
    const double least = std::ceil(isovalue);
    if (!(least <= static_cast<double>(std::numeric_limits<T>::max()))) return std::nullopt;
    return least <= static_cast<double>(std::numeric_limits<T>::lowest()) ? std::numeric_limits<T>::lowest()
                                                                          : static_cast<T>(least);
  } else {
    if (std::isnan(isovalue)) return std::nullopt;
    T least = static_cast<T>(isovalue);
    if (static_cast<double>(least) < isovalue) least = std::nextafter(least, std::numeric_limits<T>::infinity());
    return least;
  }
}

/// One level of ranges with a test which of them contain both sides.
template <class T>
struct Straddling {
  const T* ranges;
  Index3 count;
  T threshold;

  bool operator()(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const T* range = ranges + 2 * ((k * count.y + j) * count.x + i);
    return range[0] < threshold && threshold <= range[1];
  }

  /// The bits of those children (4i.., 4j.., 4k..) that exist.
  std::uint64_t children(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const std::int64_t x_end = std::min<std::int64_t>(4, count.x - 4 * i),
                       y_end = std::min<std::int64_t>(4, count.y - 4 * j),
                       z_end = std::min<std::int64_t>(4, count.z - 4 * k);
    std::uint64_t bits = 0;
    for (std::int64_t z = 0; z < z_end; ++z)
      for (std::int64_t y = 0; y < y_end; ++y) {
        const T* row = ranges + 2 * (((4 * k + z) * count.y + 4 * j + y) * count.x + 4 * i);
        std::uint64_t row_bits = 0;
        if (x_end == 4) {
          for (unsigned x = 0; x < 4; ++x)
            row_bits |= static_cast<std::uint64_t>((row[2 * x] < threshold) & (threshold <= row[2 * x + 1])) << x;
        } else {
          for (unsigned x = 0; x < x_end; ++x)
            row_bits |= static_cast<std::uint64_t>((row[2 * x] < threshold) & (threshold <= row[2 * x + 1])) << x;
        }
        bits |= row_bits << (4 * y + 16 * z);
      }
    return bits;
  }
};

constexpr std::size_t most_boxes = std::size_t{1} << 14;

/// The size of the regions whose blocks a box encloses.
enum class BoxEdge { block, node, super_node };

/// Boxes in cells, cut off where the cells end.
struct BoxList {
  Index3 leaf_count;
  std::vector<BoxNode> nodes;
  std::size_t count;

  /// Adds a box around those of 4 x 4 x 4 children that have a bit.
  /// @param first  index of the first child
  /// @param edge   of a child, in cells
  void add(const Index3& first, std::uint64_t bits, std::int64_t edge) {
    if (count % BoxNode::size == 0) nodes.push_back(BoxNode::of_empty_boxes());
    BoxNode& node = nodes.back();
    const std::size_t place = count++ % BoxNode::size;
    for (int axis = 0; axis < 3; ++axis) {
      const unsigned along = bits_along(bits, axis);
      const std::int64_t low = (first[axis] + std::countr_zero(along)) * edge,
                         high = (first[axis] + std::bit_width(along)) * edge;
      node.low[axis][place] = static_cast<float>(low);
      node.high[axis][place] = static_cast<float>(std::min(high, leaf_count[axis]));
    }
  }

 private:
  /// The coordinates 0 to 3 on an axis at which there are bits.
  static unsigned bits_along(std::uint64_t bits, int axis) {
    constexpr std::uint64_t plane[3] = {0x1111'1111'1111'1111, 0x000f'000f'000f'000f, 0x0000'0000'0000'ffff};
    unsigned along = 0;
    for (int i = 0; i < 4; ++i) along |= static_cast<unsigned>((bits & plane[axis] << (i << (2 * axis))) != 0) << i;
    return along;
  }
};

}  // namespace

Occupancy::Occupancy(const formats::MacroRanges& ranges, double isovalue, const std::stop_token& stop) {
  const Index3& blocks = ranges.level(1).count;
  std::array<int, 3> super_node_count;
  for (int a = 0; a < 3; ++a) {
    super_node_count[static_cast<std::size_t>(a)] = static_cast<int>((blocks[a] + 15) / 16);
    node_count_[static_cast<std::size_t>(a)] = 4 * super_node_count[static_cast<std::size_t>(a)];
  }
  const auto volume = [](const std::array<int, 3>& count) {
    return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) * static_cast<std::size_t>(count[2]);
  };
  nodes_.assign(volume(node_count_), 0);
  super_nodes_.assign(volume(super_node_count), 0);
  formats::with_exact_type(ranges.type(), [&]<class T>(T) { find_nodes<T>(ranges, isovalue, stop); });
}

template <class T>
void Occupancy::find_nodes(const formats::MacroRanges& ranges, double isovalue, const std::stop_token& stop) {
  const std::optional<T> threshold = threshold_in<T>(isovalue);
  if (!threshold) return;

  const auto level = [&](int l) {
    return Straddling<T>{static_cast<const T*>(ranges.level(l).ranges), ranges.level(l).count, *threshold};
  };
  const int level_count = ranges.shape().level_count;
  const Straddling<T> of_blocks = level(1);
  std::size_t at = 0;
  for (int k = 0; k < node_count_[2] / 4; ++k)
    for (int j = 0; j < node_count_[1] / 4; ++j)
      for (int i = 0; i < node_count_[0] / 4; ++i, ++at) {
        end_if_stopped(stop);
        if (level_count >= 3 && !level(3)(i, j, k)) continue;
        std::uint64_t candidates = ~std::uint64_t{0};
        if (level_count >= 2) candidates = level(2).children(i, j, k);
        std::uint64_t super_node = 0;
        for (; candidates != 0; candidates &= candidates - 1) {
          const int bit = std::countr_zero(candidates);
          const int x = 4 * i + (bit & 3), y = 4 * j + (bit >> 2 & 3), z = 4 * k + (bit >> 4);
          const std::uint64_t node = of_blocks.children(x, y, z);
          nodes_[static_cast<std::size_t>((z * static_cast<std::int64_t>(node_count_[1]) + y) * node_count_[0] + x)] =
              node;
          super_node |= static_cast<std::uint64_t>(node != 0) << bit;
        }
        super_nodes_[at] = super_node;
      }
  find_boxes(ranges.shape().leaf_count);
}

void Occupancy::find_boxes(const Index3& leaf_count) {
  std::size_t block_count = 0, node_count = 0;
  for (const std::uint64_t node : nodes_)
    if (node != 0) block_count += static_cast<std::size_t>(std::popcount(node)), ++node_count;
  // Each frame may have to project every box, which takes as long as tracing a few rays.
  const BoxEdge edge = block_count <= most_boxes  ? BoxEdge::block
                       : node_count <= most_boxes ? BoxEdge::node
                                                  : BoxEdge::super_node;
  BoxList list{leaf_count, {}, 0};
  const auto add_node = [&](const Index3& node, std::uint64_t bits) {
    if (edge == BoxEdge::node) return list.add(node * 4, bits, 4);
    for (; bits != 0; bits &= bits - 1) list.add(node * 4, bits & (~bits + 1), 4);
  };
  std::size_t at = 0;
  Index3 super_node;
  const Index3 super_nodes(node_count_[0] / 4, node_count_[1] / 4, node_count_[2] / 4);
  for (super_node.z = 0; super_node.z < super_nodes.z; ++super_node.z)
    for (super_node.y = 0; super_node.y < super_nodes.y; ++super_node.y)
      for (super_node.x = 0; super_node.x < super_nodes.x; ++super_node.x, ++at) {
        std::uint64_t bits = super_nodes_[at];
        if (edge == BoxEdge::super_node && bits != 0) list.add(super_node * 4, bits, 16);
        if (edge == BoxEdge::super_node) continue;
        for (; bits != 0; bits &= bits - 1) {
          const int bit = std::countr_zero(bits);
          const Index3 node = super_node * 4 + Index3(bit & 3, bit >> 2 & 3, bit >> 4);
          add_node(node,
                   nodes_[static_cast<std::size_t>((node.z * node_count_[1] + node.y) * node_count_[0] + node.x)]);
        }
      }
  boxes_.push_back(std::move(list.nodes));
  add_upper_levels(boxes_);
}

std::size_t Occupancy::size_bytes() const {
  std::size_t bytes = (nodes_.size() + super_nodes_.size()) * sizeof(std::uint64_t);
  for (const auto& level : boxes_) bytes += level.size() * sizeof(BoxNode);
  return bytes;
}

}  // namespace rhoray::render

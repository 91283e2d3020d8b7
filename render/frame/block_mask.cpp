#include "render/frame/block_mask.h"

#include <algorithm>
#include <array>

namespace rhoray::render {

namespace {

/// Whole numbers in [first, last] that are at least 0 and below `count`; a NaN sets no bound.
struct Whole {
  int first, last;

  Whole(double from, double to, int count) {
    const double end = count - 1;
    const double low = from > 0 ? std::min(from, end + 1) : 0, high = to < end ? std::max(to, -1.0) : end;
    // Truncation is correct: neither is negative.
    first = static_cast<int>(low), last = static_cast<int>(high + 1) - 1;
    first += first < low;
  }

  bool is_empty() const { return first > last; }
};

/// Node `node` of a level, still to be visited.
struct Entry {
  std::size_t node;
  int level;
  BlockRange range;
};

}  // namespace

BlockMask::BlockMask(const PixelLattice& lattice)
    : words_across_(static_cast<std::size_t>((lattice.columns() + block_edge * 64 - 1) / (block_edge * 64))),
      words_(words_across_ * static_cast<std::size_t>((lattice.rows() + block_edge - 1) / block_edge)) {}

template <class Words, class Act>
void BlockMask::for_each_word(Words& words, std::size_t words_across, const BlockRange& range, const Act& act) {
  const std::size_t first = static_cast<std::size_t>(range.first_column) / 64,
                    last = static_cast<std::size_t>(range.last_column) / 64;
  for (std::size_t w = first; w <= last; ++w) {
    std::uint64_t bits = ~std::uint64_t{0};
    if (w == first) bits &= ~std::uint64_t{0} << range.first_column % 64;
    if (w == last) bits &= ~std::uint64_t{0} >> (63 - range.last_column % 64);
    for (int row = range.first_row; row <= range.last_row; ++row)
      act(words[static_cast<std::size_t>(row) * words_across + w], bits);
  }
}

void BlockMask::add(const BlockRange& range) {
  for_each_word(words_, words_across_, range, [](std::uint64_t& word, std::uint64_t bits) { word |= bits; });
}

bool BlockMask::has_all_of(const BlockRange& range) const {
  bool has_all = true;
  for_each_word(words_, words_across_, range,
                [&](std::uint64_t word, std::uint64_t bits) { has_all &= (word & bits) == bits; });
  return has_all;
}

bool BlockMask::is_empty() const {
  return std::all_of(words_.begin(), words_.end(), [](std::uint64_t word) { return word == 0; });
}

std::uint16_t BlockMask::of_tile(const Tile& tile) const {
  const int column = tile.x_begin / block_edge, row_begin = tile.y_begin / block_edge;
  const int row_end = (tile.y_end + block_edge - 1) / block_edge;
  unsigned blocks = 0;
  for (int row = row_begin; row < row_end; ++row) {
    const std::uint64_t word =
        words_[static_cast<std::size_t>(row) * words_across_ + static_cast<std::size_t>(column) / 64];
    static_assert(tile_blocks == 4 && 64 % tile_blocks == 0);
    blocks |= static_cast<unsigned>(word >> column % 64 & 15) << (tile_blocks * (row - row_begin));
  }
  return static_cast<std::uint16_t>(blocks);
}

void add_blocks_that_may_meet(const SurfaceBoxes& boxes, const BoxProjection& projection, const PixelLattice& lattice,
                              BlockMask& mask, Machine machine, const ClipRegion::InFrame* clip) {
  if (boxes.level_count == 0) return;
  const BoxProjection::OntoLattice onto(projection, boxes, lattice, machine);
  const BlockRange all{0, (lattice.columns() - 1) / block_edge, 0, (lattice.rows() - 1) / block_edge};
  std::array<Entry, (BoxNode::size - 1) * SurfaceBoxes::largest_level_count + 1> stack;
  std::size_t top = 0;
  stack[top++] = {0, boxes.level_count - 1, all};
  while (top != 0) {
    const Entry entry = stack[--top];
    if (mask.has_all_of(entry.range)) continue;
    ProjectedNode projected;
    const BoxNode& node = boxes.levels[static_cast<std::size_t>(entry.level)][entry.node];
    onto.project(node, projected);
    for (std::size_t i = 0; i < BoxNode::size; ++i) {
      const Whole columns(projected.first_column[i], projected.last_column[i], lattice.columns()),
          rows(projected.first_row[i], projected.last_row[i], lattice.rows());
      if (columns.is_empty() || rows.is_empty()) continue;
      if (clip != nullptr && clip->takes_away(node, i)) continue;
      const BlockRange range{columns.first / block_edge, columns.last / block_edge, rows.first / block_edge,
                             rows.last / block_edge};
      if (entry.level == 0 || range.is_single())
        mask.add(range);
      else
        stack[top++] = {BoxNode::size * entry.node + i, entry.level - 1, range};
    }
  }
}

}  // namespace rhoray::render

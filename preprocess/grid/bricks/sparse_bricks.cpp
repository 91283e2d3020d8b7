#include "preprocess/grid/bricks/sparse_bricks.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/brick_grid.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

using formats::BrickLayout;

/// The samples of a brick: low <= sample < high.
struct SampleBlock {
  Index3 low, high;
};

SampleBlock block_of(const BrickLayout& layout, std::int64_t brick) {
  const Index3 bricks = layout.brick_count(), count = layout.sample_count;
  const Index3 low =
      Index3(brick % bricks.x, brick / bricks.x % bricks.y, brick / bricks.x / bricks.y) * layout.brick_edge;
  const std::int64_t n = layout.brick_edge;
  return {low, {std::min(low.x + n, count.x), std::min(low.y + n, count.y), std::min(low.z + n, count.z)}};
}

/// Calls act(row, j, k) with the samples of the block along x, for each j and k; act returns false
/// to end.
template <class T, class Act>
void for_each_row(std::span<const T> samples, const Index3& count, const SampleBlock& block, Act&& act) {
  for (std::int64_t k = block.low.z; k < block.high.z; ++k)
    for (std::int64_t j = block.low.y; j < block.high.y; ++j) {
      const auto start = static_cast<std::size_t>((k * count.y + j) * count.x + block.low.x);
      if (!act(samples.subspan(start, static_cast<std::size_t>(block.high.x - block.low.x)), j, k)) return;
    }
}

}  // namespace

template <class T>
void mark_bricks_with_data(std::span<const T> samples, const BrickLayout& layout, std::span<std::uint8_t> holds_data) {
  const auto mark = [&](std::size_t brick) {
    const SampleBlock block = block_of(layout, static_cast<std::int64_t>(brick));
    for_each_row(samples, layout.sample_count, block, [&](std::span<const T> row, std::int64_t, std::int64_t) {
      if (!std::any_of(row.begin(), row.end(), [](T value) { return has_data(value); })) return true;
      holds_data[brick] = 1;
      return false;
    });
  };
  parallel_for(holds_data.size(), 64, [&](const IndexRange& part) {
    for (std::size_t brick = part.begin(); brick < part.end(); ++brick) mark(brick);
  });
}

Array<std::uint64_t> bricks_of_slots(std::span<const std::uint8_t> holds_data) {
  Array<std::uint64_t> bricks;
  for (std::size_t brick = 0; brick < holds_data.size(); ++brick)
    if (holds_data[brick] != 0) bricks.push_back(brick);
  return bricks;
}

Array<std::uint32_t> slots_of_bricks(std::span<const std::uint64_t> bricks, std::size_t brick_count) {
  Array<std::uint32_t> slots(brick_count, formats::BrickGrid::no_brick);
  for (std::size_t slot = 0; slot < bricks.size(); ++slot) slots[bricks[slot]] = static_cast<std::uint32_t>(slot);
  return slots;
}

template <class T>
void write_sparse_samples(std::span<const T> samples, const BrickLayout& layout, std::span<const std::uint64_t> bricks,
                          const std::string& array, formats::PackedFileWriter& writer, ProgressMeter& meter) {
  constexpr std::size_t piece_bytes = std::size_t{1} << 20;  // large enough for the disk
  const std::int64_t n = layout.brick_edge;
  const auto brick_samples = static_cast<std::size_t>(n * n * n);
  const std::size_t piece = std::max<std::size_t>(1, piece_bytes / (brick_samples * sizeof(T)));
  parallel_for(bricks.size(), piece, [&](const IndexRange& part) {
    const std::size_t first = part.begin(), last = part.end();
    std::vector<T> sorted((last - first) * brick_samples, std::numeric_limits<T>::quiet_NaN());
    for (std::size_t slot = first; slot < last; ++slot) {
      T* const brick = sorted.data() + (slot - first) * brick_samples;
      const SampleBlock block = block_of(layout, static_cast<std::int64_t>(bricks[slot]));
      for_each_row(samples, layout.sample_count, block, [&](std::span<const T> row, std::int64_t j, std::int64_t k) {
        std::copy(row.begin(), row.end(), brick + ((k - block.low.z) * n + (j - block.low.y)) * n);
        return true;
      });
    }
    const std::span<const T> written(sorted);
    writer.write(array, first * brick_samples * sizeof(T), std::as_bytes(written));
    meter.add(written.size_bytes());
  });
}

template void mark_bricks_with_data(std::span<const float>, const BrickLayout&, std::span<std::uint8_t>);
template void mark_bricks_with_data(std::span<const double>, const BrickLayout&, std::span<std::uint8_t>);
template void write_sparse_samples(std::span<const float>, const BrickLayout&, std::span<const std::uint64_t>,
                                   const std::string&, formats::PackedFileWriter&, ProgressMeter&);
template void write_sparse_samples(std::span<const double>, const BrickLayout&, std::span<const std::uint64_t>,
                                   const std::string&, formats::PackedFileWriter&, ProgressMeter&);

}  // namespace rhoray::preprocess

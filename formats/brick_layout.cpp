#include "formats/brick_layout.h"

#include <algorithm>

#include "formats/base/checks.h"

namespace rhoray::formats {
namespace {

constexpr std::int64_t divide_up(std::int64_t a, std::int64_t b) {
  return (a + b - 1) / b;
}

/// The largest superbrick edge, in bricks, that pads an axis of `brick_count` bricks by at most 1.5
/// %.
std::int64_t superbrick_edge_for(std::int64_t brick_count, std::int64_t largest) {
  for (std::int64_t m = std::min(largest, brick_count); m > 1; --m) {
    const std::int64_t added = divide_up(brick_count, m) * m - brick_count;
    if (1000 * added <= 15 * brick_count) return m;
  }
  return 1;
}

/// One axis of the address: strides of samples, bricks and superbricks along this axis, in samples
/// of the array.
struct AxisStrides {
  std::uint64_t sample, brick, superbrick;
};

std::vector<std::uint64_t> axis_table(std::int64_t padded_count, std::int64_t n, std::int64_t m,
                                      const AxisStrides& stride) {
  std::vector<std::uint64_t> table(static_cast<std::size_t>(padded_count));
  for (std::int64_t i = 0; i < padded_count; ++i) {
    const std::int64_t brick = i / n;
    table[static_cast<std::size_t>(i)] = static_cast<std::uint64_t>(i % n) * stride.sample +
                                         static_cast<std::uint64_t>(brick % m) * stride.brick +
                                         static_cast<std::uint64_t>(brick / m) * stride.superbrick;
  }
  return table;
}

}  // namespace

BrickLayout BrickLayout::linear(const Index3& sample_count) {
  return {.sample_count = sample_count};
}

BrickLayout BrickLayout::bricked(const Index3& sample_count, std::int64_t brick_edge, std::int64_t largest_superbrick) {
  RHORAY_CHECK(brick_edge >= 1 && largest_superbrick >= 1);
  const auto edge = [&](std::int64_t samples) {
    return superbrick_edge_for(divide_up(samples, brick_edge), largest_superbrick);
  };
  return {.sample_count = sample_count,
          .brick_edge = brick_edge,
          .superbrick_edge = {edge(sample_count.x), edge(sample_count.y), edge(sample_count.z)}};
}

BrickLayout BrickLayout::sparse(const Index3& sample_count, std::uint64_t stored_brick_count, std::int64_t brick_edge) {
  RHORAY_CHECK(is_sparse_edge(brick_edge));
  return {sample_count, brick_edge, {1, 1, 1}, true, stored_brick_count};
}

bool BrickLayout::is_sparse_edge(std::int64_t brick_edge) {
  return brick_edge >= 2 && brick_edge <= 64 && (brick_edge & (brick_edge - 1)) == 0;
}

Index3 BrickLayout::brick_count() const {
  return {divide_up(sample_count.x, brick_edge), divide_up(sample_count.y, brick_edge),
          divide_up(sample_count.z, brick_edge)};
}

Index3 BrickLayout::superbrick_count() const {
  const Index3 edge = superbrick_edge * brick_edge;
  return {divide_up(sample_count.x, edge.x), divide_up(sample_count.y, edge.y), divide_up(sample_count.z, edge.z)};
}

Index3 BrickLayout::padded_count() const {
  return superbrick_count() * superbrick_edge * brick_edge;
}

std::vector<std::uint64_t> BrickLayout::shape() const {
  const auto size = [](std::int64_t count) { return static_cast<std::uint64_t>(count); };
  if (is_linear()) return {size(sample_count.z), size(sample_count.y), size(sample_count.x)};
  const std::uint64_t n = size(brick_edge);
  if (is_sparse) return {stored_brick_count, n, n, n};
  return {size(volume(superbrick_count())),
          size(superbrick_edge.z),
          size(superbrick_edge.y),
          size(superbrick_edge.x),
          n,
          n,
          n};
}

AxisTables::AxisTables(const BrickLayout& layout) {
  const auto n = static_cast<std::uint64_t>(layout.brick_edge);
  const std::uint64_t brick = n * n * n;
  const Imath::Vec3<std::uint64_t> m(layout.superbrick_edge), count(layout.superbrick_count());
  const std::uint64_t superbrick = m.x * m.y * m.z * brick;
  const Index3 padded = layout.padded_count();
  x = axis_table(padded.x, layout.brick_edge, layout.superbrick_edge.x, {1, brick, superbrick});
  y = axis_table(padded.y, layout.brick_edge, layout.superbrick_edge.y, {n, m.x * brick, count.x * superbrick});
  z = axis_table(padded.z, layout.brick_edge, layout.superbrick_edge.z,
                 {n * n, m.x * m.y * brick, count.x * count.y * superbrick});
}

}  // namespace rhoray::formats

#include "render/grid/block_samples.h"

namespace rhoray::render::wide {

namespace {

/// True where, in each group of four samples of an axis, each address is `step` above the one
/// before.
bool has_steps(const std::vector<std::uint64_t>& address, std::int64_t count, std::uint64_t step) {
  for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(count); ++i)
    if (i % 4 != 3 && address[i + 1] != address[i] + step) return false;
  return true;
}

}  // namespace

SampleSource::SampleSource(const void* first, const formats::AxisTables& tables, const Index3& sample_count)
    : samples(first),
      address{tables.x.data(), tables.y.data(), tables.z.data()},
      count{static_cast<int>(sample_count.x), static_cast<int>(sample_count.y), static_cast<int>(sample_count.z)},
      has_whole_rows(has_steps(tables.x, sample_count.x, 1)),
      has_whole_bricks(has_whole_rows && has_steps(tables.y, sample_count.y, 4) &&
                       has_steps(tables.z, sample_count.z, 16)) {}

}  // namespace rhoray::render::wide

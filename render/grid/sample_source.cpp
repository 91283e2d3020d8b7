#include "render/grid/sample_source.h"

namespace rhoray::render {

namespace {

/// True where, in each group of four samples of an axis, each address is `step` above the one
/// before.
bool has_steps(const std::vector<std::uint64_t>& address, std::size_t count, std::uint64_t step) {
  for (std::size_t i = 0; i + 1 < count; ++i)
    if (i % 4 != 3 && address[i + 1] != address[i] + step) return false;
  return true;
}

/// The same for all samples of an axis, padding included, if these are whole groups.
bool is_in_fours(const std::vector<std::uint64_t>& address, std::uint64_t step) {
  return address.size() % 4 == 0 && has_steps(address, address.size(), step);
}

}  // namespace

SampleSource::SampleSource(formats::ElementType element_type, const void* first, const formats::AxisTables& tables,
                           const Index3& sample_count)
    : type(element_type),
      samples(first),
      address{tables.x.data(), tables.y.data(), tables.z.data()},
      count{static_cast<int>(sample_count.x), static_cast<int>(sample_count.y), static_cast<int>(sample_count.z)},
      has_whole_rows(has_steps(tables.x, static_cast<std::size_t>(sample_count.x), 1)),
      has_whole_bricks(has_whole_rows && has_steps(tables.y, static_cast<std::size_t>(sample_count.y), 4) &&
                       has_steps(tables.z, static_cast<std::size_t>(sample_count.z), 16)),
      has_padded_squares(is_in_fours(tables.x, 1) && is_in_fours(tables.y, 4)),
      has_padded_bricks(has_padded_squares && is_in_fours(tables.z, 16)) {}

}  // namespace rhoray::render

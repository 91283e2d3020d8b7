#include <cmath>

#include "preprocess/workers/vdb/hand_out.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t bin_count = 256;

/// Calls act(value, count) for the active values: count voxels have this one.
template <class Grid, class Act>
void for_each_active(const Grid& grid, Act&& act) {
  for (auto on = grid.cbeginValueOn(); on; ++on)
    act(static_cast<double>(*on),
        on.isVoxelValue() ? std::uint64_t{1} : static_cast<std::uint64_t>(on.getVoxelCount()));
}

}  // namespace

formats::FieldSummary summarize(const ScalarGrid& scalar) {
  formats::FieldSummary field;
  field.name = scalar.name;
  field.unit = scalar.field_unit;
  field.type = scalar.source_type;
  std::visit(
      [&](const auto& grid) {
        std::uint64_t active_count = 0;
        for_each_active(*grid, [&](double value, std::uint64_t count) {
          active_count += count;
          if (std::isfinite(value))
            field.range.include(value);
          else
            field.no_data_count += count;
        });
        if (scalar.inactive_is_no_data)
          field.no_data_count += scalar.box.volume() - active_count;
        else
          field.range.include(static_cast<double>(grid->background()));
        if (field.range.is_empty()) return;
        field.histogram.assign(bin_count, 0);
        for_each_active(*grid, [&](double value, std::uint64_t count) {
          if (std::isfinite(value)) field.histogram[formats::histogram_bin(field.range, bin_count, value)] += count;
        });
      },
      scalar.grid);
  return field;
}

}  // namespace rhoray::preprocess

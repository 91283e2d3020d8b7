#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "formats/brick_grid.h"

namespace rhoray::preprocess {

/// One field of a packed grid by the position of its samples, whatever the layout.
template <class T>
class GridSamples {
 public:
  explicit GridSamples(const formats::BrickGrid& grid) : grid_(grid), samples_(grid.samples<T>()) {}

  const formats::FieldSummary& field() const { return grid_.description().field; }
  const Index3& sample_count() const { return grid_.description().layout.sample_count; }
  T at(std::int64_t i, std::int64_t j, std::int64_t k) const { return samples_[grid_.tables().address(i, j, k)]; }

  /// Fills `row` with the samples (0, j, k), (1, j, k), ...
  void read_row(std::int64_t j, std::int64_t k, std::span<T> row) const {
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = at(static_cast<std::int64_t>(i), j, k);
  }

 private:
  const formats::BrickGrid& grid_;
  std::span<const T> samples_;
};

/// Opens a packed grid; refuses a file of another kind and a field that it does not have (Trouble::usage).
/// @param field  empty = the first
formats::BrickGrid open_grid(const std::filesystem::path& path, const std::string& field);

/// Calls act(GridSamples<T>) with the field's type; returns what act returns.
template <class Act>
decltype(auto) with_samples(const formats::BrickGrid& grid, Act&& act) {
  return formats::with_element_type(grid.description().field.type,
                                    [&]<class T>(T) -> decltype(auto) { return act(GridSamples<T>(grid)); });
}

}  // namespace rhoray::preprocess

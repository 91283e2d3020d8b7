#include "preprocess/values/build_levels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "formats/base/parallel.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

using formats::MacroShape;

std::size_t position(const Index3& count, std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<std::size_t>((k * count.y + j) * count.x + i);
}

/// Number of rows of macrocells along x; they are stored one after another.
std::size_t row_count(const Index3& count) {
  return static_cast<std::size_t>(count.z * count.y);
}
constexpr std::size_t rows_at_once = 8;

/// Builds level 1, one row of macrocells along x at a time.
template <class T>
class GridRow {
 public:
  GridRow(std::span<const T> samples, const MacroShape& shape)
      : samples_(samples),
        shape_(shape),
        count_(shape.leaf_count + Index3(1, 1, 1)),
        lo_(static_cast<std::size_t>(count_.x)),
        hi_(lo_.size()),
        lacks_data_(lo_.size()) {}

  void build(std::int64_t j, std::int64_t k, std::span<T> ranges) {
    const bool all_data = reduce_columns(j, k);
    if (!all_data) mark_columns(j, k);
    for (std::int64_t i = 0; i < shape_.count(1).x; ++i) {
      const Interval<T> range =
          all_data || !touches_marked_column(i) ? range_of_columns(i) : range_of_cells_with_data(i, j, k);
      ranges[static_cast<std::size_t>(2 * i)] = range.lo;
      ranges[static_cast<std::size_t>(2 * i + 1)] = range.hi;
    }
  }

 private:
  /// Along an axis of n samples, a macrocell covers samples first..last, both included.
  std::int64_t first(std::int64_t cell) const { return cell * shape_.factor; }
  std::int64_t last(std::int64_t cell, std::int64_t n) const { return std::min(first(cell) + shape_.factor, n - 1); }

  template <class Act>
  void for_each_row(std::int64_t cell_j, std::int64_t cell_k, Act&& act) const {
    for (std::int64_t k = first(cell_k); k <= last(cell_k, count_.z); ++k)
      for (std::int64_t j = first(cell_j); j <= last(cell_j, count_.y); ++j)
        act(samples_.data() + position(count_, 0, j, k));
  }

  /// Combines the rows of samples element by element, so that the loop vectorises. Returns false
  /// when one lacks data.
  bool reduce_columns(std::int64_t cell_j, std::int64_t cell_k) {
    const std::size_t n = lo_.size();
    std::fill(lo_.begin(), lo_.end(), Interval<T>::highest());
    std::fill(hi_.begin(), hi_.end(), Interval<T>::lowest());
    unsigned lacking = 0;
    for_each_row(cell_j, cell_k, [&](const T* row) {
      T* const lo = lo_.data();
      T* const hi = hi_.data();
      for (std::size_t i = 0; i < n; ++i) {
        lo[i] = row[i] < lo[i] ? row[i] : lo[i];
        hi[i] = row[i] > hi[i] ? row[i] : hi[i];
      }
      if constexpr (std::is_floating_point_v<T>)
        for (std::size_t i = 0; i < n; ++i) lacking |= static_cast<unsigned>(!has_data(row[i]));
    });
    return lacking == 0;
  }

  void mark_columns(std::int64_t cell_j, std::int64_t cell_k) {
    std::fill(lacks_data_.begin(), lacks_data_.end(), std::uint8_t{0});
    for_each_row(cell_j, cell_k, [&](const T* row) {
      for (std::size_t i = 0; i < lacks_data_.size(); ++i)
        lacks_data_[i] |= static_cast<std::uint8_t>(!has_data(row[i]));
    });
  }

  bool touches_marked_column(std::int64_t cell_i) const {
    const auto begin = lacks_data_.begin() + first(cell_i), end = lacks_data_.begin() + last(cell_i, count_.x) + 1;
    return std::find(begin, end, 1) != end;
  }

  Interval<T> range_of_columns(std::int64_t cell_i) const {
    Interval<T> range;
    for (std::int64_t i = first(cell_i); i <= last(cell_i, count_.x); ++i)
      range.include(Interval<T>{lo_[static_cast<std::size_t>(i)], hi_[static_cast<std::size_t>(i)]});
    return range;
  }

  Interval<T> range_of_cells_with_data(std::int64_t cell_i, std::int64_t cell_j, std::int64_t cell_k) const {
    Interval<T> range;
    for (std::int64_t k = first(cell_k); k < last(cell_k, count_.z); ++k)
      for (std::int64_t j = first(cell_j); j < last(cell_j, count_.y); ++j)
        for (std::int64_t i = first(cell_i); i < last(cell_i, count_.x); ++i) include_leaf_cell(i, j, k, range);
    return range;
  }

  void include_leaf_cell(std::int64_t i, std::int64_t j, std::int64_t k, Interval<T>& range) const {
    Interval<T> of_cell;
    for (int corner = 0; corner < 8; ++corner) {
      const T value = samples_[position(count_, i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2))];
      if (!has_data(value)) return;
      of_cell.include(value);
    }
    range.include(of_cell);
  }

  std::span<const T> samples_;
  const MacroShape& shape_;
  Index3 count_;
  /// of each column of samples (fixed x) in the row of macrocells
  std::vector<T> lo_, hi_;
  std::vector<std::uint8_t> lacks_data_;  ///< 1 where the column holds NaN or infinity
};

/// Joins the intervals of factor^3 cells of a level into one of the level above.
template <class T>
Array<T> level_above(const MacroShape& shape, int level, const Array<T>& below) {
  const Index3 count = shape.count(level), count_below = shape.count(level - 1);
  Array<T> above(static_cast<std::size_t>(2 * volume(count)));
  parallel_for(row_count(count), rows_at_once, [&](const IndexRange& rows) {
    for (std::size_t row = rows.begin(); row < rows.end(); ++row) {
      const std::int64_t j = static_cast<std::int64_t>(row) % count.y, k = static_cast<std::int64_t>(row) / count.y;
      for (std::int64_t i = 0; i < count.x; ++i) {
        Interval<T> range;
        for (std::int64_t z = k * shape.factor; z < std::min((k + 1) * shape.factor, count_below.z); ++z)
          for (std::int64_t y = j * shape.factor; y < std::min((j + 1) * shape.factor, count_below.y); ++y)
            for (std::int64_t x = i * shape.factor; x < std::min((i + 1) * shape.factor, count_below.x); ++x) {
              const std::size_t at = 2 * position(count_below, x, y, z);
              range.include(Interval<T>{below[at], below[at + 1]});
            }
        const std::size_t at = 2 * position(count, i, j, k);
        above[at] = range.lo;
        above[at + 1] = range.hi;
      }
    }
  });
  return above;
}

}  // namespace

template <class T>
Levels<T> build_grid_levels(std::span<const T> samples, const MacroShape& shape, const Progress& progress) {
  const Index3 count = shape.count(1);
  Levels<T> levels(1);
  levels[0].resize(static_cast<std::size_t>(2 * volume(count)));
  ProgressMeter meter(progress, "finding ranges of macrocells (macrocells)", static_cast<std::uint64_t>(volume(count)));
  parallel_for(row_count(count), rows_at_once, [&](const IndexRange& rows) {
    GridRow<T> builder(samples, shape);
    for (std::size_t row = rows.begin(); row < rows.end(); ++row)
      builder.build(static_cast<std::int64_t>(row) % count.y, static_cast<std::int64_t>(row) / count.y,
                    std::span(levels[0]).subspan(2 * row * static_cast<std::size_t>(count.x),
                                                 static_cast<std::size_t>(2 * count.x)));
    meter.add(rows.size() * static_cast<std::size_t>(count.x));
  });
  for (int level = 2; level <= shape.level_count; ++level) levels.push_back(level_above(shape, level, levels.back()));
  return levels;
}

template <class T>
void add_levels_above_leaves(Levels<T>& levels, const MacroShape& shape) {
  for (int level = 1; level <= shape.level_count; ++level) levels.push_back(level_above(shape, level, levels.back()));
}

template Levels<std::uint8_t> build_grid_levels(std::span<const std::uint8_t>, const MacroShape&, const Progress&);
template Levels<std::int8_t> build_grid_levels(std::span<const std::int8_t>, const MacroShape&, const Progress&);
template Levels<std::uint16_t> build_grid_levels(std::span<const std::uint16_t>, const MacroShape&, const Progress&);
template Levels<std::int16_t> build_grid_levels(std::span<const std::int16_t>, const MacroShape&, const Progress&);
template Levels<std::uint32_t> build_grid_levels(std::span<const std::uint32_t>, const MacroShape&, const Progress&);
template Levels<std::int32_t> build_grid_levels(std::span<const std::int32_t>, const MacroShape&, const Progress&);
template Levels<float> build_grid_levels(std::span<const float>, const MacroShape&, const Progress&);
template Levels<double> build_grid_levels(std::span<const double>, const MacroShape&, const Progress&);
template void add_levels_above_leaves(Levels<float>&, const MacroShape&);
template void add_levels_above_leaves(Levels<double>&, const MacroShape&);

}  // namespace rhoray::preprocess

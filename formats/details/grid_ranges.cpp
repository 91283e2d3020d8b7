#include <algorithm>
#include <mutex>
#include <vector>

#include "formats/base/stopping.h"
#include "formats/details/range_checks.h"
#include "formats/details/samples_by_position.h"

namespace rhoray::formats::details {
namespace {

/// Compares one field's samples with the macrocells of level 1.
///
/// A dense grid is read in rows of macrocells: all samples of a row at once, without testing each
/// cell. If every sample has data, the smallest and the largest are the range that the macrocell
/// needs. Macrocells with gaps, and those that seem to miss a value, are checked again cell by
/// cell.
template <class T>
class GridRanges {
 public:
  GridRanges(const BrickGrid& grid, std::size_t field, const CheckOptions& options, Findings& findings)
      : layout_(grid.description().layout),
        tables_(grid.tables()),
        samples_(grid.samples<T>(field)),
        sample_at_(grid, field),
        levels_(grid.macro_levels<T>(field)),
        of_field_(grid.description().fields.size() == 1
                      ? ""
                      : concat(" of field '", grid.description().fields[field].name, "'")),
        options_(options),
        findings_(findings) {}

  RangesRead run() {
    RangesRead read{.bytes = samples_.size_bytes()};
    for (const std::span<const T>& level : levels_.ranges) read.bytes += level.size_bytes();
    std::mutex guard;
    const Index3 count = levels_.shape.count(1);
    ProgressMeter meter(options_.watch.progress, "checking ranges (macrocells)",
                        static_cast<std::uint64_t>(volume(count)));
    for_each_range(static_cast<std::uint64_t>(count.y * count.z), least_rows, options_.threads,
                   [&](std::uint64_t first, std::uint64_t last) {
                     Part part(layout_.sample_count.x);
                     for (auto row = static_cast<std::int64_t>(first); row < static_cast<std::int64_t>(last); ++row) {
                       end_if_stopped(options_.watch.stop);
                       check_row(row % count.y, row / count.y, part);
                       meter.add(static_cast<std::uint64_t>(count.x));
                     }
                     const std::lock_guard lock(guard);
                     if (!part.values.is_empty())
                       read.values.include({static_cast<double>(part.values.lo), static_cast<double>(part.values.hi)});
                     read.has_gaps = read.has_gaps || part.has_gaps;
                   });
    check_levels_upward(levels_, concat("macro levels", of_field_), options_, findings_);
    return read;
  }

 private:
  // macrocells; a smaller piece finishes before another thread could start
  static constexpr std::uint64_t least_rows = 16;

  /// Findings and buffers of one thread.
  struct Part {
    Interval<T> values;
    bool has_gaps = false;
    std::vector<T> row, lo, hi, gap;  ///< by sample along x; gap: 0 where all have data, else NaN
    std::vector<T> block;

    explicit Part(std::int64_t sample_count) {
      for (std::vector<T>* each : {&row, &lo, &hi, &gap}) each->resize(static_cast<std::size_t>(sample_count));
    }
  };

  /// The leaf cells of a macrocell: first <= cell < end.
  struct Cells {
    Index3 first, end;
  };
  Cells cells_of(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const MacroShape& shape = levels_.shape;
    Cells cells{.first = Index3(i, j, k) * shape.factor, .end = {}};
    for (int axis = 0; axis < 3; ++axis)
      cells.end[axis] = std::min(cells.first[axis] + shape.factor, shape.leaf_count[axis]);
    return cells;
  }

  /// Checks all macrocells (i, j, k) of level 1 for one j and k.
  void check_row(std::int64_t j, std::int64_t k, Part& part) {
    const Index3 count = levels_.shape.count(1);
    const T* const stored = levels_.ranges[0].data() + 2 * linear_order(count, 0, j, k);
    if (!layout_.is_sparse) read_rows(cells_of(0, j, k), part);
    for (std::int64_t i = 0; i < count.x; ++i) {
      const Interval<T> range{stored[2 * i], stored[2 * i + 1]};
      if (layout_.is_sparse) {
        check_cells({i, j, k}, range, part);
        continue;
      }
      const Cells cells = cells_of(i, j, k);
      Interval<T> reached;
      T gap{};
      for (std::int64_t x = cells.first.x; x <= cells.end.x; ++x) {
        const auto at = static_cast<std::size_t>(x);
        reached.include({part.lo[at], part.hi[at]});
        gap += part.gap[at];
      }
      if (gap == 0 && holds(range, reached))
        part.values.include(reached);
      else
        check_cells({i, j, k}, range, part);
    }
  }

  /// Finds the smallest and largest sample at each x, over the samples of the cells along y and z.
  void read_rows(const Cells& cells, Part& part) const {
    std::fill(part.lo.begin(), part.lo.end(), Interval<T>::highest());
    std::fill(part.hi.begin(), part.hi.end(), Interval<T>::lowest());
    std::fill(part.gap.begin(), part.gap.end(), T{});
    for (std::int64_t z = cells.first.z; z <= cells.end.z; ++z)
      for (std::int64_t y = cells.first.y; y <= cells.end.y; ++y) add_row(tables_.address(0, y, z), part);
  }

  /// @param first  address of the row's first sample
  void add_row(std::uint64_t first, Part& part) const {
    const std::size_t count = part.row.size();
    const T* const samples = samples_.data() + first;
    const std::uint64_t* const offset = tables_.x.data();  // the first is 0
    T *const row = part.row.data(), *const lo = part.lo.data(), *const hi = part.hi.data();
    for (std::size_t x = 0; x < count; ++x) row[x] = samples[offset[x]];
    for (std::size_t x = 0; x < count; ++x) {  // a NaN changes neither
      lo[x] = row[x] < lo[x] ? row[x] : lo[x];
      hi[x] = row[x] > hi[x] ? row[x] : hi[x];
    }
    if constexpr (std::is_floating_point_v<T>) {
      T* const gap = part.gap.data();
      for (std::size_t x = 0; x < count; ++x) gap[x] += row[x] - row[x];
    }
  }

  void check_cells(const Index3& macrocell, const Interval<T>& stored, Part& part) {
    const Interval<T> needed = needed_by(cells_of(macrocell.x, macrocell.y, macrocell.z), part);
    part.values.include(needed);
    if (holds(stored, needed)) return;
    findings_.add(concat("an interval", of_field_, " that lacks a value of its macrocell"),
                  linear_order(levels_.shape.count(1), macrocell.x, macrocell.y, macrocell.z), [&] {
                    return concat(cell_text(1, macrocell), " has ", interval_text(stored), ", its samples need ",
                                  interval_text(needed));
                  });
  }

  /// All values that interpolation reaches in these cells: the range of the corners of each cell
  /// whose eight corners have data.
  Interval<T> needed_by(const Cells& cells, Part& part) const {
    if (!sample_at_.some_stored(cells.first, cells.end)) {
      part.has_gaps = true;
      return {};
    }
    const Index3 size = cells.end - cells.first + Index3(1, 1, 1);
    part.block.clear();
    Interval<T> all;
    bool is_whole = true;
    for (std::int64_t z = cells.first.z; z <= cells.end.z; ++z)
      for (std::int64_t y = cells.first.y; y <= cells.end.y; ++y)
        for (std::int64_t x = cells.first.x; x <= cells.end.x; ++x) {
          const T value = sample_at_(x, y, z);
          part.block.push_back(value);
          is_whole = is_whole && is_value(value);
          all.include(value);
        }
    if (is_whole) return all;
    part.has_gaps = true;
    Interval<T> needed;
    for (std::int64_t z = 0; z + 1 < size.z; ++z)
      for (std::int64_t y = 0; y + 1 < size.y; ++y)
        for (std::int64_t x = 0; x + 1 < size.x; ++x) {
          Interval<T> cell;
          bool has_data = true;
          for (std::int64_t corner = 0; corner < 8; ++corner) {
            const T value = part.block[static_cast<std::size_t>(
                linear_order(size, x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)))];
            has_data = has_data && is_value(value);
            cell.include(value);
          }
          if (has_data) needed.include(cell);
        }
    return needed;
  }

  const BrickLayout& layout_;
  const AxisTables& tables_;
  std::span<const T> samples_;
  SamplesByPosition<T> sample_at_;
  MacroLevelsView<T> levels_;
  std::string of_field_;  ///< for findings; used if there are several fields
  const CheckOptions& options_;
  Findings& findings_;
};

}  // namespace

RangesRead check_ranges(const BrickGrid& grid, std::size_t field, const CheckOptions& options, Findings& findings) {
  return with_element_type(grid.description().fields[field].type,
                           [&](auto zero) { return GridRanges<decltype(zero)>(grid, field, options, findings).run(); });
}

}  // namespace rhoray::formats::details

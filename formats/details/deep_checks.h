#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "formats/base/text.h"
#include "formats/field_summary.h"
#include "formats/macro_levels.h"

/// Shared parts of deep_findings for grids and meshes.
namespace rhoray::formats::details {

/// How a check runs.
struct CheckOptions {
  unsigned threads = 0;  ///< 0 = all cores
  Watch watch{};
};

/// Collects findings. Findings of the same kind become one sentence: the first location, and the
/// count. Thread-safe; the text does not depend on the order of the threads.
class Findings {
 public:
  /// @param kind   what is wrong; start of the sentence
  /// @param order  the finding with the smallest order is shown
  void add(const std::string& kind, std::uint64_t order, const std::function<std::string()>& first);
  std::vector<std::string> sentences() const;

 private:
  struct Kind {
    std::uint64_t count = 0, order = 0;
    std::string first;
  };
  std::mutex guard_;
  std::map<std::string, Kind> kinds_;
};

template <class T>
bool is_value(T value) {
  if constexpr (std::is_floating_point_v<T>)
    return std::isfinite(value);
  else
    return true;
}

/// Recounts the values of a field, to compare with its summary.
class FieldTally {
 public:
  explicit FieldTally(const FieldSummary& summary);

  template <class T>
  void take(T value) {
    if (is_value(value))
      take_finite(static_cast<double>(value));
    else
      ++no_data_count_;
  }
  void take(const FieldTally& other);
  void take_no_data(std::uint64_t count) { no_data_count_ += count; }
  void compare(Findings& findings) const;

 private:
  void take_finite(double value);

  const FieldSummary& summary_;
  Interval<double> range_;
  std::uint64_t finite_count_ = 0, no_data_count_ = 0;
  std::vector<std::uint64_t> inside_;   ///< values well inside a bin
  std::vector<std::uint64_t> at_edge_;  ///< values that rounding may put into bin b - 1 or b
};

/// Checks that a macrocell of level l + 1 contains the intervals of its cells of level l, and is
/// empty when all of them are.
template <class T>
void check_levels_upward(const MacroLevelsView<T>& view, const std::string& what, const CheckOptions& options,
                         Findings& findings);

/// True when a stored interval contains a needed one, or both are empty. Written so that a stored
/// NaN contains nothing.
template <class T>
bool holds(const Interval<T>& stored, const Interval<T>& needed) {
  return needed.is_empty() ? stored.is_empty() : stored.lo <= needed.lo && needed.hi <= stored.hi;
}

std::string cell_text(int level, const Index3& cell);
template <class T>
std::string interval_text(const Interval<T>& interval) {
  if (interval.is_empty()) return "empty";
  return concat("[", +interval.lo, ", ", +interval.hi, "]");  // + prints 8-bit integers as numbers
}

/// Calls act(i, j, k) for all cells of a lattice, x fastest, with k from first to last.
template <class Act>
void for_each_cell(const Index3& count, std::uint64_t first, std::uint64_t last, Act&& act) {
  for (auto k = static_cast<std::int64_t>(first); k < static_cast<std::int64_t>(last); ++k)
    for (std::int64_t j = 0; j < count.y; ++j)
      for (std::int64_t i = 0; i < count.x; ++i) act(i, j, k);
}

inline std::uint64_t linear_order(const Index3& count, std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<std::uint64_t>((k * count.y + j) * count.x + i);
}

}  // namespace rhoray::formats::details

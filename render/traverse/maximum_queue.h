#pragma once

#include <algorithm>
#include <vector>

#include "formats/base/vector.h"

namespace rhoray::render {

/// The priority queue of maximum-intensity projection (paper, section 4.3): regions of a ray with
/// an upper bound of their values, and values found. The order is:
/// 1. the largest value first;
/// 2. among equals, the one nearer to the eye;
/// 3. at the same t, found values before regions;
/// 4. of several found values, the one in the cell that the ray enters first, then the one of the
///    smallest id.
///
/// So the answer is the largest value at the smallest t. On a face between two cells it is the
/// value of the cell before the face. The order of insertion has no influence.
class MaximumQueue {
 public:
  static constexpr int found = -1;

  struct Entry {
    double bound = 0;  ///< no value in the region is larger; the value itself when found
    double t_in = 0;   ///< where the region begins, or where the value was found
    /// Where the region ends; for a found value, where the ray enters its cell.
    double t_out = 0;
    Index3 cell{0, 0, 0};  ///< position in its level
    int level = found;     ///< level of the region's macrocell, 0 for a leaf cell
    int axis_in = -1;
    int axis_out = -1;
    std::uint64_t id = 0;  ///< id of the cell of a found value
  };

  /// Room for everything that one ray can insert; called once per thread and frame, never per ray.
  void reserve(std::size_t entries) { heap_.reserve(entries); }
  std::size_t capacity() const { return heap_.capacity(); }

  void clear() { heap_.clear(); }
  bool is_empty() const { return heap_.empty(); }

  void push(const Entry& entry) {
    heap_.push_back(entry);
    std::push_heap(heap_.begin(), heap_.end(), comes_later);
  }
  Entry pop() {
    std::pop_heap(heap_.begin(), heap_.end(), comes_later);
    const Entry first = heap_.back();
    heap_.pop_back();
    return first;
  }

 private:
  static bool comes_later(const Entry& a, const Entry& b) {
    if (a.bound != b.bound) return a.bound < b.bound;
    if (a.t_in != b.t_in) return a.t_in > b.t_in;
    if ((a.level == found) != (b.level == found)) return b.level == found;
    if (a.level == found && a.t_out != b.t_out) return a.t_out > b.t_out;
    return a.id > b.id;
  }
  std::vector<Entry> heap_;
};

}  // namespace rhoray::render

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "formats/base/checks.h"

/// Mailboxes: they avoid testing a ray again against a cell that an earlier list contained.
namespace rhoray::study {

/// No mailbox, as in the scalar kernel, which reads every list from its beginning.
struct NoMailbox {
  void begin_ray() {}
  RHORAY_INLINE bool is_new(std::uint32_t) { return true; }
};

/// The number of the last ray that was tested against each cell. 4 bytes per cell and thread.
class ExactMailbox {
 public:
  explicit ExactMailbox(std::size_t cell_count) : last_ray_(cell_count, 0) {}

  void begin_ray() {
    if (++ray_ != 0) return;
    std::fill(last_ray_.begin(), last_ray_.end(), 0);
    ray_ = 1;
  }
  RHORAY_INLINE bool is_new(std::uint32_t cell) {
    if (last_ray_[cell] == ray_) return false;
    last_ray_[cell] = ray_;
    return true;
  }

 private:
  std::vector<std::uint32_t> last_ray_;
  std::uint32_t ray_ = 0;
};

/// The last cells, one for each remainder of their positions by 64. A cell is tested again if
/// another has replaced it.
class SmallMailbox {
 public:
  void begin_ray() { last_.fill(std::numeric_limits<std::uint32_t>::max()); }
  RHORAY_INLINE bool is_new(std::uint32_t cell) {
    std::uint32_t& last = last_[cell % last_.size()];
    if (last == cell) return false;
    last = cell;
    return true;
  }

 private:
  std::array<std::uint32_t, 64> last_{};
};

}  // namespace rhoray::study

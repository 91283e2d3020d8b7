#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "formats/base/checks.h"

namespace rhoray::render {

/// The tetrahedra already tested for one ray: lists of several leaf cells may name the same one.
/// Open addressing. The first 48, more than most rays need, use no heap memory.
class Mailbox {
 public:
  Mailbox() { first_slots_.fill(none); }
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  /// Returns true if the tetrahedron was not yet in the set. Index 2^32 - 1 is always new: that
  /// costs a second test but does not change the result.
  RHORAY_INLINE bool add(std::uint32_t tet) {
    if (tet == none) return true;
    std::uint32_t& slot = place_of(tet);
    if (slot == tet) return false;
    slot = tet;
    if (++count_ > mask_ - mask_ / 4) grow();
    return true;
  }

 private:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  /// Returns its slot, or the free slot where it belongs; a quarter of the slots is always free.
  /// Neighbours in a mesh have adjacent indices, so the low bits separate them well.
  RHORAY_INLINE std::uint32_t& place_of(std::uint32_t tet) {
    std::uint32_t at = tet & mask_;
    while (slots_[at] != none && slots_[at] != tet) at = (at + 1) & mask_;
    return slots_[at];
  }

  void grow() {
    const std::vector<std::uint32_t> before(slots_, slots_ + mask_ + 1);
    mask_ = 4 * mask_ + 3;
    more_slots_.assign(std::size_t{mask_} + 1, none);
    slots_ = more_slots_.data();
    for (const std::uint32_t tet : before)
      if (tet != none) place_of(tet) = tet;
  }

  std::array<std::uint32_t, 64> first_slots_;
  std::vector<std::uint32_t> more_slots_;  ///< replace first_slots_ once they are full
  std::uint32_t* slots_ = first_slots_.data();
  std::uint32_t mask_ = 63;  ///< number of slots less 1: a power of two less 1
  std::uint32_t count_ = 0;
};

}  // namespace rhoray::render

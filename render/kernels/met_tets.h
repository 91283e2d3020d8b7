#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/base/checks.h"

namespace rhoray::render {

/// The tetrahedra that one ray has been held against: lists of several leaf cells name the same. Open addressing; the
/// first 48, more than most rays meet, need no memory but their own.
class MetTets {
 public:
  MetTets() { slots_.fill(none); }

  /// True for one that was not there. Position 2^32 - 1 is always new: that costs a test, no answer.
  RHORAY_INLINE bool add(std::uint32_t tet) {
    if (tet == none) return true;
    const std::span<std::uint32_t> slots = more_slots_.empty() ? std::span(slots_) : std::span(more_slots_);
    std::uint32_t& slot = place_of(tet, slots);
    if (slot == tet) return false;
    slot = tet;
    if (++count_ > slots.size() / 4 * 3) grow(slots);
    return true;
  }

 private:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  /// Where it stands, or the free slot where it belongs. Some are always free.
  RHORAY_INLINE static std::uint32_t& place_of(std::uint32_t tet, std::span<std::uint32_t> slots) {
    // Neighbours in a mesh have positions side by side: their last bits part them well.
    std::size_t at = tet % slots.size();
    while (slots[at] != none && slots[at] != tet) at = (at + 1) % slots.size();
    return slots[at];
  }

  void grow(std::span<const std::uint32_t> slots) {
    std::vector<std::uint32_t> more(4 * slots.size(), none);
    for (const std::uint32_t tet : slots)
      if (tet != none) place_of(tet, more) = tet;
    more_slots_.swap(more);
  }

  std::array<std::uint32_t, 64> slots_;
  std::vector<std::uint32_t> more_slots_;  ///< in their place, once they are full
  std::size_t count_ = 0;
};

}  // namespace rhoray::render

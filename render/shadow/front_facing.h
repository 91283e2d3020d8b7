#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "formats/base/checks.h"
#include "render/query/machine.h"
#include "render/shadow/occluder_heights.h"
#include "render/triangles/facets.h"

namespace rhoray::render::wide {

/// A block of facets as a light in one direction sees them, side by side; all in single precision, which moves places
/// by less than 2^-22.
struct alignas(64) SeenBlock {
  static constexpr std::size_t size = FacetBlock::size;

  float low[2][size], high[2][size];  ///< of the places of the corners
  float lowest[size], highest[size];  ///< height
  float middle[2][size];              ///< a place inside: of the first three corners the middle
  std::uint16_t is_number;            ///< a bit for each: all corners are
  /// And for those that are passed counter-clockwise, and clockwise, when each corner moves by the margin. Of thin ones
  /// neither is told.
  std::uint16_t is_up, is_down;
};

/// Bytes that are 0 or 1, one for each facet of a block, as bits.
RHORAY_INLINE std::uint16_t bits_of_block(const std::uint8_t* bytes) {
  unsigned bits = 0;
  for (unsigned i = 0; i < FacetBlock::size; ++i) bits |= static_cast<unsigned>(bytes[i]) << i;
  return static_cast<std::uint16_t>(bits);
}

/// Facets as a light sees them.
class FrontFacing {
 public:
  /// @param blocks  are kept as they are, where they are, for as long as this
  /// @param margin  in the facets' frame: far above what rounding moves places by. Where squares are counted single
  ///                precision takes up to 2^-20 of it (of places up to 4), a quarter of facet_margin; what a kernel may
  ///                see beside a facet is a tenth of what is left
  FrontFacing(Machine machine, const SeenFromLight& seen, double margin, const FacetBlock* blocks, std::size_t count);

  const SeenFromLight& from_light() const { return seen_; }
  std::size_t count() const { return count_; }
  const SeenBlock* blocks() const { return blocks_.get(); }

  /// Over all of them, taken larger by the margin; somewhat smaller than they are.
  const Squares& squares() const { return squares_; }

  /// Of a corner.
  using Place = std::array<float, 2>;
  Place place(std::size_t facet, std::size_t c) const {
    const auto& corner = facets_[facet / FacetBlock::size].corner[c];
    const auto along = [&](int axis) { return corner[axis][facet % FacetBlock::size]; };
    const float w = along(seen_.height_axis());
    return {along(seen_.place_axis(0)) - static_cast<float>(seen_.slope(0)) * w,
            along(seen_.place_axis(1)) - static_cast<float>(seen_.slope(1)) * w};
  }

 private:
  SeenFromLight seen_;
  const FacetBlock* facets_;
  std::size_t count_;
  std::unique_ptr<SeenBlock[]> blocks_;
  Squares squares_;
};

}  // namespace rhoray::render::wide

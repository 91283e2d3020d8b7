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

/// A block of facets projected along the direction of a light, side by side. All in single
/// precision, which moves positions by less than 2^-22.
struct alignas(64) SeenBlock {
  static constexpr std::size_t size = FacetBlock::size;

  float low[2][size], high[2][size];  ///< of the corners' positions
  float lowest[size], highest[size];  ///< height
  float middle[2][size];              ///< a position inside: the middle of the first three corners
  std::uint16_t is_number;            ///< one bit each: all corners are finite
  /// One bit each: the corners are counter-clockwise (up) or clockwise (down), even when each
  /// corner moves by the margin. Thin facets are neither.
  std::uint16_t is_up, is_down;
};

/// Converts bytes that are 0 or 1, one per facet of a block, to bits.
RHORAY_INLINE std::uint16_t bits_of_block(const std::uint8_t* bytes) {
  unsigned bits = 0;
  for (unsigned i = 0; i < FacetBlock::size; ++i) bits |= static_cast<unsigned>(bytes[i]) << i;
  return static_cast<std::uint16_t>(bits);
}

/// Facets projected along the direction of a light.
class FrontFacing {
 public:
  /// @param blocks  not copied: they must outlive this object
  /// @param margin  in the facets' frame: far above the error of positions. Where squares are
  ///   counted, single precision uses up to 2^-20 of it (for positions up to 4), a quarter of
  ///   facet_margin. What a kernel may hit beside a facet is a tenth of the rest
  FrontFacing(Machine machine, const SeenFromLight& seen, double margin, const FacetBlock* blocks, std::size_t count);

  const SeenFromLight& from_light() const { return seen_; }
  std::size_t count() const { return count_; }
  const SeenBlock* blocks() const { return blocks_.get(); }

  /// Squares that cover all facets, enlarged by the margin. A square is somewhat smaller than a
  /// facet.
  const Squares& squares() const { return squares_; }

  /// The position of a corner.
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

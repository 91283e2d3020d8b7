#pragma once

#include <cstdint>
#include <memory>

#include "formats/base/affine.h"
#include "formats/color_grid.h"
#include "render/query/batch.h"
#include "render/query/machine.h"

namespace rhoray::render {

/// What covers the surface at the hits of a group: linear RGB times the share that covers, and that share. All 0:
/// nothing covers it.
struct alignas(64) CoveringColors {
  float red[RayBatch::group_size], green[RayBatch::group_size], blue[RayBatch::group_size], share[RayBatch::group_size];
};

/// CandidateList up a grid of colours at hits; chosen once per frame. The grid must outlive it.
///
/// Between the middles of texels colours are trilinear in linear light, each texel's weighed by its alpha as well; from
/// there to the border of the grid, half a texel further, they are those of the nearest middles. Beyond there is
/// nothing.
class TextureLookup {
 public:
  /// @param world_from_volume  of the volume of which the hits are
  TextureLookup(const formats::ColorGrid& grid, const Affine& world_from_volume, Machine machine = chosen_machine());

  /// For the group of hits that begins at `first`: reads texels for those that are shown and lie in the grid, and for
  /// no others. The same numbers on every machine.
  /// @param shown  of each of the group's rays: above 0 where its hit is shown
  /// @return       for how many hits texels were read
  int operator()(const RayBatch& rays, const HitBatch& hits, std::size_t first, const float* shown,
                 CoveringColors& colors) const {
    int count = 0;
    look_up_(view_, rays, hits, first, shown, colors, count);
    return count;
  }

  /// What kernels read of a grid.
  struct View {
    const std::uint8_t* texels;
    const std::uint64_t *x, *y, *z;  ///< parts of addresses, in texels, of the positions along the axes
    std::int32_t last[3];            ///< position of the last texel
    Affine grid_from_volume;
    const float* linear;  ///< of each 8-bit sRGB component
  };

 private:
  View view_;
  void (*look_up_)(const View& view, const RayBatch& rays, const HitBatch& hits, std::size_t first, const float* shown,
                   CoveringColors& colors, int& count);
};

}  // namespace rhoray::render

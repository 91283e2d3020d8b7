#pragma once

#include <cstdint>
#include <memory>

#include "formats/base/affine.h"
#include "formats/color_grid.h"
#include "render/query/batch.h"
#include "render/query/machine.h"

namespace rhoray::render {

/// Colours that cover a surface at a group's hits: premultiplied linear RGB, and the share that is
/// covered. All 0: not covered.
struct alignas(64) CoveringColors {
  float red[RayBatch::group_size], green[RayBatch::group_size], blue[RayBatch::group_size], share[RayBatch::group_size];
};

/// Looks up a grid of colours at hits; chosen once per frame. The grid must outlive it.
///
/// Between the centres of texels, colours are trilinear in linear light, and each texel is weighted
/// by its alpha, too. From there to the grid's border, half a texel further, the nearest centres
/// are used. Outside the grid nothing is covered.
class TextureLookup {
 public:
  /// @param grid_from_data  from the frame of the dataset that the hits belong to
  TextureLookup(const formats::ColorGrid& grid, const Affine& grid_from_data, Machine machine = chosen_machine());

  /// Handles the group of hits that begins at `first`. Reads texels only for shown hits inside the
  /// grid. The numbers are the same on every machine.
  /// @param shown  for each of the group's rays: above 0 if its hit is shown
  /// @return       number of hits that texels were read for
  int operator()(const RayBatch& rays, const HitBatch& hits, std::size_t first, const float* shown,
                 CoveringColors& colors) const {
    int count = 0;
    look_up_(view_, rays, hits, first, shown, colors, count);
    return count;
  }

  /// The parts of a grid that kernels read.
  struct View {
    const std::uint8_t* texels;
    const std::uint64_t *x, *y, *z;  ///< parts of addresses, in texels, of positions along the axes
    std::int32_t last[3];            ///< index of the last texel
    Affine grid_from_data;
    const float* linear;  ///< linear value of each 8-bit sRGB component
  };

 private:
  View view_;
  void (*look_up_)(const View& view, const RayBatch& rays, const HitBatch& hits, std::size_t first, const float* shown,
                   CoveringColors& colors, int& count);
};

}  // namespace rhoray::render

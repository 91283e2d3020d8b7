#pragma once

#include <span>
#include <vector>

#include "formats/base/affine.h"
#include "render/frame/camera_rays.h"
#include "render/frame/pixel_lattice.h"
#include "render/frame/tiles.h"
#include "render/query/batch.h"
#include "render/query/machine.h"

namespace rhoray::render {

/// The rays of a lattice's pixels, or through places given one by one, in a volume's frame: those of CameraRays, to the
/// last bit and on every machine.
class PixelRays {
 public:
  PixelRays(const CameraRays& camera, const Affine& volume_from_world, const PixelLattice& lattice,
            Machine machine = chosen_machine());

  /// Rays through places of the picture, as CameraRays has them; `fill` makes all of them, whatever the tile.
  /// @param across, down  as many of both; they are read when rays are filled
  PixelRays(const CameraRays& camera, const Affine& volume_from_world, std::span<const double> across,
            std::span<const double> down);

  /// Writes what all rays have in common, once for a batch that is filled again and again. It depends on the camera and
  /// on the volume's frame alone, so that it holds for all rays of a layer in one frame.
  void begin(RayBatch& rays) const;

  /// The rays of a tile's traced blocks, in the order of for_each_run. The batch has room for a tile.
  void fill(const Tile& tile, RayBatch& rays) const;

 private:
  static void fill_inline(const PixelRays& pixels, const Tile& tile, RayBatch& rays);
  void fill_places(RayBatch& rays) const;

  CameraRays camera_;
  Affine volume_from_world_;
  Machine machine_;
  std::vector<double> across_;  ///< by column, and as many more as a run may read beyond the last
  std::vector<double> down_;    ///< by row
  std::span<const double> across_places_, down_places_;  ///< in place of a lattice
};

}  // namespace rhoray::render

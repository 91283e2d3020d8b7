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

/// The rays of a lattice's pixels, or through given picture positions, in a data's frame. They
/// agree with CameraRays to the last bit on every machine.
class PixelRays {
 public:
  PixelRays(const CameraRays& camera, const Affine& data_from_world, const PixelLattice& lattice, Machine machine);

  /// Rays through picture positions in the coordinates of CameraRays. `fill` makes all of them,
  /// whatever the tile.
  /// @param across, down  of equal length; they are read when rays are filled
  PixelRays(const CameraRays& camera, const Affine& data_from_world, std::span<const double> across,
            std::span<const double> down);

  /// Writes the values common to all rays, once for a batch that is filled repeatedly. They depend
  /// only on the camera and on the data's frame, so they hold for all rays of a layer in one
  /// frame.
  void begin(RayBatch& rays) const;

  /// Writes the rays of a tile's traced blocks in the order of for_each_run. The batch must have
  /// room for a tile.
  void fill(const Tile& tile, RayBatch& rays) const;

 private:
  static void fill_inline(const PixelRays& pixels, const Tile& tile, RayBatch& rays);
  void fill_places(RayBatch& rays) const;

  CameraRays camera_;
  Affine data_from_world_;
  Machine machine_;
  /// By column, plus as many as a run may read beyond the last.
  std::vector<double> across_;
  std::vector<double> down_;                             ///< by row
  std::span<const double> across_places_, down_places_;  ///< used instead of a lattice
};

}  // namespace rhoray::render

#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "render/dataset/loaded_dataset.h"
#include "render/frame/clip_region.h"
#include "render/frame/pixel_rays.h"
#include "render/frame/pixels.h"
#include "render/frame/slices.h"
#include "render/frame/tiles.h"
#include "render/frame/worker.h"
#include "render/query/intersectors.h"
#include "render/render.h"
#include "render/shadow/occluders.h"

namespace rhoray::render {

/// How a layer is composited with the others of a frame.
enum class Blend {
  opaque,       ///< hides everything behind it
  transparent,  ///< other surfaces are seen through it, in their order along the ray
  additive      ///< MIP among surfaces: its light is added, up to the nearest opaque surface
};

/// One layer: its data, its kernels and its shading.
struct FrameLayer {
  const LoadedDataset& dataset;
  Blend blend;
  RayQuery query;
  Intersectors intersectors;
  Kernel kernel;  ///< the one of them for rays from the camera
  /// For rays that start at hits: behind transparent surfaces, or towards lights.
  RayQuery continuation_query;
  std::optional<Intersectors> continuation;  ///< none: there are no such rays
  LayerShading shading;
  Affine data_from_world;
  std::optional<SurfaceBoxes> boxes{};        ///< nothing is hit outside them; none: not known
  std::shared_ptr<const SlicePlane> slice{};  ///< intersected instead of calling kernels
  bool clipped = false;                       ///< Frame::clip shortens its rays
  /// For each light, the parts of this layer that may occlude hits on the same dataset; null: all
  /// of it may. Empty for a clipped layer.
  std::vector<std::shared_ptr<const wide::LightOccluders>> occluders{};
};

/// Transparent surfaces of one dataset whose crossings one walk along each ray finds.
struct AllHitsGroup {
  AllHitsKernel kernel;
  std::vector<std::uint8_t> layers;  ///< indices into Frame::layers
  std::vector<TransparentSurface> surfaces;
  bool only_places = true;  ///< as in AllHitsQuery
};

/// Everything chosen once for a frame; constant while tiles are traced.
struct Frame {
  /// Opaque, then transparent, then additive layers. Slices come before others; otherwise the
  /// scene's order is kept.
  std::vector<FrameLayer> layers;
  /// Contains all transparent layers; empty: crossings are found one by one.
  std::vector<AllHitsGroup> all_hits_groups{};
  CameraRays camera_rays;
  std::optional<ClipRegion> clip;  ///< of the layers with FrameLayer::clipped
  Vec3 background;                 ///< black if nothing is behind
  bool has_transparent_background;
  bool keeps_channels;  ///< besides the colour
  PixelRect window;     ///< tiles outside are not traced; may extend beyond the picture
  Occlusion occlusion;
  WorkerNeeds needs;
  Machine machine = Machine::scalar;  ///< of all kernels and loops
  std::stop_token stop{};             ///< also ends the search for occluders in a tile
  RangeProof range_proof{};           ///< of the datasets with a method that proves its answers
  /// For each pixel the layer of its first surface; null: not needed.
  std::uint8_t* first_layers = nullptr;

  bool has_one_layer() const { return layers.size() == 1 && layers.front().blend == Blend::opaque; }
};

/// The rays of a lattice's pixels, and which blocks of them may meet something.
struct LatticeRays {
  PixelLattice lattice;
  std::vector<PixelRays> of_layers;
  std::optional<PixelRays> in_world{};  ///< if WorkerNeeds::world_rays is set
};

}  // namespace rhoray::render

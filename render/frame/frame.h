#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/dataset/volume.h"
#include "render/frame/clip_region.h"
#include "render/frame/pixel_rays.h"
#include "render/frame/pixels.h"
#include "render/frame/slices.h"
#include "render/frame/tiles.h"
#include "render/frame/worker.h"
#include "render/query/kernels.h"
#include "render/query/ordered_crossings.h"
#include "render/render.h"
#include "render/shadow/occluders.h"

namespace rhoray::render {

/// How a layer lies among the others of a frame.
enum class Part {
  opaque,  ///< what is nearest hides what is behind
  clear,   ///< a surface through which others are seen, in their order along the ray
  veil     ///< largest values among surfaces: light over what is behind, up to the nearest opaque one
};

/// What one layer asks of the rays, and how it looks.
struct FrameLayer {
  const VolumeImplementation& volume;
  Part part;
  Kernel kernel;
  Kernel kernel_through;  ///< for rays that start in crossings, those of clear surfaces or of light; null: not asked
  Preparation prepare;    ///< null: nothing to prepare
  Question question, question_through;
  Look look;
  Affine volume_from_world;
  std::optional<SurfaceBoxes> boxes{};        ///< nothing is met outside them; none: not known
  std::shared_ptr<const SlicePlane> slice{};  ///< asked in the place of kernels
  bool clipped = false;                       ///< its rays end where Frame::clip ends them
  wide::AnyCrossing any_crossing = nullptr;   ///< as kernel_through, where no more is asked; null: that answers
  /// By light, what of this layer may hold it back from hits of the same volume; null where not known to be less than
  /// all. None of a layer that is clipped.
  std::vector<std::shared_ptr<const wide::LightBlockers>> blockers{};
};

/// Clear surfaces of one volume whose crossings are found by one walk along each ray.
struct ShellGroup {
  CrossingsKernel kernel;
  std::vector<std::uint8_t> layers;  ///< by their place in the frame
  std::vector<CrossedSurface> surfaces;
  bool only_places = true;  ///< as CrossingsQuestion has it
};

/// What was chosen once for the frame; nothing here changes while tiles are traced.
struct Frame {
  /// Opaque ones first, then clear ones, then veils, slices before others; else as the scene has them.
  std::vector<FrameLayer> layers;
  std::vector<ShellGroup> shells{};  ///< of all clear layers; none: these are asked about crossing by crossing
  CameraRays camera_rays;
  std::optional<ClipRegion> clip;  ///< of the layers that it takes something away of
  Vec3 background;
  bool keeps_channels;  ///< beside the colour
  Occlusion occlusion;
  WorkerNeeds needs;
  RangeProof range_proof{};              ///< of the volumes of which answers are proven
  std::uint8_t* first_layers = nullptr;  ///< of every pixel the layer of its first surface; null: not asked

  bool has_one_layer() const { return layers.size() == 1 && layers.front().part == Part::opaque; }
};

/// The rays of a lattice's pixels, and which blocks of them may meet something.
struct LatticeRays {
  PixelLattice lattice;
  std::vector<PixelRays> of_layers;
  std::optional<PixelRays> in_world{};  ///< where WorkerNeeds::world_rays are asked for
};

}  // namespace rhoray::render

#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "render/kernels/kernels.h"
#include "render/kernels/wide/blocker_heights.h"
#include "render/kernels/wide/facet_blockers.h"

namespace rhoray::render::wide {

/// What of one isosurface may hold back the light of rays of one start side.
struct Blockers {
  std::optional<BlockerHeights> heights;             ///< where the light stands in one direction
  std::shared_ptr<const FacetBlockers> facets = {};  ///< of a mesh
};

/// Any crossing: whether there is one. A bit for each ray of each group of the batch, those whose t_max is below their
/// t_min left clear.
///
/// @param blockers  null: the whole surface is asked about; else all rays are of that side and go to that light
using AnyCrossing = void (*)(const VolumeImplementation& volume, const Question& question, const Blockers* blockers,
                             const RayBatch& rays, std::uint64_t* crossed, KernelScratch& scratch);

/// The kernel of meshes' isosurfaces, or of surfaces, in single precision; null where first_facet_kernel is.
AnyCrossing any_facet_kernel(const VolumeImplementation& volume, const Method& method, Machine machine);

/// What of a mesh's isosurface may hold back light on the way to a light from hits that lie on one side: outside,
/// inside. Null where that is not known to be less than all: of triangles, which may face any way, and where scalar
/// kernels answer.
std::array<std::shared_ptr<const Blockers>, 2> facet_blockers_of(const VolumeImplementation& volume,
                                                                 const Question& question, const LightPlace& light,
                                                                 unsigned threads);

}  // namespace rhoray::render::wide

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "render/query/kernels.h"
#include "render/shadow/facet_occluders.h"
#include "render/shadow/occluder_heights.h"

namespace rhoray::render::wide {

/// The parts of one isosurface that may occlude rays with one start side.
struct Occluders {
  std::optional<OccluderHeights> heights;             ///< for a directional light
  std::shared_ptr<const FacetOccluders> facets = {};  ///< for a mesh
};

/// The same for one light, computed at the first request for a side. Any thread may call.
class LightOccluders {
 public:
  using Find = std::function<Occluders(StartSide)>;
  explicit LightOccluders(Find find) : find_(std::move(find)) {}

  /// @param side  not unknown
  const Occluders& of(StartSide side) const {
    OfSide& asked = sides_[side == StartSide::inside];
    std::call_once(asked.once, [&] { asked.found = find_(side); });
    return asked.found;
  }

 private:
  struct OfSide {
    std::once_flag once;
    Occluders found;
  };
  Find find_;
  mutable std::array<OfSide, 2> sides_;
};

/// Any-hit query: whether there is any crossing. Sets one bit for each ray of each group of the
/// batch; rays with t_max < t_min keep a clear bit.
///
/// @param occluders  null: the whole surface is tested; else all rays have their start side and go
///   to their light
using AnyCrossing = void (*)(const VolumeImplementation& volume, const RayQuery& query, const Occluders* occluders,
                             const RayBatch& rays, std::uint64_t* crossed, KernelScratch& scratch);

/// Returns the single-precision kernel for meshes' isosurfaces, or for surfaces; null where
/// first_facet_kernel is null.
AnyCrossing any_facet_kernel(const VolumeImplementation& volume, const Method& method, Machine machine);

/// Returns the facets of a mesh's isosurface if only some of them may occlude hits on one of its
/// sides. Null where that is not known: for triangles, which may have any orientation, and where
/// scalar kernels are used.
std::shared_ptr<const Facets> facets_with_occluders(const VolumeImplementation& volume, const RayQuery& query,
                                                    unsigned threads);

/// Returns those that may occlude rays to a light.
/// @param shadows  known: the facets' neighbours are computed, once for all lights
std::shared_ptr<const LightOccluders> facet_occluders_of(Machine machine, std::shared_ptr<const Facets> facets,
                                                         const LightPlace& light, Shadows shadows);

/// Returns the same with known shadows.
/// @param before  for a light without them
std::shared_ptr<const LightOccluders> with_shadows(Machine machine, std::shared_ptr<const LightOccluders> before,
                                                   const LightPlace& light);

}  // namespace rhoray::render::wide

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

/// What of one isosurface may hold back the light of rays of one start side.
struct Occluders {
  std::optional<OccluderHeights> heights;             ///< where the light stands in one direction
  std::shared_ptr<const FacetOccluders> facets = {};  ///< of a mesh
};

/// The same for one light, found when rays of a side are first asked about. Any thread may ask.
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

/// Any crossing: whether there is one. A bit for each ray of each group of the batch, those whose t_max is below their
/// t_min left clear.
///
/// @param blockers  null: the whole surface is asked about; else all rays are of that side and go to that light
using AnyCrossing = void (*)(const VolumeImplementation& volume, const RayQuery& query, const Occluders* occluders,
                             const RayBatch& rays, std::uint64_t* crossed, KernelScratch& scratch);

/// The kernel of meshes' isosurfaces, or of surfaces, in single precision; null where first_facet_kernel is.
AnyCrossing any_facet_kernel(const VolumeImplementation& volume, const Method& method, Machine machine);

/// The facets of a mesh's isosurface, of which fewer than all may hold back light from hits that lie on one side of it.
/// Null where that is not known: of triangles, which may face any way, and where scalar kernels answer.
std::shared_ptr<const Facets> facets_with_occluders(const VolumeImplementation& volume, const RayQuery& query,
                                                    unsigned threads);

/// What of them may hold back light on the way to a light.
/// @param shadows  known: the facets' neighbours are found, once for all lights
std::shared_ptr<const LightOccluders> facet_occluders_of(Machine machine, std::shared_ptr<const Facets> facets,
                                                         const LightPlace& light, Shadows shadows);

/// The same with shadows that are known.
/// @param before  of a light for which they are not
std::shared_ptr<const LightOccluders> with_shadows(Machine machine, std::shared_ptr<const LightOccluders> before,
                                                   const LightPlace& light);

}  // namespace rhoray::render::wide

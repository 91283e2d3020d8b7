#pragma once

#include <memory>

#include "render/kernels/kernels.h"
#include "render/volumes/facets.h"

namespace rhoray::render::wide {

/// Where rays to a light go, in a volume's frame: towards a direction, or to a place; each of them no farther from it
/// than `reach`.
struct LightPlace {
  bool is_place = false;
  Vec3 at{0, 0, 0};
  double reach = 0;
};

/// The facets of a mesh's isosurface that may hold back light which rays of one start side ask about. Sides take turns
/// along a ray: one that starts below the isovalue first meets a facet through which the field rises along it, so of
/// all facets those through which it falls on every way to the light hold nothing back. These are half of most
/// surfaces, and the half on which the rays start.
///
/// Facets are left out block by block: what is asked about a kept block are its other facets too, which the kernel
/// refuses by their sides.
class FacetBlockers {
 public:
  /// @param side  inside or outside
  FacetBlockers(std::shared_ptr<const Facets> facets, const LightPlace& light, StartSide side, unsigned threads);

  const Facets& facets() const { return *facets_; }
  /// As Facets::levels, the boxes of the blocks left out empty.
  const BoxLevels& levels() const { return levels_; }

 private:
  std::shared_ptr<const Facets> facets_;
  BoxLevels levels_;
};

/// First crossings of the facets that are left: those of Facets for all rays of that side towards that light.
using BlockerKernel = void (*)(const VolumeImplementation& volume, const Question& question,
                               const FacetBlockers& blockers, const RayBatch& rays, HitBatch& hits,
                               KernelScratch& scratch);

/// The kernel of meshes' isosurfaces in single precision, asked about blockers; null where first_facet_kernel is, and
/// for triangles, which may face any way.
BlockerKernel blocker_kernel(const VolumeImplementation& volume, const Method& method, Machine machine);

/// The blockers of a question that blocker_kernel answers; null where it is answered by scalar kernels after all.
std::shared_ptr<const FacetBlockers> blockers_of(const VolumeImplementation& volume, const Question& question,
                                                 const LightPlace& light, StartSide side, unsigned threads);

}  // namespace rhoray::render::wide

#pragma once

#include "render/query/all_hits.h"
#include "render/query/kernels.h"

namespace rhoray::render::wide {

/// The first crossing of a mesh's isosurface, or of a surface's triangles, for groups of rays at once, by the facets
/// that the surface is made of (volumes/facets.h); null where the scalar kernels answer: for other volumes, for meshes
/// of a size or with values that products of doubles cannot hold, and for ways other than those of the table in
/// README.md.
Kernel first_facet_kernel(const VolumeImplementation& volume, const Method& method, Machine machine);

/// Makes the facets of an isovalue, if they are not kept from before.
/// @return  the boxes around them; none where the scalar kernels answer
std::optional<SurfaceBoxes> prepare_facets(const VolumeImplementation& volume, const RayQuery& query, unsigned threads);

/// All crossings of isosurfaces of a mesh; null where there is no such kernel, as for triangles, which may face any
/// way.
AllHitsKernel facet_all_hits_kernel(const VolumeImplementation& volume, const RayQuery& query, Machine machine);

}  // namespace rhoray::render::wide

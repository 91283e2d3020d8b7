#pragma once

#include "render/query/all_hits.h"
#include "render/query/kernels.h"

namespace rhoray::render::wide {

/// Returns the kernel that finds the first crossing of a mesh's isosurface, or of a surface's
/// triangles, for groups of rays at once. It uses the facets that make up the surface
/// (render/triangles/facets.h). Null where the scalar kernels are used: for other volumes, for
/// meshes whose size or values exceed what products of doubles can hold, and for methods other than
/// those of the table in render/KERNELS.md.
Kernel first_facet_kernel(const VolumeImplementation& volume, const Method& method, Machine machine);

/// Computes the facets of an isovalue, unless they are cached.
/// @return  the boxes around them; nothing where the scalar kernels are used
std::optional<SurfaceBoxes> prepare_facets(const VolumeImplementation& volume, const RayQuery& query, unsigned threads);

/// Returns the kernel that finds all crossings of isosurfaces of a mesh. Null where there is none,
/// as for triangles, which may have any orientation.
AllHitsKernel facet_all_hits_kernel(const VolumeImplementation& volume, const RayQuery& query, Machine machine);

}  // namespace rhoray::render::wide

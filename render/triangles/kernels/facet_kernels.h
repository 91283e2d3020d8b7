#pragma once

#include <memory>
#include <stop_token>

#include "render/query/intersectors.h"
#include "render/triangles/facets.h"

namespace rhoray::render::wide {

/// Puts the SIMD kernels for a mesh's isosurface, or for a surface's triangles, in the place of
/// others. They use the facets that make up the surface (render/triangles/facets.h). Leaves the
/// intersectors as they are where the scalar kernels are used: for meshes whose size or values
/// exceed what products of doubles can hold, and for methods other than those of the table in
/// render/KERNELS.md. There is no kernel for all hits of triangles, which may have any orientation.
void use_facets(const LoadedDataset& dataset, const RayQuery& query, Machine machine, Intersectors& found);

/// Returns the facets of a mesh's isosurface if only some of them may occlude hits on one of its
/// sides. Null where that is not known: for triangles, which may have any orientation, and where
/// scalar kernels are used.
/// @param stop  ends their preparation (ErrorCode::interrupted)
std::shared_ptr<const Facets> facets_with_occluders(const LoadedDataset& dataset, const RayQuery& query,
                                                    unsigned threads, const std::stop_token& stop = {});

}  // namespace rhoray::render::wide

#pragma once

#include <cstdint>
#include <vector>

#include "tools/lab/structures/plain_mesh.h"

/// Orders of a mesh's cells: order[n] is the cell that comes n-th.
namespace rhoray::study {

/// By halves, as packing leaves them.
std::vector<std::uint32_t> as_they_stand(const PlainMesh& mesh);
std::vector<std::uint32_t> as_made(const PlainMesh& mesh);   ///< as in the source
std::vector<std::uint32_t> shuffled(const PlainMesh& mesh);  ///< the same for the same count

/// Along curves through the cell centres in 2^21 steps of the mesh's longest edge. Morton
/// interleaves the bits of x, y and z; the other is Hilbert's curve.
std::vector<std::uint32_t> by_morton(const PlainMesh& mesh);
std::vector<std::uint32_t> by_hilbert(const PlainMesh& mesh);

}  // namespace rhoray::study

#pragma once

#include <cstdint>
#include <vector>

#include "tools/study/structures/plain_mesh.h"

/// Orders of a mesh's cells: order[n] is the cell that comes n-th.
namespace rhoray::study {

std::vector<std::uint32_t> as_they_stand(const PlainMesh& mesh);  ///< along Hilbert's curve, as packing leaves them
std::vector<std::uint32_t> as_made(const PlainMesh& mesh);        ///< as in the source
std::vector<std::uint32_t> shuffled(const PlainMesh& mesh);       ///< the same for the same count

/// Along a curve through the middles in 2^21 steps an axis: bits of x, y and z in turn.
std::vector<std::uint32_t> by_morton(const PlainMesh& mesh);

/// Halved again and again across the longest axis of the middles, at multiples of the largest power of two that fits:
/// so that eight neighbours in the order, eight times eight and so on, are what halving has left together.
std::vector<std::uint32_t> by_halves(const PlainMesh& mesh);

}  // namespace rhoray::study

#pragma once

#include "render/query/batch_arrays.h"

namespace rhoray::render::wide {

/// Finds out with another kernel, one for first crossings, which of the `chosen` rays have any
/// crossing (bit r: ray first + r).
/// @return  a bit for each of these rays that has one
inline std::uint64_t ask_whether_any(Kernel kernel, const VolumeImplementation& volume, const RayQuery& query,
                                     const RayBatch& rays, std::size_t first, std::uint64_t chosen, FewRays& few,
                                     KernelScratch& scratch) {
  few.rays.has_start_sides = rays.has_start_sides;
  few.rays.count = 0;
  for (std::uint64_t bits = chosen; bits != 0; bits &= bits - 1)
    few.rays.set(few.rays.count++, rays[first + static_cast<std::size_t>(std::countr_zero(bits))]);
  scratch.counters.rays_wide -= few.rays.count;
  kernel(volume, query, few.rays, few.hits, scratch);
  std::uint64_t crossed = 0;
  std::size_t place = 0;
  for (std::uint64_t bits = chosen; bits != 0; bits &= bits - 1)
    if (few.hits.t[place++] < std::numeric_limits<double>::infinity()) crossed |= bits & (~bits + 1);
  return crossed;
}

}  // namespace rhoray::render::wide

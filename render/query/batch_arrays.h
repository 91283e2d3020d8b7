#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "render/query/kernels.h"
#include "render/traverse/ray_group.h"

/// Batches as plain arrays, for the code that is compiled once per machine, and rays of a batch
/// that are traced again.
namespace rhoray::render::wide {

/// A batch's answers as plain arrays.
struct HitArrays {
  double *t, *value, *error, *gradient[3];
  std::uint64_t* cell;
  std::uint32_t *tet, *root_count, *iteration_count, *cost;
};

inline HitArrays arrays_of(const HitBatch& hits) {
  return {.t = hits.t.data(),
          .value = hits.value.data(),
          .error = hits.error.data(),
          .gradient = {hits.gradient[0].data(), hits.gradient[1].data(), hits.gradient[2].data()},
          .cell = hits.cell.data(),
          .tet = hits.tet.data(),
          .root_count = hits.root_count.data(),
          .iteration_count = hits.iteration_count.data(),
          .cost = hits.cost.data()};
}

RHORAY_INLINE HitArrays from(const HitArrays& hits, std::size_t first) {
  return {.t = hits.t + first,
          .value = hits.value + first,
          .error = hits.error + first,
          .gradient = {hits.gradient[0] + first, hits.gradient[1] + first, hits.gradient[2] + first},
          .cell = hits.cell + first,
          .tet = hits.tet + first,
          .root_count = hits.root_count + first,
          .iteration_count = hits.iteration_count + first,
          .cost = hits.cost + first};
}

/// Writes misses, all but the cost.
inline void write_misses_alone(const HitArrays& hits, std::size_t count) {
  std::fill_n(hits.t, count, std::numeric_limits<double>::infinity());
  std::fill_n(hits.error, count, std::numeric_limits<double>::quiet_NaN());
  std::fill_n(hits.value, count, 0.0);
  for (double* component : hits.gradient) std::fill_n(component, count, 0.0);
  std::fill_n(hits.cell, count, std::uint64_t{0});
  for (std::uint32_t* numbers : {hits.tet, hits.root_count, hits.iteration_count}) std::fill_n(numbers, count, 0u);
}

inline void write_misses(const HitArrays& hits, std::size_t count) {
  write_misses_alone(hits, count);
  std::fill_n(hits.cost, count, 0u);
}

/// Writes misses for all but some of at most 64 rays.
/// @param hit  bit r set: ray r is left as it is
inline void write_other_misses(const HitArrays& hits, std::size_t count, std::uint64_t hit) {
  constexpr std::size_t few = 8;
  for (std::size_t first = 0; first < count; first += few) {
    const std::uint64_t hit_here = hit >> first & 0xff;
    const std::size_t end = std::min(first + few, count);
    if (hit_here == 0)
      write_misses_alone(from(hits, first), end - first);
    else if (hit_here != 0xff)
      for (std::size_t r = first; r < end; ++r)
        if ((hit >> r & 1) == 0) write_misses_alone(from(hits, r), 1);
  }
}

inline RayArrays arrays_of(const RayBatch& rays) {
  return {.origin = {rays.origin[0].data(), rays.origin[1].data(), rays.origin[2].data()},
          .direction = {rays.direction[0].data(), rays.direction[1].data(), rays.direction[2].data()},
          .t_min = rays.t_min.data(),
          .t_max = rays.t_max.data(),
          .start_side = rays.has_start_sides ? rays.start_side.data() : nullptr};
}

RHORAY_INLINE RayArrays from(const RayArrays& rays, std::size_t first) {
  RayArrays rest{.origin = {},
                 .direction = {},
                 .t_min = rays.t_min + first,
                 .t_max = rays.t_max + first,
                 .start_side = rays.start_side != nullptr ? rays.start_side + first : nullptr};
  for (int a = 0; a < 3; ++a) rest.origin[a] = rays.origin[a] + first, rest.direction[a] = rays.direction[a] + first;
  return rest;
}

inline RayArrays from(const RayBatch& rays, std::size_t first) {
  return from(arrays_of(rays), first);
}

/// A few rays of a batch and their hits.
struct FewRays {
  RayBatch rays{RayGroup::size};
  HitBatch hits{RayGroup::size};
};

/// Traces the `chosen` rays (bit r: ray first + r) with another kernel and overwrites their hits.
inline void ask_again(Kernel kernel, const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays,
                      std::size_t first, std::uint64_t chosen, HitBatch& hits, FewRays& few, KernelScratch& scratch) {
  const auto for_each_chosen = [&](auto&& act) {
    std::size_t place = 0;
    for (std::uint64_t bits = chosen; bits != 0; bits &= bits - 1)
      act(first + static_cast<std::size_t>(std::countr_zero(bits)), place++);
  };
  few.rays.has_start_sides = rays.has_start_sides;
  few.rays.count = static_cast<std::size_t>(std::popcount(chosen));
  scratch.counters.rays_wide -= few.rays.count;
  for_each_chosen([&](std::size_t r, std::size_t place) { few.rays.set(place, rays[r]); });
  kernel(dataset, query, few.rays, few.hits, scratch);
  for_each_chosen([&](std::size_t r, std::size_t place) { hits.set(r, few.hits[place]); });
}

}  // namespace rhoray::render::wide

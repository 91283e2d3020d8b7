#pragma once

#include "render/grid/reference/certified.h"
#include "render/grid/reference/crossing.h"
#include "render/grid/reference/exact.h"
#include "render/grid/reference/largest.h"
#include "render/grid/reference/sampled.h"
#include "render/query/kernel_of.h"

/// The reference kernels of a grid. The sources in this folder instantiate them, some views each.
namespace rhoray::render {

template <class View>
ReferenceKernels reference_kernels(const View& view, Method::Algorithm algorithm) {
  return {.first_hit = kernel_for<View, first_crossing_of_ray<View>, sampled_crossing_of_ray<View>,
                                  certified_first_crossing<View>, exact_first_hit<View>>(algorithm),
          .largest = kernel_for<View, largest_value_on_ray<View>, sampled_maximum_on_ray<View>,
                                certified_largest_value<View>, exact_largest_hit<View>>(algorithm),
          .queue_entries = largest_queue_size(view.lattice(), view.level_count())};
}

template <class View>
void resume_certified(const View& view, const RayQuery& query, const RayBatch& rays, std::span<const ResumedAt> from,
                      HitBatch& hits, KernelScratch& scratch) {
  for (std::size_t r = 0; r < rays.count; ++r) {
    const std::uint64_t before = scratch.counters.visits();
    Hit hit = certified_first_crossing_redone(view, query, rays[r], scratch, from[r]);
    hit.cost = static_cast<std::uint32_t>(scratch.counters.visits() - before);
    hits.set(r, hit);
  }
}

}  // namespace rhoray::render

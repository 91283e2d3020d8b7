#include "render/grid/reference/certified.h"
#include "render/grid/reference/crossing.h"
#include "render/grid/reference/exact.h"
#include "render/grid/reference/largest.h"
#include "render/grid/reference/resumed.h"
#include "render/grid/reference/sampled.h"
#include "render/query/kernel_of.h"

namespace rhoray::render {

template <class View>
ReferenceKernels reference_kernels(const View& view, Method::Algorithm algorithm) {
  return {.first_hit = kernel_for<View, first_crossing_of_ray<View>, sampled_crossing_of_ray<GridSampler<View>>,
                                  certified_first_crossing<View>, exact_first_hit<View>>(algorithm),
          .largest = kernel_for<View, largest_value_on_ray<View>, sampled_maximum_on_ray<GridSampler<View>>,
                                certified_largest_value<View>, exact_largest_hit<View>>(algorithm),
          .queue_entries = largest_queue_size(view.lattice(), view.level_count())};
}

template ReferenceKernels reference_kernels(const UniformGrid&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearGrid&, Method::Algorithm);

void resume_certified(const UniformGrid& view, const RayQuery& query, const RayBatch& rays,
                      std::span<const ResumedAt> from, HitBatch& hits, KernelScratch& scratch) {
  answer_each(rays, hits, scratch, [&](const Ray& ray, std::size_t r) {
    return certified_first_crossing_redone(view, query, ray, scratch, from[r]);
  });
}

}  // namespace rhoray::render

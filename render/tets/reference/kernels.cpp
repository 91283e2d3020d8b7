#include "render/tets/reference/kernels.h"

#include "render/query/kernel_of.h"
#include "render/tets/reference/certified.h"
#include "render/tets/reference/crossing.h"
#include "render/tets/reference/exact.h"
#include "render/tets/reference/largest.h"
#include "render/tets/reference/sampled.h"

namespace rhoray::render {

template <>
ReferenceKernels reference_kernels(const TetData& view, Method::Algorithm algorithm) {
  return {.first_hit = kernel_for<TetData, first_crossing_of_ray<TetData>, sampled_crossing_of_ray<TetSampler<TetData>>,
                                  certified_first_crossing<TetData>, exact_first_hit<TetData>>(algorithm),
          .largest = kernel_for<TetData, largest_value_on_ray<TetData>, sampled_maximum_on_ray<TetSampler<TetData>>,
                                certified_largest_value<TetData>, exact_largest_hit<TetData>>(algorithm),
          .queue_entries = queue_size_for(view)};
}

Kernel redoing_kernel() {
  return kernel_of<TetData, certified_first_crossing_redone<TetData>>;
}

}  // namespace rhoray::render

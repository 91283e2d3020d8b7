#include "render/tets/reference/kernels.h"

#include "render/query/kernel_of.h"
#include "render/tets/reference/certified.h"
#include "render/tets/reference/crossing.h"
#include "render/tets/reference/exact.h"
#include "render/tets/reference/largest.h"
#include "render/tets/reference/sampled.h"

namespace rhoray::render {

template <class View>
ReferenceKernels reference_kernels(const View& view, Method::Algorithm algorithm) {
  return {.first_hit = kernel_for<View, first_crossing_of_ray<View>, sampled_crossing_of_ray<View>,
                                  certified_first_crossing<View>, exact_first_hit<View>>(algorithm),
          .largest = kernel_for<View, largest_value_on_ray<View>, sampled_maximum_on_ray<View>,
                                certified_largest_value<View>, exact_largest_hit<View>>(algorithm),
          .queue_entries = queue_size_for(view)};
}

template <class View>
Kernel redoing_kernel(const View&) {
  return kernel_of<View, certified_first_crossing_redone<View>>;
}

template ReferenceKernels reference_kernels(const TetData<float>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const TetData<double>&, Method::Algorithm);
template Kernel redoing_kernel(const TetData<float>&);
template Kernel redoing_kernel(const TetData<double>&);

}  // namespace rhoray::render

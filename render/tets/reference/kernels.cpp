#include "render/query/kernel_of.h"
#include "render/tets/reference/certified.h"
#include "render/tets/reference/crossing.h"
#include "render/tets/reference/exact.h"
#include "render/tets/reference/largest.h"
#include "render/tets/reference/sampled.h"

namespace rhoray::render {

template <class View>
Kernels kernels_for(const View& view, Method::Algorithm algorithm) {
  return {.first_crossing = kernel_for<View, first_crossing_of_ray<View>, sampled_crossing_of_ray<View>,
                                       certified_first_crossing<View>, exact_first_hit<View>>(algorithm),
          .largest_value = kernel_for<View, largest_value_on_ray<View>, sampled_maximum_on_ray<View>,
                                      certified_largest_value<View>, exact_largest_hit<View>>(algorithm),
          .queue_entries = queue_size_for(view)};
}

template <class View>
Kernel redoing_kernel_for(const View&) {
  return kernel_of<View, certified_first_crossing_redone<View>>;
}

template Kernels kernels_for(const TetVolume<float>&, Method::Algorithm);
template Kernels kernels_for(const TetVolume<double>&, Method::Algorithm);
template Kernel redoing_kernel_for(const TetVolume<float>&);
template Kernel redoing_kernel_for(const TetVolume<double>&);

}  // namespace rhoray::render

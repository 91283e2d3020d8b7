#include "render/kernels/grid_kernels.h"

namespace rhoray::render {

template Kernels kernels_for(const SparseVolume<float>&, Method::Way);
template Kernels kernels_for(const SparseVolume<double>&, Method::Way);
template Kernels kernels_for(const SparseRectilinearVolume<float>&, Method::Way);
template Kernels kernels_for(const SparseRectilinearVolume<double>&, Method::Way);

}  // namespace rhoray::render

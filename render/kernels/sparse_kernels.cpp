#include "render/kernels/grid_kernels.h"

namespace rhoray::render {

template Kernels kernels_for(const SparseVolume<float>&, MipMethod, bool);
template Kernels kernels_for(const SparseVolume<double>&, MipMethod, bool);
template Kernels kernels_for(const SparseRectilinearVolume<float>&, MipMethod, bool);
template Kernels kernels_for(const SparseRectilinearVolume<double>&, MipMethod, bool);

}  // namespace rhoray::render

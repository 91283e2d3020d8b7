#include "render/grid/reference/kernels.h"

namespace rhoray::render {

template Kernels kernels_for(const SparseVolume<float>&, Method::Way);
template Kernels kernels_for(const SparseVolume<double>&, Method::Way);
template Kernels kernels_for(const SparseRectilinearVolume<float>&, Method::Way);
template Kernels kernels_for(const SparseRectilinearVolume<double>&, Method::Way);

template void resume_certified(const SparseVolume<float>&, const Question&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);
template void resume_certified(const SparseVolume<double>&, const Question&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);

}  // namespace rhoray::render

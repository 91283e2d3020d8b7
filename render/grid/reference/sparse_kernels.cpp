#include "render/grid/reference/kernels.h"

namespace rhoray::render {

template Kernels kernels_for(const SparseVolume<float>&, Method::Algorithm);
template Kernels kernels_for(const SparseVolume<double>&, Method::Algorithm);
template Kernels kernels_for(const SparseRectilinearVolume<float>&, Method::Algorithm);
template Kernels kernels_for(const SparseRectilinearVolume<double>&, Method::Algorithm);

template void resume_certified(const SparseVolume<float>&, const RayQuery&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);
template void resume_certified(const SparseVolume<double>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);

}  // namespace rhoray::render

#include "render/grid/reference/kernels.h"

namespace rhoray::render {

template ReferenceKernels reference_kernels(const SparseVolume<float>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const SparseVolume<double>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const SparseRectilinearVolume<float>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const SparseRectilinearVolume<double>&, Method::Algorithm);

template void resume_certified(const SparseVolume<float>&, const RayQuery&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);
template void resume_certified(const SparseVolume<double>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);

}  // namespace rhoray::render

#include "render/grid/reference/kernels.h"

namespace rhoray::render {

template ReferenceKernels reference_kernels(const SparseGridData<float>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const SparseGridData<double>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const SparseRectilinearGridData<float>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const SparseRectilinearGridData<double>&, Method::Algorithm);

template void resume_certified(const SparseGridData<float>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const SparseGridData<double>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);

}  // namespace rhoray::render

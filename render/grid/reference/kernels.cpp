#include "render/grid/reference/kernels.h"

namespace rhoray::render {

template ReferenceKernels reference_kernels(const GridData<std::uint8_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridData<std::int8_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridData<std::uint16_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridData<std::int16_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridData<std::uint32_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridData<std::int32_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridData<float>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridData<double>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const NanoVdbData&, Method::Algorithm);

template void resume_certified(const GridData<std::uint8_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridData<std::int8_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridData<std::uint16_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridData<std::int16_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridData<std::uint32_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridData<std::int32_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridData<float>&, const RayQuery&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);
template void resume_certified(const GridData<double>&, const RayQuery&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);
template void resume_certified(const NanoVdbData&, const RayQuery&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);

}  // namespace rhoray::render

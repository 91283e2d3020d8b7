#include "render/grid/reference/kernels.h"

namespace rhoray::render {

template ReferenceKernels reference_kernels(const GridVolume<std::uint8_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridVolume<std::int8_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridVolume<std::uint16_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridVolume<std::int16_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridVolume<std::uint32_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridVolume<std::int32_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridVolume<float>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const GridVolume<double>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const NanoVdbVolume&, Method::Algorithm);

template void resume_certified(const GridVolume<std::uint8_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::int8_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::uint16_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::int16_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::uint32_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::int32_t>&, const RayQuery&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<float>&, const RayQuery&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<double>&, const RayQuery&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);
template void resume_certified(const NanoVdbVolume&, const RayQuery&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);

}  // namespace rhoray::render

#include "render/grid/reference/kernels.h"

namespace rhoray::render {

template Kernels kernels_for(const GridVolume<std::uint8_t>&, Method::Way);
template Kernels kernels_for(const GridVolume<std::int8_t>&, Method::Way);
template Kernels kernels_for(const GridVolume<std::uint16_t>&, Method::Way);
template Kernels kernels_for(const GridVolume<std::int16_t>&, Method::Way);
template Kernels kernels_for(const GridVolume<std::uint32_t>&, Method::Way);
template Kernels kernels_for(const GridVolume<std::int32_t>&, Method::Way);
template Kernels kernels_for(const GridVolume<float>&, Method::Way);
template Kernels kernels_for(const GridVolume<double>&, Method::Way);
template Kernels kernels_for(const NanoVdbVolume&, Method::Way);

template void resume_certified(const GridVolume<std::uint8_t>&, const Question&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::int8_t>&, const Question&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::uint16_t>&, const Question&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::int16_t>&, const Question&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::uint32_t>&, const Question&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<std::int32_t>&, const Question&, const RayBatch&,
                               std::span<const ResumedAt>, HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<float>&, const Question&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);
template void resume_certified(const GridVolume<double>&, const Question&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);
template void resume_certified(const NanoVdbVolume&, const Question&, const RayBatch&, std::span<const ResumedAt>,
                               HitBatch&, KernelScratch&);

}  // namespace rhoray::render

#include "render/kernels/grid_kernels.h"

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

template Kernel redoing_kernel_for(const GridVolume<std::uint8_t>&);
template Kernel redoing_kernel_for(const GridVolume<std::int8_t>&);
template Kernel redoing_kernel_for(const GridVolume<std::uint16_t>&);
template Kernel redoing_kernel_for(const GridVolume<std::int16_t>&);
template Kernel redoing_kernel_for(const GridVolume<std::uint32_t>&);
template Kernel redoing_kernel_for(const GridVolume<std::int32_t>&);
template Kernel redoing_kernel_for(const GridVolume<float>&);
template Kernel redoing_kernel_for(const GridVolume<double>&);

}  // namespace rhoray::render

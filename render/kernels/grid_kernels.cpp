#include "render/kernels/grid_kernels.h"

namespace rhoray::render {

template Kernels kernels_for(const GridVolume<std::uint8_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::int8_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::uint16_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::int16_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::uint32_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<std::int32_t>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<float>&, MipMethod, bool);
template Kernels kernels_for(const GridVolume<double>&, MipMethod, bool);
template Kernels kernels_for(const NanoVdbVolume&, MipMethod, bool);

}  // namespace rhoray::render

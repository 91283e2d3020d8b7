#include "render/kernels/grid_kernels.h"

namespace rhoray::render {

template Kernels kernels_for(const RectilinearVolume<std::uint8_t>&, MipMethod, bool);
template Kernels kernels_for(const RectilinearVolume<std::int8_t>&, MipMethod, bool);
template Kernels kernels_for(const RectilinearVolume<std::uint16_t>&, MipMethod, bool);
template Kernels kernels_for(const RectilinearVolume<std::int16_t>&, MipMethod, bool);
template Kernels kernels_for(const RectilinearVolume<std::uint32_t>&, MipMethod, bool);
template Kernels kernels_for(const RectilinearVolume<std::int32_t>&, MipMethod, bool);
template Kernels kernels_for(const RectilinearVolume<float>&, MipMethod, bool);
template Kernels kernels_for(const RectilinearVolume<double>&, MipMethod, bool);

}  // namespace rhoray::render

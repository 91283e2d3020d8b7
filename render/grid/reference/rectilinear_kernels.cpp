#include "render/grid/reference/kernels.h"

namespace rhoray::render {

template ReferenceKernels reference_kernels(const RectilinearVolume<std::uint8_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearVolume<std::int8_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearVolume<std::uint16_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearVolume<std::int16_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearVolume<std::uint32_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearVolume<std::int32_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearVolume<float>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearVolume<double>&, Method::Algorithm);

}  // namespace rhoray::render

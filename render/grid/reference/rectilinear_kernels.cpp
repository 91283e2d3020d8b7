#include "render/grid/reference/kernels.h"

namespace rhoray::render {

template ReferenceKernels reference_kernels(const RectilinearGridData<std::uint8_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearGridData<std::int8_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearGridData<std::uint16_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearGridData<std::int16_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearGridData<std::uint32_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearGridData<std::int32_t>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearGridData<float>&, Method::Algorithm);
template ReferenceKernels reference_kernels(const RectilinearGridData<double>&, Method::Algorithm);

}  // namespace rhoray::render

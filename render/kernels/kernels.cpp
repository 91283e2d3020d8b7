#include "render/kernels/kernels.h"

namespace rhoray::render {

Kernels choose_kernels(const VolumeImplementation& volume, Method::Way way) {
  return std::visit([&](const auto& view) { return kernels_for(view, way); }, volume.view);
}

}  // namespace rhoray::render

#include "render/kernels/kernels.h"

namespace rhoray::render {

Kernels choose_kernels(const VolumeImplementation& volume, MipMethod method, bool timed) {
  return std::visit([&](const auto& view) { return kernels_for(view, method, timed); }, volume.view);
}

}  // namespace rhoray::render

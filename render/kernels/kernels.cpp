#include "render/kernels/kernels.h"

#include <algorithm>

namespace rhoray::render {

Kernels choose_kernels(const VolumeImplementation& volume, const Method& method, Machine) {
  return std::visit([&](const auto& view) { return kernels_for(view, method.way); }, volume.view);
}

void ask(Kernel kernel, const VolumeImplementation& volume, const Question& question, std::span<const Ray> rays,
         std::span<Hit> hits, KernelScratch& scratch) {
  constexpr std::size_t batch_size = 1024;
  RayBatch asked(std::min(rays.size(), batch_size));
  HitBatch answered(std::min(rays.size(), batch_size));
  for (std::size_t first = 0; first < rays.size(); first += batch_size) {
    asked.count = std::min(batch_size, rays.size() - first);
    for (std::size_t r = 0; r < asked.count; ++r) asked.set(r, rays[first + r]);
    kernel(volume, question, asked, answered, scratch);
    for (std::size_t r = 0; r < asked.count; ++r) hits[first + r] = answered[r];
  }
}

}  // namespace rhoray::render

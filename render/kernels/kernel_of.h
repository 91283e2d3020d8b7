#pragma once

#include "render/kernels/kernels.h"

namespace rhoray::render {

/// How one ray's question is answered in a view.
template <class View>
using Answer = Hit (*)(const View& view, const Question& question, const Ray& ray, KernelScratch& scratch);

/// The kernel that answers ray after ray.
template <class View, Answer<View> answer>
void kernel_of(const VolumeImplementation& volume, const Question& question, std::span<const Ray> rays,
               std::span<Hit> hits, KernelScratch& scratch) {
  const View& view = std::get<View>(volume.view);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    const std::uint64_t before = scratch.counters.visits();
    hits[r] = answer(view, question, rays[r], scratch);
    hits[r].cost = static_cast<std::uint32_t>(scratch.counters.visits() - before);
  }
}

}  // namespace rhoray::render

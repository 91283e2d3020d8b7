#pragma once

#include <vector>

#include "render/query/kernels.h"
#include "tests/render/support/traced_volume.h"

namespace rhoray::tests {

/// Returns the first crossings of rays in the volume's frame, from the kernel for a machine.
inline std::vector<render::Hit> answers(TracedVolume& traced, const render::Method& method, render::Machine machine,
                                        const std::vector<render::Ray>& rays, double isovalue) {
  const render::VolumeImplementation& volume = traced.volume().implementation();
  const render::Kernels kernels = render::choose_kernels(volume, method, machine);
  std::vector<render::Hit> hits(rays.size());
  render::ask(kernels.first_crossing, volume, {.isovalue = isovalue, .method = method}, rays, hits, traced.scratch);
  return hits;
}

}  // namespace rhoray::tests

#pragma once

#include <vector>

#include "render/query/intersectors.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/traced_volume.h"

namespace rhoray::tests {

/// Returns the first crossings of rays in the volume's frame, from the kernel for a machine.
inline std::vector<render::Hit> answers(TracedVolume& traced, const render::Method& method, render::Machine machine,
                                        const std::vector<render::Ray>& rays, double isovalue) {
  const render::VolumeImplementation& volume = traced.volume().implementation();
  const render::Intersectors kernels = render::choose_intersectors(volume, {.method = method}, machine);
  std::vector<render::Hit> hits(rays.size());
  ask(kernels.first_hit, volume, {.isovalue = isovalue, .method = method}, rays, hits, traced.scratch);
  return hits;
}

}  // namespace rhoray::tests

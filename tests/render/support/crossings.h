#pragma once

#include <vector>

#include "render/query/intersectors.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/traced_dataset.h"

namespace rhoray::tests {

/// Returns the first crossings of rays in the data's frame, from the kernel for a machine.
inline std::vector<render::Hit> answers(TracedDataset& traced, const render::Method& method, render::Machine machine,
                                        const std::vector<render::Ray>& rays, double isovalue) {
  const render::LoadedDataset& dataset = traced.dataset().implementation();
  const render::Intersectors kernels = render::choose_intersectors(dataset, {.method = method}, machine);
  std::vector<render::Hit> hits(rays.size());
  ask(kernels.first_hit, dataset, {.isovalue = isovalue, .method = method}, rays, hits, traced.scratch);
  return hits;
}

}  // namespace rhoray::tests

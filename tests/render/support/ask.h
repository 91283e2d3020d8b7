#pragma once

#include <algorithm>
#include <span>

#include "render/query/intersectors.h"

namespace rhoray::tests {

/// Answers a query for an array of rays in the data's frame.
inline void ask(render::Kernel kernel, const render::LoadedDataset& dataset, const render::RayQuery& query,
                std::span<const render::Ray> rays, std::span<render::Hit> hits, render::KernelScratch& scratch) {
  constexpr std::size_t batch_size = 1024;
  render::RayBatch asked(std::min(rays.size(), batch_size));
  asked.has_start_sides = true;
  render::HitBatch answered(std::min(rays.size(), batch_size));
  for (std::size_t first = 0; first < rays.size(); first += batch_size) {
    asked.count = std::min(batch_size, rays.size() - first);
    for (std::size_t r = 0; r < asked.count; ++r) asked.set(r, rays[first + r]);
    kernel(dataset, query, asked, answered, scratch);
    for (std::size_t r = 0; r < asked.count; ++r) hits[first + r] = answered[r];
  }
}

}  // namespace rhoray::tests

#pragma once

#include "render/query/kernels.h"

namespace rhoray::render {

/// Answers the query for one ray in a view.
template <class View>
using Answer = Hit (*)(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch);

/// The kernel that answers one ray after the other.
template <class View, Answer<View> answer>
void kernel_of(const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
               KernelScratch& scratch) {
  const View& view = std::get<View>(dataset.view);
  for (std::size_t r = 0; r < rays.count; ++r) {
    const std::uint64_t before = scratch.counters.visits();
    Hit hit = answer(view, query, rays[r], scratch);
    hit.cost = static_cast<std::uint32_t>(scratch.counters.visits() - before);
    hits.set(r, hit);
  }
}

/// The kernel of one query for an algorithm.
template <class View, Answer<View> direct, Answer<View> sampled, Answer<View> certified, Answer<View> exact>
Kernel kernel_for(Method::Algorithm algorithm) {
  switch (algorithm) {
    case Method::Algorithm::sampled:
      return kernel_of<View, sampled>;
    case Method::Algorithm::certified:
      return kernel_of<View, certified>;
    case Method::Algorithm::exact:
      return kernel_of<View, exact>;
    case Method::Algorithm::direct:
    case Method::Algorithm::preview:
    case Method::Algorithm::paper:
    case Method::Algorithm::slack:
      break;
  }
  return kernel_of<View, direct>;  // the function itself distinguishes between these
}

}  // namespace rhoray::render

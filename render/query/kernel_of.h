#pragma once

#include "render/query/kernels.h"

namespace rhoray::render {

/// Answers the query for one ray in a view.
template <class View>
using Answer = Hit (*)(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch);

/// Answers one ray after the other.
/// @param answer  (ray, its number): the hit, without its cost
template <class AnswerOne>
void answer_each(const RayBatch& rays, HitBatch& hits, const KernelScratch& scratch, AnswerOne&& answer) {
  for (std::size_t r = 0; r < rays.count; ++r) {
    const std::uint64_t before = scratch.counters.visits();
    Hit hit = answer(rays[r], r);
    hit.cost = static_cast<std::uint32_t>(scratch.counters.visits() - before);
    hits.set(r, hit);
  }
}

template <class View, Answer<View> answer>
void kernel_of(const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
               KernelScratch& scratch) {
  const View& view = std::get<View>(dataset.view);
  answer_each(rays, hits, scratch, [&](const Ray& ray, std::size_t) { return answer(view, query, ray, scratch); });
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

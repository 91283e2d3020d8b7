#include "render/frame/clip_gap.h"

#include <algorithm>
#include <limits>

namespace rhoray::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Joins the hits of two parts of a ray: the first surface, or the largest value; of equal values
/// the first.
Hit joined(const Hit& before, const Hit& behind, bool is_projection) {
  Hit hit = !before.is_miss() && (!is_projection || behind.is_miss() || before.value >= behind.value) ? before : behind;
  if (is_projection && !before.is_miss() && !behind.is_miss()) hit.error = std::max(before.error, behind.error);
  hit.cost = before.cost + behind.cost;
  return hit;
}

}  // namespace

void trace_after_clip_gap(const FrameLayer& layer, Kernel kernel, const RayQuery& query, const double* ends,
                          Worker& worker, LayerWork& work) {
  const bool is_projection = layer.shading.layer.mode == Mode::mip;
  const WorldRays& world = *worker.world;
  worker.few.clear();
  for (const std::uint32_t r : world.cut) {
    Ray rest = work.rays[r];
    rest.t_min = world.kept.again[r];
    rest.t_max = ends != nullptr ? ends[r] : infinity;
    rest.start_side = StartSide::unknown;
    if (!(rest.t_min <= rest.t_max) || rest.t_min == infinity) continue;
    if (!is_projection) work.rays.set(r, rest);
    worker.few_rays.set(worker.few.size(), rest);
    worker.few.push_back(r);
  }
  if (worker.few.empty()) return;
  worker.few_rays.count = worker.few.size();
  kernel(layer.dataset, query, worker.few_rays, worker.few_hits, work.scratch);
  for (std::size_t i = 0; i < worker.few.size(); ++i) {
    const std::size_t r = worker.few[i];
    work.hits.set(r, joined(work.hits[r], worker.few_hits[i], is_projection));
  }
}

}  // namespace rhoray::render

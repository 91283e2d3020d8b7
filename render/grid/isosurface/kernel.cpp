#include <algorithm>
#include <span>
#include <utility>

#include "render/grid/isosurface/grid_surface.h"
#include "render/grid/isosurface/isosurface.h"
#include "render/grid/isosurface/parts.h"
#include "render/query/kernel_on.h"

namespace rhoray::render::wide {

namespace {

/// The thread's scratch memory, without kept blocks of other surfaces.
IsosurfaceScratch& prepared(Scratch& scratch, std::shared_ptr<const Occupancy> occupancy) {
  IsosurfaceScratch& memory = scratch.as<IsosurfaceScratch>();
  if (memory.occupancy != occupancy) {
    std::fill(std::begin(memory.block_key), std::end(memory.block_key), IsosurfaceScratch::no_block);
    memory.occupancy = std::move(occupancy);
  }
  return memory;
}

/// Traces the doubtful rays again.
/// @param ask  (rays, where their doubt begins, hits)
template <class Ask>
void redo_doubtful(const Ask& ask, const RayBatch& rays, HitBatch& hits, IsosurfaceScratch& memory,
                   KernelCounters& counters) {
  DoubtfulRay* const begin = memory.doubtful.ray;
  DoubtfulRay* end = begin + std::exchange(memory.doubtful.count, 0);
  // If a ray occurs twice, keep the entry that traces it as a whole.
  std::sort(begin, end, [](const DoubtfulRay& a, const DoubtfulRay& b) {
    return a.index != b.index ? a.index < b.index : a.from.t < b.from.t;
  });
  end = std::unique(begin, end, [](const DoubtfulRay& a, const DoubtfulRay& b) { return a.index == b.index; });
  counters.rays_wide -= static_cast<std::uint64_t>(end - begin);
  ResumedAt from[RayGroup::size];
  for (DoubtfulRay* first = begin; first < end;) {
    const std::span<const DoubtfulRay> some(
        first, std::min<std::size_t>(RayGroup::size, static_cast<std::size_t>(end - first)));
    memory.few.rays.has_start_sides = rays.has_start_sides;
    memory.few.rays.count = some.size();
    for (std::size_t i = 0; i < some.size(); ++i) memory.few.rays.set(i, rays[some[i].index]), from[i] = some[i].from;
    ask(memory.few.rays, std::span<const ResumedAt>(from, some.size()), memory.few.hits);
    for (std::size_t i = 0; i < some.size(); ++i) hits.set(some[i].index, memory.few.hits[i]);
    first += some.size();
  }
}

template <Machine machine, Search search>
void first_crossings(const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                     KernelScratch& scratch) {
  const UniformGrid& view = std::get<UniformGrid>(dataset.view);
  const Kernel reference = reference_kernels(view, query.method.algorithm).first_hit;
  if (!is_answerable_wide(view, query)) {
    reference(dataset, query, rays, hits, scratch);
    return;
  }
  scratch.counters.rays_wide += rays.count;
  IsosurfaceScratch& memory = prepared(scratch.for_hits, dataset.occupancies->of(view.ranges(), query.isovalue));
  const IsosurfaceQuery surface = surface_of(view, *memory.occupancy, query);
  const CrossingKernels kernels = crossing_kernels_on(machine, search);
  const RayArrays asked = arrays_of(rays);
  const HitArrays answers = arrays_of(hits);
  const auto ask = [&](const RayBatch& some, std::span<const ResumedAt> resumed_at, HitBatch& found) {
    if constexpr (search == Search::certified)
      resume_certified(view, query, some, resumed_at, found, scratch);
    else
      reference(dataset, query, some, found, scratch);
  };
  const auto redo = [&] {
    if (memory.doubtful.count != 0) redo_doubtful(ask, rays, hits, memory, scratch.counters);
  };
  for (std::size_t first = 0; first < rays.count; first += RayGroup::size) {
    const std::size_t count = std::min(RayGroup::size, rays.count - first);
    write_misses(from(answers, first), count);
    kernels.answer(surface, asked, first, count, answers, memory, scratch.counters);
    redo();
  }
  kernels.answer_waiting(surface, asked, answers, memory, scratch.counters);
  redo();
}

}  // namespace

std::optional<SurfaceBoxes> prepare_occupancy(const LoadedDataset& dataset, const RayQuery& query, unsigned,
                                              const std::stop_token& stop) {
  const UniformGrid& view = std::get<UniformGrid>(dataset.view);
  if (!is_answerable_wide(view, query)) return std::nullopt;
  const auto occupancy = dataset.occupancies->of(view.ranges(), query.isovalue, stop);
  const Index3 cells = view.lattice().leaf_count;
  SurfaceBoxes boxes = boxes_of(occupancy, occupancy->boxes());
  // Far above what rounding exchanges at edges between cells, plus the rounding of the last cells
  // to single precision.
  boxes.margin = 1.0 / 64 + 0x1p-24 * static_cast<double>(std::max({cells.x, cells.y, cells.z}));
  return boxes;
}

Kernel first_crossing_kernel(const LoadedDataset& dataset, const Method& method, Machine machine) {
  if (!has_wide_crossings(method) || fit_grid(dataset) == nullptr) return nullptr;
  return kernel_on(machine, [&]<Machine wide>() -> Kernel {
    return method.algorithm == Method::Algorithm::preview     ? first_crossings<wide, Search::preview>
           : method.algorithm == Method::Algorithm::certified ? first_crossings<wide, Search::certified>
                                                              : first_crossings<wide, Search::bracketed>;
  });
}

}  // namespace rhoray::render::wide

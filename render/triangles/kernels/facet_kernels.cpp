#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "render/cell/tet_methods.h"
#include "render/dataset/loaded_dataset.h"
#include "render/query/kernel_on.h"
#include "render/tets/reference/kernels.h"
#include "render/tets/reference/walk.h"
#include "render/triangles/facet_levels.h"
#include "render/triangles/kernels/all_hits_parts.h"
#include "render/triangles/kernels/facet_kernels.h"
#include "render/triangles/kernels/facet_parts.h"
#include "render/triangles/shadow/facet_occluders.h"

namespace rhoray::render::wide {

namespace {

bool is_of_triangles(const LoadedDataset& dataset) {
  return std::holds_alternative<TriangleData>(dataset.view);
}

/// The facets of a mesh's isosurface, or the triangles of a surface.
std::shared_ptr<const Facets> facets_of(const LoadedDataset& dataset, double isovalue, unsigned threads,
                                        const std::stop_token& stop = {}) {
  if (const auto* triangles = std::get_if<TriangleData>(&dataset.view))
    return dataset.facets->of(*triangles, dataset.bounds_data, isovalue, threads, stop);
  return dataset.facets->of(std::get<TetData>(dataset.view), dataset.bounds_data, isovalue, threads, stop);
}

Kernel first_hit_of(const LoadedDataset& dataset, const Method& method) {
  if (const auto* triangles = std::get_if<TriangleData>(&dataset.view))
    return reference_kernels(*triangles, method.algorithm).first_hit;
  return reference_kernels(std::get<TetData>(dataset.view), method.algorithm).first_hit;
}

/// @param levels  of the tree above some of the facets
FacetSurface surface_of(const Facets& facets, const BoxLevels& levels, const RayQuery& query, bool is_of_triangles) {
  const FloatBox box = box_of(levels);
  FacetSurface surface{.blocks = facets.blocks(),
                       .fields = facets.fields(),
                       .levels = {},
                       .level_count = static_cast<int>(levels.size()),
                       .facet_count = facets.count(),
                       .anchor = {facets.anchor().x, facets.anchor().y, facets.anchor().z},
                       .scale = facets.scale(),
                       .low = {},
                       .high = {},
                       .isovalue = is_of_triangles ? std::numeric_limits<double>::quiet_NaN() : query.isovalue,
                       .is_of_triangles = is_of_triangles,
                       .time_phases = query.time_phases};
  for (std::size_t l = 0; l < levels.size(); ++l) surface.levels[l] = levels[l].data();
  std::copy(box.low.begin(), box.low.end(), surface.low);
  std::copy(box.high.begin(), box.high.end(), surface.high);
  return surface;
}

FacetSurface surface_of(const FacetOccluders& occluders, const RayQuery& query) {
  FacetSurface surface = surface_of(occluders.facets(), occluders.levels(), query, false);
  surface.blocks = occluders.blocks(), surface.sources = occluders.sources(), surface.sure = occluders.sure();
  surface.facet_count = occluders.count();
  return surface;
}

/// Calls act(surface, first, count, chunk) for the rays of a batch, one chunk at a time. The chunk
/// begins at ray `first`; `surface` is the part of the surface to trace it against.
/// @param farthest, most_expected  as in PrepareRays
template <class Act>
void for_each_chunk(Machine machine, const FacetSurface& whole, const RayBatch& rays, double farthest,
                    float most_expected, FacetScratch& memory, KernelCounters& counters, const Act& act) {
  constexpr std::size_t at_once = FacetScratch::chunk_capacity * RayGroup::size;
  const PrepareRays prepare = prepare_rays_on(machine);
  for (std::size_t begin = 0; begin < rays.count; begin += at_once) {
    const std::size_t end = std::min(begin + at_once, rays.count);
    const FacetSurface& surface =
        prepare(whole, from(rays, begin), end - begin, farthest, most_expected, memory, counters);
    FacetChunk* chunk = memory.chunks;
    for (std::size_t first = begin; first < end; first += RayGroup::size)
      act(surface, first, std::min(RayGroup::size, end - first), *chunk++);
  }
}

bool is_answerable(const RayQuery& query) {
  return query.use_hierarchy && std::abs(query.isovalue) <= largest_magnitude;
}

/// Finds out with another kernel, one for first crossings, which of the `chosen` rays have any
/// crossing (bit r: ray first + r).
/// @return  a bit for each of these rays that has one
std::uint64_t ask_whether_any(Kernel kernel, const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays,
                              std::size_t first, std::uint64_t chosen, FewRays& few, KernelScratch& scratch) {
  few.rays.has_start_sides = rays.has_start_sides;
  few.rays.count = 0;
  for (std::uint64_t bits = chosen; bits != 0; bits &= bits - 1)
    few.rays.set(few.rays.count++, rays[first + static_cast<std::size_t>(std::countr_zero(bits))]);
  scratch.counters.rays_wide -= few.rays.count;
  kernel(dataset, query, few.rays, few.hits, scratch);
  std::uint64_t crossed = 0;
  std::size_t place = 0;
  for (std::uint64_t bits = chosen; bits != 0; bits &= bits - 1)
    if (few.hits.t[place++] < std::numeric_limits<double>::infinity()) crossed |= bits & (~bits + 1);
  return crossed;
}

/// Completes a certified result with a double-precision test of the cells of facets in doubt, cell
/// by cell as certified_crossing of render/tets/reference/certified.h.
/// @return  false when a doubt remains
bool settle(const TetData& view, const RayQuery& query, const Ray& ray, std::span<const FacetDoubt> doubts,
            std::uint32_t index, const Facets& facets, Hit& hit) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const TetRay<double> tet_ray(ray);
  std::optional<std::uint32_t> hit_tet;
  double earliest = hit.is_miss() ? hit.t : hit.t - hit.error, error = hit.is_miss() ? 0 : hit.error;
  double t = hit.t, doubtful_from = infinity;
  for (const FacetDoubt& doubt : doubts) {
    if (doubt.ray != index) continue;
    const std::uint32_t tet = facets.fields()[doubt.facet].tet;
    const auto vertices = view.sorted_vertices(tet);
    const TetPoints points = view.points_at(vertices);
    const CertifiedTetCrossing found =
        certify_tet_crossing<double>(tet_ray, points, view.values_at(vertices), query.isovalue);
    if (found.decision == Decision::unknown) {
      for (const auto& point : points) doubtful_from = std::min(doubtful_from, tet_ray.shear.see(point).t);
    } else if (found.decision == Decision::crosses) {
      earliest = std::min(earliest, found.t - found.t_error);
      if (found.t > t || (found.t == t && hit_tet && !is_preferred(view, tet, *hit_tet))) continue;
      t = found.t, error = found.t_error, hit_tet = tet;
    }
  }
  const double t_rounding = 0x1p-50 * std::abs(doubtful_from);
  if (doubtful_from < infinity && !(t + error < doubtful_from - t_rounding)) return false;
  if (t == infinity) return true;
  if (hit_tet) fill_in(hit, view, query, *hit_tet, t);
  hit.error = std::max(error, t - earliest);
  return true;
}

/// @param chosen  rays of the chunk that begins at `first`
/// @return        those that remain in doubt
std::uint64_t settle_doubts(const TetData& view, const RayQuery& query, const RayBatch& rays, std::size_t first,
                            std::uint64_t chosen, const FacetScratch& memory, HitBatch& hits,
                            KernelCounters& counters) {
  std::uint64_t left = 0;
  const std::span<const FacetDoubt> doubts(memory.doubts, memory.doubt_count);
  for (; chosen != 0; chosen &= chosen - 1) {
    const auto index = static_cast<std::uint32_t>(std::countr_zero(chosen));
    Hit hit = hits[first + index];
    if (settle(view, query, rays[first + index], doubts, index, *memory.facets, hit)) {
      hits.set(first + index, hit);
      ++counters.rays_redone;
    } else {
      left |= std::uint64_t{1} << index;
    }
  }
  return left;
}

template <Machine machine, bool certified>
void first_facets(const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                  KernelScratch& scratch) {
  const Kernel reference = first_hit_of(dataset, query.method);
  if (!is_answerable(query)) {
    reference(dataset, query, rays, hits, scratch);
    return;
  }
  scratch.counters.rays_wide += rays.count;
  FacetScratch& memory = scratch.for_hits.as<FacetScratch>();
  memory.facets = facets_of(dataset, query.isovalue, 1);
  const FacetSurface whole = surface_of(*memory.facets, memory.facets->levels(), query, is_of_triangles(dataset));
  const FirstFacets answer = first_facets_on(machine, certified);
  const HitArrays answers = arrays_of(hits);
  const auto answer_chunk = [&](const FacetSurface& surface, std::size_t first, std::size_t count, FacetChunk& chunk) {
    const HitArrays written = from(answers, first);
    Answered left = answer(surface, from(rays, first), count, chunk, written, memory, scratch.counters);
    write_other_misses(written, count, left.hit);
    Kernel other = reference;
    if constexpr (certified) {  // never of triangles
      if (left.part != 0)
        left.whole |= settle_doubts(std::get<TetData>(dataset.view), query, rays, first, left.part, memory, hits,
                                    scratch.counters);
      other = redoing_kernel();
    }
    if (left.whole != 0) ask_again(other, dataset, query, rays, first, left.whole, hits, memory.others, scratch);
  };
  for_each_chunk(machine, whole, rays, certified ? certified_reach : reach, FacetPart::most_expected, memory,
                 scratch.counters, answer_chunk);
}

template <Machine machine>
void any_facets(const LoadedDataset& dataset, const RayQuery& query, const Occluders* occluders, const RayBatch& rays,
                std::uint64_t* crossed, KernelScratch& scratch) {
  const Kernel reference = first_hit_of(dataset, query.method);
  scratch.counters.rays_wide += rays.count;
  FacetScratch& memory = scratch.for_hits.as<FacetScratch>();
  if (!is_answerable(query)) {
    for (std::size_t first = 0; first < rays.count; first += RayGroup::size) {
      const std::size_t count = std::min(RayGroup::size, rays.count - first);
      const std::uint64_t all = count < RayGroup::size ? (std::uint64_t{1} << count) - 1 : ~std::uint64_t{0};
      crossed[first / RayGroup::size] =
          ask_whether_any(reference, dataset, query, rays, first, all, memory.others, scratch);
    }
    return;
  }
  FacetSurface whole;
  if (occluders == nullptr) {
    memory.facets = facets_of(dataset, query.isovalue, 1);
    whole = surface_of(*memory.facets, memory.facets->levels(), query, is_of_triangles(dataset));
  } else {
    whole = surface_of(facets_of(*occluders), query);
  }
  const AnyFacets answer = any_facets_on(machine);
  for_each_chunk(machine, whole, rays, reach, FacetPart::most_expected_of_any, memory, scratch.counters,
                 [&](const FacetSurface& surface, std::size_t first, std::size_t count, FacetChunk& chunk) {
                   MetFacets met = answer(surface, from(rays, first), count, chunk, memory, scratch.counters);
                   if (met.unanswered != 0)
                     met.crossed |= ask_whether_any(reference, dataset, query, rays, first, met.unanswered,
                                                    memory.others, scratch);
                   crossed[first / RayGroup::size] = met.crossed;
                 });
}

/// Returns how many crossings of a ray may contribute light, plus a few for edges that are hit
/// twice.
std::size_t room_for(float passing, float least_light) {
  std::size_t shown = 1;
  for (float light = passing; shown < CrossingList::most && !(light < least_light); light *= passing) ++shown;
  return shown + (FacetLists::capacity - CrossingList::most);
}

template <Machine machine>
void cross_facets(const LoadedDataset& dataset, const AllHitsQuery& query, const RayBatch& rays,
                  std::span<CrossingList* const> lists, std::uint8_t* complete, Scratch& scratch,
                  KernelCounters& counters) {
  FacetAllHitsScratch& memory = scratch.as<FacetAllHitsScratch>();
  counters.rays_wide += rays.count;
  std::fill_n(complete, rays.count, std::uint8_t{1});
  for (std::size_t s = 0; s < lists.size(); ++s) {
    const TransparentSurface& asked = query.surfaces[s];
    const auto facets = facets_of(dataset, asked.isovalue, 1);
    const FacetSurface whole =
        surface_of(*facets, facets->levels(), {.isovalue = asked.isovalue, .time_phases = query.time_phases}, false);
    FacetLists& found = memory.lists;
    found.room = room_for(asked.passing, query.least_light);
    found.passing = asked.passing, found.least_light = query.least_light;
    const CrossingArrays written = arrays_of(*lists[s]);
    found.written = &written, found.complete = complete;
    write_misses(written.hits[0], rays.count);
    std::fill_n(written.count, rays.count, std::uint8_t{0});
    const CrossFacets answer = cross_facets_on(machine);
    const auto answer_chunk = [&](const FacetSurface& surface, std::size_t first, std::size_t count,
                                  FacetChunk& chunk) {
      found.first = first;
      std::uint64_t left = answer(surface, from(rays, first), count, chunk, found, memory.facets, counters);
      for (; left != 0; left &= left - 1) complete[first + static_cast<std::size_t>(std::countr_zero(left))] = 0;
    };
    for_each_chunk(machine, whole, rays, reach, FacetPart::most_expected, memory.facets, counters, answer_chunk);
  }
}

/// True for a mesh or surface whose products of lengths and values stay far from the limits of
/// doubles.
bool is_fit(const LoadedDataset& dataset) {
  const bool has_values = !is_of_triangles(dataset);
  const Vec3 size = dataset.bounds_data.size();
  const double longest = std::max({size.x, size.y, size.z});
  return longest >= 1 / largest_magnitude && longest <= largest_magnitude &&
         (!has_values || (std::abs(dataset.field.range.lo) <= largest_magnitude &&
                          std::abs(dataset.field.range.hi) <= largest_magnitude));
}

std::optional<SurfaceBoxes> prepare_facets(const LoadedDataset& dataset, const RayQuery& query, unsigned threads,
                                           const std::stop_token& stop) {
  if (!is_answerable(query)) return std::nullopt;
  const auto facets = facets_of(dataset, query.isovalue, threads, stop);
  SurfaceBoxes boxes = boxes_of(facets, facets->levels());
  boxes.anchor = facets->anchor();
  boxes.unit = 1 / facets->scale();
  boxes.margin = facet_margin;
  return boxes;
}

constexpr OccluderSearch occluder_search{
    .source = [](const LoadedDataset& dataset, const RayQuery& query, const LightPlace&, unsigned threads,
                 const std::stop_token& stop) -> std::shared_ptr<const void> {
      return facets_with_occluders(dataset, query, threads, stop);
    },
    .surface = occluding_facets};

}  // namespace

std::shared_ptr<const Facets> facets_with_occluders(const LoadedDataset& dataset, const RayQuery& query,
                                                    unsigned threads, const std::stop_token& stop) {
  if (!is_answerable(query) || !is_fit(dataset) || is_of_triangles(dataset)) return nullptr;
  return facets_of(dataset, query.isovalue, threads, stop);
}

void use_facets(const LoadedDataset& dataset, const RayQuery& query, Machine machine, Intersectors& found) {
  const Method& method = query.method;
  const bool is_surface = is_of_triangles(dataset);
  const bool is_certified = method.algorithm == Method::Algorithm::certified;
  if (machine == Machine::scalar || !has_wide_crossings(method) || !is_fit(dataset) || (is_surface && is_certified))
    return;
  found.first_hit = kernel_on(machine, [&]<Machine wide>() -> Kernel {
    return is_certified ? first_facets<wide, true> : first_facets<wide, false>;
  });
  found.prepare = prepare_facets;
  if (!is_certified)
    found.any_hit = kernel_on(machine, []<Machine wide>() -> AnyHitKernel { return any_facets<wide>; });
  if (is_surface) return;
  found.occluders = &occluder_search;
  if (method.algorithm == Method::Algorithm::direct && is_answerable(query))
    found.all_hits = kernel_on(machine, []<Machine wide>() -> AllHitsKernel { return cross_facets<wide>; });
}

}  // namespace rhoray::render::wide

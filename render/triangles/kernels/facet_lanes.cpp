#include <bit>
#include <optional>
#include <utility>

#include "render/traverse/ticks.h"
#include "render/triangles/kernels/all_hits_parts.h"
#include "render/triangles/kernels/facet_parts.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/triangles/kernels/facet_lanes.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once per machine

#include <hwy/highway.h>

#include "render/traverse/on_machine.h"
#include "render/triangles/kernels/facet_group-inl.h"
#include "render/triangles/kernels/facet_hits-inl.h"
#include "render/triangles/kernels/facet_lanes-inl.h"
#include "render/triangles/kernels/facet_lists-inl.h"
#include "render/triangles/kernels/facet_part-inl.h"
#include "render/triangles/kernels/facet_tests-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Traces the rays of a chunk that share a major axis and a direction along it.
template <FacetSearch search>
class FacetWalk {
 public:
  HWY_INLINE FacetWalk(const FacetSurface& surface, const RayArrays& rays, std::size_t count, const HitArrays& hits,
                       int axis, bool down, FacetChunk& chunk, FacetScratch& scratch, KernelCounters& counters)
      : group_(surface, rays, count, axis, down, chunk, scratch),
        tests_(group_),
        hits_(group_, hits),
        counters_(counters) {}

  /// Traces these lanes: together where they are close to each other, else pack by pack, or each
  /// alone.
  void trace(std::uint64_t lanes_alive) {
    group_.begin<search>(lanes_alive);
    if (group_.is_narrow(lanes_alive)) return walk(lanes_alive);
    for (std::size_t p = 0; p < packs; ++p) {
      const std::uint64_t in_pack = lanes_alive & pack_bits << pack * p;
      if (in_pack == 0) continue;
      group_.begin<search>(in_pack);
      if (group_.is_narrow(in_pack)) {
        walk(in_pack);
        continue;
      }
      for (std::uint64_t bits = in_pack; bits != 0; bits &= bits - 1) {
        const std::uint64_t alone = bits & (~bits + 1);
        group_.begin<search>(alone);
        walk(alone);
      }
    }
  }

  HWY_INLINE Answered answered() const { return group_.answered; }
  HWY_INLINE std::uint64_t crossed() const { return group_.crossed; }  ///< lanes

 private:
  void walk(std::uint64_t lanes_alive) {
    visits_ = group_.scratch.part_visits;
    if constexpr (search == FacetSearch::all) clear_lists(*group_.scratch.lists);
    if (group_.has_facets()) {
      for (std::size_t p = 0; p < packs; ++p) group_.find_pack_far<search>(p);
      group_.find_group_far();
      FacetStack stack(group_.surface);
      while (stack.count != 0) {
        const FacetEntry entry = stack.entries[--stack.count];
        if (entry >> 32 > key_of(group_.far)) continue;
        ++visits_;
        if (level_of(entry) > 0) {
          stack.open(group_.surface, group_, entry);
          ++nodes_;
        } else {
          const std::uint64_t start = group_.surface.time_phases ? ticks_now() : 0;
          tests_.look_into(place_of(entry));
          if (group_.surface.time_phases) counters_.intersection_ticks += ticks_now() - start;
          ++blocks_;
        }
      }
    }
    if constexpr (search == FacetSearch::all)
      write_lists(group_, lanes_alive, visits_);
    else if constexpr (search != FacetSearch::any)
      hits_.write(lanes_alive, visits_);
    count(static_cast<std::uint64_t>(std::popcount(lanes_alive)));
  }

  HWY_INLINE void count(std::uint64_t rays) {
    counters_.macrocells_visited += nodes_ * rays;
    counters_.cells_visited += blocks_ * rays;
    counters_.cells_solved += tests_.count() * (rays < pack ? rays : pack);
    nodes_ = blocks_ = 0;
    tests_.forget_count();
  }

  FacetGroup group_;
  FacetTests<search> tests_;
  FacetHits<search> hits_;
  KernelCounters& counters_;
  std::uint64_t visits_ = 0, nodes_ = 0, blocks_ = 0;
};

/// Calls act(axis, down, rays) for each set of a chunk's rays that share a major axis and a
/// direction along it.
template <class Act>
HWY_INLINE void for_each_direction(const Directions& directions, const Act& act) {
  for (int axis = 0; axis < 3; ++axis)
    for (const bool down : {false, true})
      if (const std::uint64_t chosen = directions.along[axis] & (down ? directions.down[axis] : ~directions.down[axis]);
          chosen != 0)
        act(axis, down, chosen);
}

const FacetSurface& prepare_rays(const FacetSurface& whole, const RayArrays& rays, std::size_t count, double farthest,
                                 float most_expected, FacetScratch& scratch, KernelCounters& counters) {
  std::optional<std::pair<int, bool>> shared;
  bool is_shared = true;
  std::size_t chunk_count = 0;
  for (std::size_t first = 0; first < count; first += lanes, ++chunk_count) {
    FacetChunk& chunk = scratch.chunks[chunk_count];
    const std::size_t in_chunk = count - first < lanes ? count - first : lanes;
    const RayArrays of_chunk = from(rays, first);
    chunk.directions = directions_of(whole, of_chunk, in_chunk, farthest);
    chunk.axis = -1;
    const auto one = only_direction(chunk.directions);
    if (!one || (shared && shared != one)) {
      is_shared = false;
      continue;
    }
    shared = one;
    describe_rays(whole, of_chunk, in_chunk, FacetBeam(one->first, one->second), chunk.lines);
    chunk.axis = one->first, chunk.down = one->second;
  }
  scratch.part_visits = 0;
  constexpr std::size_t few_chunks = 3;  // too few to share enough work
  if (!is_shared || !shared || chunk_count <= few_chunks) return whole;
  PartSearch search(whole, scratch.chunks, chunk_count, shared->first, shared->second);
  const bool is_whole = search.gather(scratch.part, most_expected);
  counters.macrocells_visited += scratch.part.node_count * count;
  counters.cells_visited += scratch.part.looked_into_count * count;
  scratch.part_visits = scratch.part.node_count + scratch.part.looked_into_count;
  return is_whole ? scratch.part.surface : whole;
}

template <FacetSearch search>
Answered first_facets(const FacetSurface& surface, const RayArrays& rays, std::size_t count, FacetChunk& chunk,
                      const HitArrays& hits, FacetScratch& scratch, KernelCounters& counters) {
  Answered answered{.whole = chunk.directions.strange};
  scratch.doubt_count = 0;
  for_each_direction(chunk.directions, [&](int axis, bool down, std::uint64_t chosen) HWY_ATTR {
    FacetWalk<search> walk(surface, rays, count, hits, axis, down, chunk, scratch, counters);
    walk.trace(lanes_of(chosen));
    answered.hit |= walk.answered().hit;
    answered.whole |= walk.answered().whole;
    answered.part |= walk.answered().part;
  });
  answered.part &= ~answered.whole;
  return answered;
}

MetFacets any_facets(const FacetSurface& surface, const RayArrays& rays, std::size_t count, FacetChunk& chunk,
                     FacetScratch& scratch, KernelCounters& counters) {
  MetFacets met{.crossed = 0, .unanswered = chunk.directions.strange};
  for_each_direction(chunk.directions, [&](int axis, bool down, std::uint64_t chosen) HWY_ATTR {
    FacetWalk<FacetSearch::any> walk(surface, rays, count, {}, axis, down, chunk, scratch, counters);
    walk.trace(lanes_of(chosen));
    met.crossed |= rays_of(walk.crossed());
  });
  return met;
}

std::uint64_t all_facets(const FacetSurface& surface, const RayArrays& rays, std::size_t count, FacetChunk& chunk,
                         FacetLists& lists, FacetScratch& scratch, KernelCounters& counters) {
  scratch.lists = &lists;
  for_each_direction(chunk.directions, [&](int axis, bool down, std::uint64_t chosen) HWY_ATTR {
    FacetWalk<FacetSearch::all> walk(surface, rays, count, {}, axis, down, chunk, scratch, counters);
    walk.trace(lanes_of(chosen));
  });
  return chunk.directions.strange;
}

FirstFacets first_facets_by(bool certified) {
  return certified ? first_facets<FacetSearch::certified> : first_facets<FacetSearch::first>;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace rhoray::render::wide {

PrepareRays prepare_rays_on(Machine machine) {
  RHORAY_RETURN_ON(machine, prepare_rays);
}

FirstFacets first_facets_on(Machine machine, bool certified) {
  RHORAY_RETURN_ON(machine, first_facets_by(certified));
}

AnyFacets any_facets_on(Machine machine) {
  RHORAY_RETURN_ON(machine, any_facets);
}

CrossFacets cross_facets_on(Machine machine) {
  RHORAY_RETURN_ON(machine, all_facets);
}

}  // namespace rhoray::render::wide

#endif

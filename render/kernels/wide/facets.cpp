#include <bit>
#include <limits>

#include "render/kernels/wide/facet_shells_parts.h"
#include "render/kernels/wide/facets_parts.h"
#include "render/march/ticks.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/kernels/wide/facets.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once per machine

#include <hwy/highway.h>

#include "render/kernels/wide/facet_group-inl.h"
#include "render/kernels/wide/facet_hits-inl.h"
#include "render/kernels/wide/facet_lanes-inl.h"
#include "render/kernels/wide/facet_lists-inl.h"
#include "render/kernels/wide/facet_tests-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// The rays of a chunk that move most along one axis, one way.
template <FacetSearch search>
class FacetWalk {
 public:
  HWY_INLINE FacetWalk(const FacetSurface& surface, const RayArrays& rays, std::size_t count, const HitArrays& hits,
                       int axis, bool down, FacetScratch& scratch, KernelCounters& counters)
      : group_(surface, rays, count, axis, down, scratch), tests_(group_), hits_(group_, hits), counters_(counters) {}

  /// Traces these lanes: together where they lie close, else pack by pack, or each alone.
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
  /// A node or block on the stack as one number, so that comparing two compares how near they are: from above the key
  /// of its least depth, its level, counted from 1 and 0 for a block, and its place there.
  using Entry = std::uint64_t;
  static constexpr int level_shift = 28;
  static HWY_INLINE Entry entry_of(std::uint32_t key, std::uint32_t level, std::uint32_t place) {
    return Entry{key} << 32 | Entry{level} << level_shift | place;
  }

  /// Whole numbers in the order of the floats.
  static HWY_INLINE std::uint32_t key_of(float depth) {
    const auto bits = std::bit_cast<std::int32_t>(depth);
    return static_cast<std::uint32_t>(bits ^ (bits >> 31 & 0x7fffffff)) ^ 0x80000000;
  }
  static HWY_INLINE VecI keys_of(VecF depth) {
    const VecI bits = hn::BitCast(ints, depth), sign = hn::Set(ints, std::numeric_limits<std::int32_t>::min());
    return hn::Xor(hn::Xor(bits, hn::AndNot(sign, hn::ShiftRight<31>(bits))), sign);
  }

  void walk(std::uint64_t lanes_alive) {
    visits_ = 0;
    if constexpr (search == FacetSearch::all) clear_lists(*group_.scratch.lists);
    if (group_.has_facets()) {
      for (std::size_t p = 0; p < packs; ++p) group_.find_pack_far<search>(p);
      group_.find_group_far();
      Entry stack[(FacetNode::size - 1) * FacetSurface::largest_level_count + 1];
      std::size_t top = 0;
      stack[top++] = entry_of(0, static_cast<std::uint32_t>(group_.surface.level_count), 0);
      while (top != 0) {
        const Entry entry = stack[--top];
        if (entry >> 32 > key_of(group_.far)) continue;
        ++visits_;
        const std::uint32_t level = static_cast<std::uint32_t>(entry) >> level_shift,
                            place = static_cast<std::uint32_t>(entry) & ((1U << level_shift) - 1);
        if (level > 0) {
          open(level, place, stack, top);
          ++nodes_;
        } else {
          const std::uint64_t start = group_.surface.time_phases ? ticks_now() : 0;
          tests_.look_into(place);
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

  /// Puts those children of a node that the group may meet on the stack, the nearest on top.
  HWY_INLINE void open(std::uint32_t level, std::uint32_t place, Entry* stack, std::size_t& top) {
    const FacetNode& node = group_.surface.levels[level - 1][place];
    HWY_ALIGN std::int32_t keys[FacetNode::size];
    std::uint64_t met = 0;
    for (std::size_t i = 0; i < FacetNode::size; i += float_lanes) {
      const VecF w_low = hn::Max(hn::Load(floats, node.low[group_.axis_w] + i), hn::Set(floats, group_.w_from));
      const VecF w_high = hn::Min(hn::Load(floats, node.high[group_.axis_w] + i), hn::Set(floats, group_.w_to));
      const VecF near = group_.sign < 0 ? hn::Neg(w_high) : w_low;
      MaskF in = hn::And(hn::Le(w_low, w_high), hn::Le(near, hn::Set(floats, group_.far)));
      for (int m = 0; m < 2; ++m) {
        const int axis = m == 0 ? group_.axis_u : group_.axis_v;
        const VecF low = hn::Load(floats, node.low[axis] + i), high = hn::Load(floats, node.high[axis] + i);
        const auto bound = [&](int l) HWY_ATTR {
          return hn::MulAdd(hn::Set(floats, group_.line_slope[l]), group_.line_slope[l] > 0 ? w_high : w_low,
                            hn::Set(floats, group_.line_offset[l]));
        };
        in = hn::And(in, hn::Ge(hn::Add(bound(2 * m), high), hn::Zero(floats)));
        in = hn::And(in, hn::Ge(hn::Sub(bound(2 * m + 1), low), hn::Zero(floats)));
      }
      hn::Store(keys_of(near), ints, keys + i);
      met |= bits_of(floats, in) << i;
    }
    const std::size_t bottom = top;
    for (; met != 0; met &= met - 1) {
      const auto child = static_cast<std::uint32_t>(std::countr_zero(met));
      const Entry added = entry_of(static_cast<std::uint32_t>(keys[child]), level - 1, FacetNode::size * place + child);
      std::size_t at = top++;
      for (; at > bottom && stack[at - 1] < added; --at) stack[at] = stack[at - 1];
      stack[at] = added;
    }
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

/// Calls act(axis, down, rays) for rays of a chunk that move most along one axis, one way.
template <class Act>
HWY_INLINE void for_each_direction(const Directions& directions, const Act& act) {
  for (int axis = 0; axis < 3; ++axis)
    for (const bool down : {false, true})
      if (const std::uint64_t chosen = directions.along[axis] & (down ? directions.down[axis] : ~directions.down[axis]);
          chosen != 0)
        act(axis, down, chosen);
}

template <FacetSearch search>
Answered first_facets(const FacetSurface& surface, const RayArrays& rays, std::size_t count, const HitArrays& hits,
                      FacetScratch& scratch, KernelCounters& counters) {
  const Directions directions =
      directions_of(surface, rays, count, search == FacetSearch::certified ? certified_reach : reach);
  Answered answered{.whole = directions.strange};
  scratch.doubt_count = 0;
  for_each_direction(directions, [&](int axis, bool down, std::uint64_t chosen) HWY_ATTR {
    FacetWalk<search> walk(surface, rays, count, hits, axis, down, scratch, counters);
    walk.trace(lanes_of(chosen));
    answered.hit |= walk.answered().hit;
    answered.whole |= walk.answered().whole;
    answered.part |= walk.answered().part;
  });
  answered.part &= ~answered.whole;
  return answered;
}

MetFacets any_facets(const FacetSurface& surface, const RayArrays& rays, std::size_t count, FacetScratch& scratch,
                     KernelCounters& counters) {
  const Directions directions = directions_of(surface, rays, count, reach);
  MetFacets met{.crossed = 0, .unanswered = directions.strange};
  for_each_direction(directions, [&](int axis, bool down, std::uint64_t chosen) HWY_ATTR {
    FacetWalk<FacetSearch::any> walk(surface, rays, count, {}, axis, down, scratch, counters);
    walk.trace(lanes_of(chosen));
    met.crossed |= rays_of(walk.crossed());
  });
  return met;
}

std::uint64_t all_facets(const FacetSurface& surface, const RayArrays& rays, std::size_t count, FacetLists& lists,
                         FacetScratch& scratch, KernelCounters& counters) {
  const Directions directions = directions_of(surface, rays, count, reach);
  scratch.lists = &lists;
  for_each_direction(directions, [&](int axis, bool down, std::uint64_t chosen) HWY_ATTR {
    FacetWalk<FacetSearch::all> walk(surface, rays, count, {}, axis, down, scratch, counters);
    walk.trace(lanes_of(chosen));
  });
  return directions.strange;
}

FirstFacets first_facets_by(bool certified) {
  return certified ? first_facets<FacetSearch::certified> : first_facets<FacetSearch::first>;
}
AnyFacets any_facets_by() {
  return any_facets;
}
CrossFacets all_facets_by() {
  return all_facets;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace rhoray::render::wide {

FirstFacets first_facets_on(Machine machine, bool certified) {
#if HWY_TARGETS & HWY_AVX3
  if (machine == Machine::avx512) return N_AVX3::first_facets_by(certified);
#endif
#if HWY_TARGETS & HWY_AVX2
  if (machine == Machine::avx2) return N_AVX2::first_facets_by(certified);
#endif
#if HWY_TARGETS & HWY_SSE4
  if (__builtin_cpu_supports("sse4.1")) return N_SSE4::first_facets_by(certified);
#endif
  return HWY_NAMESPACE::first_facets_by(certified);
}

AnyFacets any_facets_on(Machine machine) {
#if HWY_TARGETS & HWY_AVX3
  if (machine == Machine::avx512) return N_AVX3::any_facets_by();
#endif
#if HWY_TARGETS & HWY_AVX2
  if (machine == Machine::avx2) return N_AVX2::any_facets_by();
#endif
#if HWY_TARGETS & HWY_SSE4
  if (__builtin_cpu_supports("sse4.1")) return N_SSE4::any_facets_by();
#endif
  return HWY_NAMESPACE::any_facets_by();
}

CrossFacets cross_facets_on(Machine machine) {
#if HWY_TARGETS & HWY_AVX3
  if (machine == Machine::avx512) return N_AVX3::all_facets_by();
#endif
#if HWY_TARGETS & HWY_AVX2
  if (machine == Machine::avx2) return N_AVX2::all_facets_by();
#endif
#if HWY_TARGETS & HWY_SSE4
  if (__builtin_cpu_supports("sse4.1")) return N_SSE4::all_facets_by();
#endif
  return HWY_NAMESPACE::all_facets_by();
}

}  // namespace rhoray::render::wide

#endif

#include <bit>

#include "render/grid/all_hits/parts.h"
#include "render/traverse/ticks.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/grid/all_hits/all_hits.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once per machine

#include <hwy/highway.h>

#include "render/grid/all_hits/candidates-inl.h"
#include "render/grid/all_hits/hits-inl.h"
#include "render/grid/all_hits/slabs-inl.h"
#include "render/grid/isosurface/block_corners-inl.h"
#include "render/grid/isosurface/block_entry-inl.h"
#include "render/grid/isosurface/blocks_ahead-inl.h"
#include "render/grid/isosurface/cell_walk-inl.h"
#include "render/grid/isosurface/crossings-inl.h"
#include "render/grid/isosurface/cubic-inl.h"
#include "render/grid/isosurface/reading-inl.h"
#include "render/traverse/group-inl.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/on_machine.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// The kernel's work on one group, like GroupWalk of isosurface.cpp. Here a ray goes on behind its
/// crossings, on the other side, until it ends, its light is used up, or one of its lists is full.
template <int surfaces>
class AllHitsWalk {
 public:
  HWY_INLINE AllHitsWalk(const TransparentSurfaces& shells, const MirroredLattice& lattice, std::size_t first_ray,
                         const CrossingArrays* lists, std::uint8_t* complete, GridAllHitsScratch& scratch,
                         KernelCounters& counters)
      : shells_(shells),
        any_(shells.surface[0]),
        lattice_(lattice),
        ends_(lattice, any_.leaf_count),
        first_ray_(first_ray),
        lists_(lists),
        complete_(complete),
        scratch_(scratch),
        ways_(scratch.ways),
        group_(scratch.ways.group),
        counters_(counters),
        reading_(reading_of(any_.type)),
        has_values_(reading_.fetch_values != nullptr),
        corners_(lattice),
        hits_{{shells, 0, lattice, has_values_, lists, first_ray, scratch},
              {shells, 1, lattice, has_values_, lists, first_ray, scratch}},
        looks_(shells, ends_, corners_, has_values_, scratch, hits_, counters),
        alive_(group_.inside) {}

  HWY_INLINE void run(Frustum& frustum) {
    const VecI none = hn::Zero(ints);
    for (std::size_t r = 0; r < group_.count; r += float_lanes) {
      hn::Store(none, ints, ways_.visits + r);
      for (int s = 0; s < surfaces; ++s) hn::Store(none, ints, scratch_.count[s] + r);
    }
    prepare_ways(lattice_, ways_);
    prepare_places(lattice_, scratch_);
    clear(scratch_.ahead);
    UnionBits<surfaces> nodes, super_nodes;
    for (int s = 0; s < surfaces; ++s)
      nodes.of[s] = shells_.surface[s].nodes, super_nodes.of[s] = shells_.surface[s].super_nodes;
    int alive_in_frustum = std::popcount(alive_);
    BlocksExpected expected;
    walk_blocks(frustum, lattice_, nodes, super_nodes, [&](const int* block) HWY_ATTR {
      ask_for(block);
      if (expected.count == BlocksExpected::most) meet(expected.take());
      expected.add(block);
      if (alive_ == 0) return false;
      if (const int alive = std::popcount(alive_); 2 * alive < alive_in_frustum) {
        frustum = frustum_around(lattice_, group_, alive_);
        alive_in_frustum = alive;
      }
      return true;
    });
    while (expected.count != 0 && alive_ != 0) meet(expected.take());
    while (scratch_.ahead.count != 0) pass_next();
    for (int s = 0; s < surfaces; ++s) hits_[s].write();
    write_counts();
    for (std::uint64_t bits = full_; bits != 0; bits &= bits - 1)
      complete_[first_ray_ + group_.index[std::countr_zero(bits)]] = 0;
  }

 private:
  using RayLanes = AllHitsLanes<surfaces>;

  /// Writes the number of crossings of each ray, and the numbers of blocks and cells it has passed.
  HWY_INLINE void write_counts() {
    constexpr hn::Rebind<std::uint8_t, Ints> bytes;
    const GroupNumbers numbers(group_);
    VecI visits = hn::Zero(ints);
    for (std::size_t r = 0; r < group_.count; r += float_lanes) {
      const VecI of_rays = hn::Load(ints, ways_.visits + r);
      visits = hn::Add(visits, of_rays);
      for (int s = 0; s < surfaces; ++s) {
        numbers.write(bytes, hn::DemoteTo(bytes, hn::Load(ints, scratch_.count[s] + r)),
                      hn::FirstN(bytes, group_.count - r), r, lists_[s].count + first_ray_);
        if (!shells_.only_places)
          numbers.write(ints, of_rays, hn::FirstN(ints, group_.count - r), r,
                        reinterpret_cast<std::int32_t*>(lists_[s].hits[0].cost + first_ray_));
      }
    }
    counters_.macrocells_visited += blocks_;
    counters_.cells_visited += static_cast<std::uint64_t>(hn::GetLane(hn::SumOfLanes(ints, visits))) - blocks_;
  }

  HWY_INLINE bool has_bit(const IsosurfaceQuery& surface, const int* block) const {
    std::size_t node = 0;
    int bit = 0;
    for (int a = 2; a >= 0; --a) {
      node = node * static_cast<std::size_t>(lattice_.node_count[a]) + static_cast<std::size_t>(block[a] / 4);
      bit = 4 * bit + block[a] % 4;
    }
    return (surface.nodes[node] >> bit & 1) != 0;
  }

  HWY_INLINE KeptPlace kept_place(const int* mirrored, int* block) const {
    for (int a = 0; a < 3; ++a) block[a] = lattice_.block(a, mirrored[a]);
    return kept_place_of<AllHitsBlock>(block);
  }

  /// Prefetches the samples of a block that is not kept; they arrive while the blocks before it are
  /// passed.
  HWY_INLINE void ask_for(const int* mirrored) const {
    int block[3];
    const KeptPlace at = kept_place(mirrored, block);
    if (scratch_.block_key[at.place] != at.key) reading_.ask_for(any_.source, block);
  }

  HWY_INLINE const BlockSlabs& fetch(AllHitsBlock& ahead) {
    int block[3];  // not mirrored
    const KeptPlace at = kept_place(ahead.block, block);
    constexpr std::size_t floats_each = sizeof(BlockSamples) / sizeof(float);
    ahead.samples = static_cast<std::int32_t>(at.place * floats_each);
    if (scratch_.block_key[at.place] != at.key) {
      scratch_.block_key[at.place] = at.key;
      fetch_anew(block, at.place);
    }
    const SeenBlock& seen = scratch_.seen[at.place];
    for (int s = 0; s < surfaces; ++s) {
      ahead.is_seen[s] = seen.active[s] != 0;
      split(mirrored_bits(seen.active[s], lattice_.octant), ahead.active[s]);
      split(mirrored_bits(seen.inside[s], lattice_.octant), ahead.inside[s]);
    }
    return seen.slabs;
  }

  HWY_INLINE static void split(std::uint64_t bits, std::int32_t* words) {
    for (int w = 0; w < 2; ++w) words[w] = static_cast<std::int32_t>(bits >> (32 * w));
  }

  HWY_INLINE void fetch_anew(const int* block, std::size_t place) {
    BlockSamples& values = scratch_.blocks[0][place];
    if (has_values_) reading_.fetch_values(any_.source, block, values);
    const std::uint64_t present = existing_cells(any_.source, block);
    SeenBlock& kept = scratch_.seen[place];
    SeenInBlock seen[surfaces];
    const float* of_slabs = values.difference;
    double base = 0;
    for (int s = 0; s < surfaces; ++s) {
      const IsosurfaceQuery& surface = shells_.surface[s];
      // The surface is not in the block.
      seen[s] = {.active = 0, .inside = 0, .isovalue = surface.isovalue};
      if (surfaces == 1 || has_bit(surface, block)) {
        BlockSamples& samples = scratch_.blocks[has_values_ ? 0 : s][place];
        if (has_values_)
          find_active_cells(present, shells_.least_inside[s], samples);
        else
          reading_.fetch(surface.source, block, surface.isovalue, samples);
        seen[s].active = samples.active, seen[s].inside = samples.inside;
        if (!has_values_) of_slabs = samples.difference, base = surface.isovalue;
      }
      kept.active[s] = seen[s].active, kept.inside[s] = seen[s].inside;
    }
    for (SeenInBlock& of : seen) of.isovalue -= base;
    kept.slabs = slabs_of(of_slabs, present, seen);
  }

  HWY_INLINE void meet(const int* block) {
    HWY_ALIGN float enters[RayGroup::size], leaves[RayGroup::size];
    const std::uint64_t rays =
        rays_that_may_pass(ways_, alive_, block, [&](std::size_t r, VecF soonest, VecF latest) HWY_ATTR {
          hn::Store(soonest, floats, enters + r), hn::Store(latest, floats, leaves + r);
        });
    if (rays == 0) return;
    while (!fits(scratch_.ahead, block)) pass_next();
    AllHitsBlock& next = scratch_.ahead.block[scratch_.ahead.count];  // not added yet
    for (int a = 0; a < 3; ++a) next.block[a] = block[a], next.corner[a] = static_cast<float>(4 * block[a]);
    let_go_by<surfaces>(lattice_, scratch_, fetch(next), rays, enters, leaves, next);
    if (settle(next) == 0) return;
    add(scratch_.ahead, block, next.rays);
    while (alive_ != 0 && (alive_ & ~scratch_.ahead.rays) == 0) pass_next();
  }

  /// Lets the rays that have no other block before it skip a block, unless they come to its cells
  /// on another side than these cells. The list holds the blocks before it.
  /// @return  rays that are not done with it
  HWY_INLINE std::uint64_t settle(AllHitsBlock& block) {
    const std::uint64_t go_by = block.by & ~scratch_.ahead.rays;
    if (go_by == 0) return block.rays | block.by;
    block.by &= ~go_by;
    for (int s = 0; s < surfaces; ++s) {
      const std::uint64_t off = (inside_[s] & block.by_side[s][0]) | (~inside_[s] & block.by_side[s][1]);
      block.rays |= go_by & has_side_[s] & off;
      for (int side = 0; side < 2; ++side) went_by_[s][side] |= go_by & ~has_side_[s] & block.by_side[s][side];
      leave(went_by_[s][0] & went_by_[s][1]);
    }
    return block.rays | block.by;
  }

  /// Leaves rays to another kernel. They have skipped cells on one side and then come to, or skip,
  /// cells on the other side. It is not known whether a search in one of the skipped cells would
  /// have given them a side.
  HWY_INLINE void leave(std::uint64_t rays) { alive_ &= ~rays, full_ |= rays; }

  HWY_NOINLINE void pass_next() {
    pass_first_ahead(
        scratch_.ahead, alive_, group_.count, [](AllHitsBlock&) {},
        [&](std::size_t r, std::uint64_t lanes) HWY_ATTR { pass_taken_blocks(r, lanes); },
        [&](AllHitsBlock& block) { return settle(block); });
  }

  /// Lets some of the rays from r on pass the blocks that they have taken.
  HWY_INLINE void pass_taken_blocks(std::size_t r, std::uint64_t going) {
    RayLanes lanes;
    VecF corner[3], normal[3], ground, low, high;
    const VecI none = hn::Zero(ints);
    for (VecF* v : {&corner[0], &corner[1], &corner[2], &normal[0], &normal[1], &normal[2], &ground, &low, &high})
      *v = hn::Zero(floats);
    lanes.samples = none, lanes.error = hn::Zero(floats);
    for (int s = 0; s < surfaces; ++s) {
      lanes.seen_of[s] = none;
      for (int w = 0; w < 2; ++w) lanes.active_of[s][w] = lanes.inside_out_of[s][w] = none;
    }
    for (std::size_t b = 0; b < scratch_.ahead.count; ++b) {
      const AllHitsBlock& block = scratch_.ahead.block[b];
      const std::uint64_t takers = block.taken >> r & first_rays(float_lanes);
      if (takers == 0) continue;
      const MaskF mask = mask_of(floats, takers);
      const auto mask_i = hn::RebindMask(ints, mask);
      const auto put_float = [&](VecF& to, float number)
                                 HWY_ATTR { to = hn::IfThenElse(mask, hn::Set(floats, number), to); };
      for (int a = 0; a < 3; ++a) put_float(corner[a], block.corner[a]), put_float(normal[a], block.normal[a]);
      put_float(ground, block.ground), put_float(low, block.low), put_float(high, block.high);
      put_float(lanes.error, block.error);
      const auto put = [&](VecI& to, std::int32_t number)
                           HWY_ATTR { to = hn::IfThenElse(mask_i, hn::Set(ints, number), to); };
      put(lanes.samples, block.samples);
      for (int s = 0; s < surfaces; ++s) {
        if (!block.is_seen[s]) continue;
        put(lanes.seen_of[s], -1);
        for (int w = 0; w < 2; ++w) {
          put(lanes.active_of[s][w], block.active[s][w]);
          put(lanes.inside_out_of[s][w], block.inside[s][w]);
        }
      }
    }
    pass_blocks(lanes, r, going, corner, {normal, ground, low, high});
  }

  struct SlabLanes {
    const VecF* normal;
    VecF ground, low, high;
  };

  HWY_INLINE void pass_blocks(RayLanes& lanes, std::size_t r, std::uint64_t going, const VecF* corner,
                              const SlabLanes& slabs) {
    const BlockEntry at = entry_into_blocks(lattice_, ends_, ways_, r, mask_of(floats, going), corner);
    lanes.walking = at.passes;
    if (hn::AllFalse(floats, lanes.walking)) return;
    blocks_ += hn::CountTrue(floats, at.passes);
    for (int a = 0; a < 3; ++a) {
      lanes.entry[a] = at.entry[a];
      lanes.last[a] = at.last[a];
      lanes.slope[a] = hn::Load(floats, ways_.slope[a] + r);
      lanes.inverse_slope[a] = hn::Load(floats, ways_.inverse_slope[a] + r);
    }
    lanes.end = at.end;
    lanes.way_error = hn::Zero(floats);
    for (int s = 0; s < surfaces; ++s) {
      lanes.inside_of[s] = mask_of(floats, inside_[s] >> r);
      lanes.has_side_of[s] = mask_of(floats, has_side_[s] >> r);
    }
    pass_cells(lanes, r, corner, at.passes, BetweenSlabs(lanes, slabs.normal, slabs.ground, slabs.low, slabs.high));
  }

  HWY_INLINE void pass_cells(RayLanes& lanes, std::size_t r, const VecF* corner, MaskF passes,
                             const BetweenSlabs& between) {
    find_cells(lanes, between.from, between.to);
    const VecF visits = cells_passed(lanes);
    const bool is_at_border = !hn::AllFalse(floats, hn::And(lanes.walking, is_cut_off(ends_, corner)));
    const std::uint64_t ticks = any_.time_phases ? ticks_now() : 0;
    std::uint64_t ended = 0, full = 0;
    std::uint64_t went_by[surfaces][2];
    for (int s = 0; s < surfaces; ++s)
      for (int side = 0; side < 2; ++side) went_by[s][side] = went_by_[s][side] >> r;
    const std::uint64_t left = looks_.take(lanes, r, corner, between, went_by, is_at_border, ended, full);
    for (int s = 0; s < surfaces; ++s)
      for (int side = 0; side < 2; ++side) went_by_[s][side] |= (went_by[s][side] & first_rays(float_lanes)) << r;
    alive_ &= ~(ended << r);
    full_ |= full << r;
    lanes.walking = mask_of(floats, left);
    if (HWY_UNLIKELY(left != 0)) {
      find_cells(lanes);
      look_one_after_another(lanes, r, corner, is_at_border);
    }
    if (any_.time_phases) counters_.intersection_ticks += ticks_now() - ticks;
    const VecI cells = hn::IfThenElseZero(hn::RebindMask(ints, passes), hn::ConvertTo(ints, visits));
    const VecI all = hn::Add(hn::Load(ints, ways_.visits + r), hn::Add(cells, ones_in(passes)));
    hn::Store(all, ints, ways_.visits + r);
    const std::uint64_t here = first_rays(float_lanes) << r;
    for (int s = 0; s < surfaces; ++s) {
      inside_[s] = (inside_[s] & ~here) | bits_of(floats, lanes.inside_of[s]) << r;
      has_side_[s] = (has_side_[s] & ~here) | bits_of(floats, lanes.has_side_of[s]) << r;
    }
  }

  /// Searches the cells of some rays one after another, each with the side that the last one has
  /// led to.
  HWY_NOINLINE void look_one_after_another(RayLanes& lanes, std::size_t r, const VecF* corner, bool is_at_border) {
    const VecI zero = hn::Zero(ints);
    while (true) {
      VecI looks_of[surfaces][2], any[2] = {zero, zero};
      for (int s = 0; s < surfaces; ++s) {
        // In blocks that do not contain a surface, the cells' sides for it are not known.
        const MaskF known = hn::And(lanes.has_side_of[s], hn::RebindMask(floats, hn::Ne(lanes.seen_of[s], zero)));
        find_looks(lanes, lanes.active_of[s], lanes.inside_out_of[s], lanes.inside_of[s], known, looks_of[s]);
        for (int w = 0; w < 2; ++w) any[w] = hn::Or(any[w], looks_of[s][w]);
      }
      const NextCell next = take_first_of(lanes, any);
      lanes.walking = hn::And(lanes.walking, next.exists);
      if (hn::AllFalse(floats, lanes.walking)) break;
      MaskF looks = hn::And(lanes.walking, hn::Lt(next.way_in, next.way_out));
      if (is_at_border) looks = hn::And(looks, is_in_lattice(ends_, next, corner));
      if (hn::AllFalse(floats, looks)) continue;
      VecF in[3], out[3];
      ends_in_cell(lanes, next, in, out);
      Corners values;
      if (has_values_) values = corners_.of(next.cell, lanes.samples, scratch_.blocks[0], looks);
      MaskF found = no_lane(floats);
      for (int s = 0; s < surfaces; ++s) {
        const VecI word = hn::IfThenElse(next.in_second, looks_of[s][1], looks_of[s][0]);
        const MaskF here = hn::And(looks, hn::RebindMask(floats, hn::Ne(hn::And(word, next.bit), zero)));
        if (!hn::AllFalse(floats, here))
          found = hn::Or(found, look_into_cells(s, lanes, next, values, in, out, here, r, corner));
      }
      if (!hn::AllFalse(floats, found)) end_rays(lanes, found, r);
    }
  }

  /// Searches the cells of some lanes for a surface.
  /// @param values  at their corners, where they are kept
  /// @return        lanes that crossed it
  HWY_INLINE MaskF look_into_cells(int s, RayLanes& lanes, const NextCell& next, const Corners& values, const VecF* in,
                                   const VecF* out, MaskF looks, std::size_t r, const VecF* block_corner) {
    counters_.cells_solved += hn::CountTrue(floats, looks);
    const Corners corners = looks_.corners_less_isovalue(s, values, next.cell, lanes.samples, looks);
    const CubicLanes cubic = along(corners, in, out);
    MaskF& inside = lanes.inside_of[s];
    const MaskF sets_side = hn::AndNot(lanes.has_side_of[s], looks);
    inside = hn::Or(hn::AndNot(sets_side, inside), hn::And(sets_side, is_inside(cubic.b[0])));
    lanes.has_side_of[s] = hn::Or(lanes.has_side_of[s], looks);
    const MaskF side = inside;
    const Pieces pieces = pieces_of(cubic, side, looks);
    MaskF found = no_lane(floats);
    VecI root_count = hn::Zero(ints);
    for_each_change(cubic, pieces, side, [&](MaskF changed, VecF, VecF) HWY_ATTR {
      found = hn::Or(found, changed);
      inside = hn::Xor(inside, changed);
      root_count = hn::Add(root_count, ones_in(changed));
    });
    if (hn::AllFalse(floats, found)) return found;
    const FoundIn at{has_values_ ? values : corners, next, in, out, block_corner, r, s};
    VecI count = hn::Load(ints, scratch_.count[s] + r);
    for_each_change(cubic, pieces, side, [&](MaskF changed, VecF low, VecF high) HWY_ATTR {
      const MaskF has_room = hn::RebindMask(floats, hn::Lt(count, hn::Set(ints, std::int32_t{CrossingList::most})));
      full_ |= bits_of(floats, hn::AndNot(has_room, changed)) << r;
      const MaskF kept = hn::And(changed, has_room);
      if (hn::AllFalse(floats, kept)) return;
      hits_[s].keep(at, kept, low, high, count, root_count);
      count = hn::Add(count, ones_in(kept));
    });
    hn::Store(count, ints, scratch_.count[s] + r);
    return found;
  }

  /// Ends rays with a full list, and rays whose remaining light is too small.
  HWY_INLINE void end_rays(RayLanes& lanes, MaskF found, std::size_t r) {
    VecF light = hn::Set(floats, 1.0f);
    for (int s = 0; s < surfaces; ++s)
      light = hn::Mul(light, hn::GatherIndex(floats, shells_.passing[s], hn::Load(ints, scratch_.count[s] + r)));
    const MaskF dark = hn::Lt(light, hn::Set(floats, shells_.least_light));
    const std::uint64_t ended = bits_of(floats, hn::And(found, dark)) | (full_ >> r & first_rays(float_lanes));
    if (ended == 0) return;
    alive_ &= ~(ended << r);
    lanes.walking = hn::AndNot(mask_of(floats, ended), lanes.walking);
  }

  const TransparentSurfaces& shells_;
  const IsosurfaceQuery& any_;  ///< shared by all surfaces, except for isovalue and occupancy
  const MirroredLattice& lattice_;
  const LatticeEnds ends_;
  const std::size_t first_ray_;
  const CrossingArrays* const lists_;
  std::uint8_t* const complete_;
  GridAllHitsScratch& scratch_;
  IsosurfaceScratch& ways_;
  RayGroup& group_;
  KernelCounters& counters_;
  const Reading reading_;
  const bool has_values_;  ///< blocks are kept as values, not as differences
  const BlockCorners corners_;
  HitLists hits_[most_surfaces];  ///< by surface
  AllHitsCandidates<surfaces> looks_;
  std::uint64_t alive_;       ///< rays that go on
  std::uint64_t full_ = 0;    ///< rays with a crossing that was not recorded
  std::uint64_t blocks_ = 0;  ///< blocks passed by rays
  /// The side that each ray is on, if it has met data.
  std::uint64_t inside_[surfaces] = {}, has_side_[surfaces] = {};
  /// Rays that have skipped cells outside, or inside, before they had a side.
  std::uint64_t went_by_[surfaces][2] = {};
};

template <int surfaces>
HWY_INLINE void cross_some(const TransparentSurfaces& shells, const RayArrays& rays, std::size_t first,
                           std::size_t count, const CrossingArrays* lists, std::uint8_t* complete,
                           GridAllHitsScratch& scratch, KernelCounters& counters) {
  const IsosurfaceQuery& any = shells.surface[0];
  for_each_group(from(rays, first), count, any.leaf_count, any.node_count, scratch.ways.group,
                 [&](RayGroup&, const MirroredLattice& lattice, Frustum& frustum) HWY_ATTR {
                   AllHitsWalk<surfaces> walk(shells, lattice, first, lists, complete, scratch, counters);
                   walk.run(frustum);
                 });
}

void find_all_hits(const TransparentSurfaces& shells, const RayArrays& rays, std::size_t first, std::size_t count,
                   const CrossingArrays* lists, std::uint8_t* complete, GridAllHitsScratch& scratch,
                   KernelCounters& counters) {
  if (shells.count == 1)
    cross_some<1>(shells, rays, first, count, lists, complete, scratch, counters);
  else
    cross_some<2>(shells, rays, first, count, lists, complete, scratch, counters);
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace rhoray::render::wide {

FindAllHits find_all_hits_on(Machine machine) {
  RHORAY_RETURN_ON(machine, find_all_hits);
}

}  // namespace rhoray::render::wide

#endif

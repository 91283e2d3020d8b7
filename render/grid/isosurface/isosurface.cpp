#include <bit>

#include "render/grid/isosurface/parts.h"
#include "render/traverse/ticks.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/grid/isosurface/isosurface.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once per machine

#include <hwy/highway.h>

#include "render/grid/isosurface/block_corners-inl.h"
#include "render/grid/isosurface/block_entry-inl.h"
#include "render/grid/isosurface/block_search-inl.h"
#include "render/grid/isosurface/blocks_ahead-inl.h"
#include "render/grid/isosurface/cell_walk-inl.h"
#include "render/grid/isosurface/crossings-inl.h"
#include "render/grid/isosurface/cubic-inl.h"
#include "render/grid/isosurface/margins-inl.h"
#include "render/grid/isosurface/ray_states-inl.h"
#include "render/grid/isosurface/reading-inl.h"
#include "render/traverse/group-inl.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/on_machine.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// The kernel's work on one group. Rays stay in their lanes; blocks are assigned to lanes.
template <Search search>
class GroupWalk {
 public:
  HWY_INLINE GroupWalk(const IsosurfaceQuery& surface, const MirroredLattice& lattice, const RayArrays& rays,
                       const HitArrays& hits, IsosurfaceScratch& scratch, KernelCounters& counters)
      : surface_(surface),
        lattice_(lattice),
        ends_(lattice, surface.leaf_count),
        rays_(rays),
        hits_(hits),
        scratch_(scratch),
        group_(scratch.group),
        counters_(counters),
        reading_(reading_of(surface.source.type)),
        corners_(lattice),
        states_{.alive = scratch.group.inside} {
    for (int a = 0; a < 3; ++a) upward_[a] = lattice.is_mirrored(a) ? -1 : 1;
  }

  /// Where another kernel must take up a ray of the group that is in doubt.
  HWY_INLINE ResumedAt doubtful_from(std::size_t r) const { return states_.doubtful_from(r, scratch_.t_block[r]); }

  /// @return  rays of the group that another kernel must trace
  HWY_INLINE std::uint64_t run(Frustum& frustum) {
    for (std::size_t r = 0; r < group_.count; r += float_lanes) hn::Store(hn::Zero(ints), ints, scratch_.visits + r);
    prepare();
    clear(scratch_.ahead);
    int alive_in_frustum = std::popcount(states_.alive);
    if (states_.alive != 0)
      walk_blocks(frustum, lattice_, surface_.nodes, surface_.super_nodes, [&](const int* block) HWY_ATTR {
        meet(block);
        if (states_.alive == 0) return false;
        if (const int alive = std::popcount(states_.alive); 2 * alive < alive_in_frustum) {
          frustum = frustum_around(lattice_, group_, states_.alive);
          alive_in_frustum = alive;
        }
        return true;
      });
    pass_all_ahead();
    finish();
    return states_.doubtful;
  }

  /// The same for scattered rays that form the group, each on its own path. When half of them are
  /// done, the others may wait again.
  HWY_INLINE std::uint64_t run_scattered(WaitingRays& rays) {
    const std::uint64_t fresh = states_.alive & ~rays.under_way;
    prepare();
    std::uint64_t new_there = rays.new_there | fresh;
    states_.take_up(rays, fresh);
    BlockSearch blocks(surface_, lattice_, scratch_, search == Search::certified);
    const auto find_grazing = [this](std::size_t r, const int* block) HWY_ATTR { return pass_touched_block(r, block); };
    blocks.start(fresh & states_.alive, find_grazing);
    const int most_left = group_.count > float_lanes ? static_cast<int>(group_.count / 2) : 0;
    while (std::popcount(states_.alive) > most_left) {
      const std::uint64_t found = blocks.find_blocks(states_.alive, new_there, find_grazing);
      states_.alive = found | blocks.still_searching();
      for (std::size_t r = 0; r < group_.count; r += float_lanes)
        if (const std::uint64_t lanes = (found & states_.alive) >> r & first_rays(float_lanes); lanes != 0)
          pass_found_blocks(r, lanes);
      new_there &= ~found;
    }
    finish();
    rays.clear();
    for (std::uint64_t bits = states_.alive; bits != 0; bits &= bits - 1)
      wait(static_cast<std::size_t>(std::countr_zero(bits)), new_there, rays);
    return states_.doubtful;
  }

 private:
  HWY_INLINE void prepare() {
    prepare_ways(lattice_, scratch_);
    if constexpr (search == Search::certified) doubt(prepare_errors(group_, scratch_) & states_.alive);
    scratch_.pending.rays = 0;
    if (search != Search::certified && rays_.start_side != nullptr) states_.take_start_sides(rays_.start_side, group_);
  }

  HWY_INLINE void wait(std::size_t r, std::uint64_t new_there, WaitingRays& rays) const {
    const std::size_t lane = rays.rays.count++;
    copy_ray(group_, r, rays.rays, lane);
    const BlockSearchScratch& places = scratch_.scattered.search;
    rays.places.t[lane] = places.t[r], rays.places.error[lane] = places.error[r];
    for (int a = 0; a < 3; ++a) rays.places.block[a][lane] = places.block[a][r];
    rays.visits[lane] = scratch_.visits[r];
    states_.keep(r, rays, lane);
    rays.under_way |= std::uint64_t{1} << lane;
    rays.new_there |= (new_there >> r & 1) << lane;
  }

  HWY_INLINE void finish() {
    states_.touching = 0;
    doubt_from_block(HitWriter<search>(surface_, lattice_, rays_, hits_, scratch_).write());
    const GroupNumbers numbers(group_);
    for (std::size_t r = 0; r < group_.count; r += float_lanes)
      numbers.write(ints, hn::Load(ints, scratch_.visits + r), hn::FirstN(ints, group_.count - r), r,
                    reinterpret_cast<std::int32_t*>(hits_.cost));
  }

  HWY_INLINE void doubt(std::uint64_t rays) { states_.doubt(rays); }
  HWY_INLINE void doubt_from_block(std::uint64_t rays) { states_.doubt_from_block(rays, surface_.source.has_gaps); }

  HWY_INLINE void fetch(BlockAhead& ahead) {
    int block[3];  // not mirrored
    for (int a = 0; a < 3; ++a) block[a] = lattice_.block(a, ahead.block[a]);
    const KeptPlace at = kept_place_of<BlockAhead>(block);
    BlockSamples& samples = scratch_.blocks[at.place];
    if (scratch_.block_key[at.place] != at.key) {
      scratch_.block_key[at.place] = at.key;
      reading_.fetch(surface_.source, block, surface_.isovalue, samples);
    }
    constexpr std::size_t floats_each = sizeof(BlockSamples) / sizeof(float);
    ahead.samples = static_cast<std::int32_t>(at.place * floats_each);
    if constexpr (search == Search::certified) {
      if (samples.range != samples.range) find_range(surface_.source, samples);
      ahead.range = samples.range;
    }
    ahead.present = mirrored_bits(samples.present, lattice_.octant);
    ahead.active = mirrored_bits(samples.active, lattice_.octant);
    // The lowest corner is another one in the mirrored block, but in a cell that is not active all
    // corners lie on one side.
    ahead.inside = mirrored_bits(samples.inside, lattice_.octant);
  }

  /// Adds a block to those ahead, and lets the rays go on when each has one to pass.
  HWY_INLINE void meet(const int* block) {
    const std::uint64_t rays = rays_that_may_pass(scratch_, states_.alive, block);
    if (rays == 0) return;
    BlocksAhead& ahead = scratch_.ahead;
    while (!fits(ahead, block)) pass_next();
    add(ahead, block, rays).samples = -1;
    while (states_.alive != 0 && (states_.alive & ~ahead.rays) == 0) pass_next();
  }

  HWY_INLINE void pass_all_ahead() {
    while (scratch_.ahead.count != 0) pass_next();
  }

  HWY_NOINLINE void pass_next() {
    pass_first_ahead(
        scratch_.ahead, states_.alive, group_.count,
        [&](BlockAhead& block) {
          if (block.samples < 0) fetch(block);
        },
        // Inlined: a call for every 16 rays costs 7 % of a frame.
        [&](std::size_t r, std::uint64_t lanes) HWY_ATTR
        __attribute__((always_inline)) { pass_taken_blocks(r, lanes); });
  }

  /// Lets some of the rays from r on pass the blocks that they have taken.
  HWY_INLINE void pass_taken_blocks(std::size_t r, std::uint64_t going) {
    Lanes lanes;
    VecF corner[3];
    for (VecF& c : corner) c = hn::Zero(floats);
    for (int w = 0; w < 2; ++w) lanes.present[w] = lanes.active[w] = lanes.inside_out[w] = hn::Zero(ints);
    lanes.samples = hn::Zero(ints);
    lanes.range = hn::Zero(floats);
    const BlocksAhead& ahead = scratch_.ahead;
    for (std::size_t b = 0; b < ahead.count; ++b) {
      const BlockAhead& block = ahead.block[b];
      const std::uint64_t takers = block.taken >> r & first_rays(float_lanes);
      if (takers == 0) continue;
      const MaskF mask = mask_of(floats, takers);
      const auto mask_i = hn::RebindMask(ints, mask);
      for (int a = 0; a < 3; ++a)
        corner[a] = hn::IfThenElse(mask, hn::Set(floats, static_cast<float>(4 * block.block[a])), corner[a]);
      const auto put = [&](VecI& to, std::uint64_t number) HWY_ATTR {
        to = hn::IfThenElse(mask_i, hn::Set(ints, static_cast<std::int32_t>(number)), to);
      };
      put(lanes.samples, static_cast<std::uint64_t>(block.samples));
      if constexpr (search == Search::certified)
        lanes.range = hn::IfThenElse(mask, hn::Set(floats, block.range), lanes.range);
      for (int w = 0; w < 2; ++w) {
        if (surface_.source.has_gaps) put(lanes.present[w], block.present >> (32 * w));
        put(lanes.active[w], block.active >> (32 * w));
        put(lanes.inside_out[w], block.inside >> (32 * w));
      }
    }
    pass_blocks<false>(lanes, r, going, corner);
  }

  /// The same for blocks that the rays have found by themselves.
  HWY_NOINLINE void pass_found_blocks(std::size_t r, std::uint64_t going) {
    Lanes lanes;
    VecF corner[3];
    for (int a = 0; a < 3; ++a) corner[a] = hn::Load(floats, scratch_.scattered.search.corner[a] + r);
    for (int w = 0; w < 2; ++w) {
      lanes.active[w] = lanes.present[w] = hn::Set(ints, -1);
      lanes.inside_out[w] = hn::Zero(ints);
    }
    lanes.samples = hn::Zero(ints);
    pass_blocks<true>(lanes, r, going, corner);
  }

  /// Certified: the same for a ray that rounding may have kept from a block.
  /// @return  false where the ray is now in doubt
  HWY_NOINLINE bool pass_touched_block(std::size_t ray, const int* block) {
    const std::size_t lane = ray % float_lanes;
    for (int a = 0; a < 3; ++a) scratch_.scattered.search.corner[a][ray] = static_cast<float>(4 * block[a]);
    pass_found_blocks(ray - lane, std::uint64_t{1} << lane);
    return (states_.doubtful >> ray & 1) == 0;
  }

  template <bool is_scattered>
  HWY_INLINE void pass_blocks(Lanes& lanes, std::size_t r, std::uint64_t going, const VecF* corner) {
    const BlockEntry at = entry_into_blocks(lattice_, ends_, scratch_, r, mask_of(floats, going), corner);
    lanes.walking = at.passes;
    lanes.end = at.end;
    if constexpr (search == Search::certified) {
      // A grazed block is searched as it is from where the ray touches it: over a way of length
      // zero.
      const VecF size = hn::Abs(at.end);
      const MaskF touches =
          hn::And(mask_of(floats, going), hn::Not(hn::Gt(size, hn::Load(floats, scratch_.position_error + r))));
      states_.touching = bits_of(floats, touches) << r;
      if (states_.touching != 0) {
        const MaskF lost = hn::AndNot(hn::Le(size, hn::Set(floats, 1.0f)), touches);  // not finite
        doubt(bits_of(floats, lost) << r);
        lanes.walking = hn::AndNot(lost, hn::Or(at.passes, touches));
        lanes.end = hn::Max(at.end, hn::Zero(floats));
      }
    }
    if (hn::AllFalse(floats, lanes.walking)) return;
    counters_.macrocells_visited += hn::CountTrue(floats, at.passes);
    for (int a = 0; a < 3; ++a) {
      lanes.entry[a] = at.entry[a];
      lanes.last[a] = at.last[a];
      lanes.slope[a] = hn::Load(floats, scratch_.slope[a] + r);
      lanes.inverse_slope[a] = hn::Load(floats, scratch_.inverse_slope[a] + r);
    }
    lanes.way_error = hn::Zero(floats);
    if constexpr (search == Search::certified) lanes.way_error = error_of_ways(scratch_, at, lanes, r);
    lanes.inside = mask_of(floats, states_.inside >> r);
    lanes.has_side = mask_of(floats, states_.has_side >> r);
    pass_cells<is_scattered>(lanes, r, corner, at.passes);
  }

  template <bool is_scattered>
  HWY_INLINE void pass_cells(Lanes& lanes, std::size_t r, const VecF* corner, MaskF passes) {
    VecF visits = find_cells(lanes);
    if (surface_.source.has_gaps)
      for (int w = 0; w < 2; ++w) lanes.left[w] = hn::And(lanes.left[w], lanes.present[w]);
    const bool is_at_border = !hn::AllFalse(floats, hn::And(lanes.walking, is_cut_off(ends_, corner)));
    std::uint64_t solved = 0;
    while (true) {
      const NextCell next = take_next_cell(lanes);
      lanes.walking = hn::And(lanes.walking, next.exists);
      if (hn::AllFalse(floats, lanes.walking)) break;
      MaskF passes_cell = hn::Lt(next.way_in, next.way_out);
      // Also search cells where rounding may hide that the ray passes them.
      if constexpr (search == Search::certified)
        passes_cell = hn::Ge(hn::Sub(next.way_out, next.way_in), hn::Neg(lanes.way_error));
      MaskF looks = hn::And(lanes.walking, passes_cell);
      Corners corners;
      if (is_at_border) looks = hn::And(looks, is_in_lattice(ends_, next, corner));
      if (hn::AllFalse(floats, looks)) continue;
      if constexpr (is_scattered) {
        // Only now it is known which cells must be searched.
        corners = loaded_corners(next, corner, looks);
        looks = hn::And(looks, has_other_side(corners, lanes));
        if (hn::AllFalse(floats, looks)) continue;
      }
      solved += hn::CountTrue(floats, looks);
      const std::uint64_t ticks = surface_.time_phases ? ticks_now() : 0;
      if constexpr (!is_scattered) corners = corners_.of(next.cell, lanes.samples, scratch_.blocks, looks);
      const MaskF found = look_into_cells<is_scattered>(lanes, next, corners, looks, r, corner);
      if (surface_.time_phases) counters_.intersection_ticks += ticks_now() - ticks;
      VecF until = hn::Set(floats, 1.0f);
      for (int a = 0; a < 3; ++a) until = hn::Add(until, hn::Sub(next.cell[a], lanes.first_cell(a)));
      visits = hn::IfThenElse(found, until, visits);
      lanes.walking = hn::AndNot(found, lanes.walking);
    }
    counters_.cells_solved += solved;
    const VecI cells = hn::IfThenElseZero(hn::RebindMask(ints, passes), hn::ConvertTo(ints, visits));
    counters_.cells_visited += static_cast<std::uint64_t>(hn::GetLane(hn::SumOfLanes(ints, cells)));
    const VecI all = hn::Add(hn::Load(ints, scratch_.visits + r), hn::Add(cells, ones_in(passes)));
    hn::Store(all, ints, scratch_.visits + r);
    const std::uint64_t here = first_rays(float_lanes) << r;
    states_.inside = (states_.inside & ~here) | bits_of(floats, lanes.inside) << r;
    states_.has_side = (states_.has_side & ~here) | bits_of(floats, lanes.has_side) << r;
  }

  /// Removes the lanes that enter a cell on another side than they were on. Either they have come
  /// out of cells without data, which is no crossing, or rounding has hidden a change at an edge
  /// between cells. The reference kernel decides which.
  /// @param asked  the lanes of `looks` to test
  HWY_INLINE MaskF without_strays(Lanes& lanes, MaskF looks, MaskF asked, MaskF starts_inside, std::size_t r) {
    const MaskF strays = hn::And(asked, hn::And(lanes.has_side, hn::Xor(starts_inside, lanes.inside)));
    if (const std::uint64_t bits = bits_of(floats, strays); bits != 0) doubt(bits << r);
    lanes.walking = hn::AndNot(strays, lanes.walking);
    return hn::AndNot(strays, looks);
  }

  /// Removes the lanes that graze their cells. Such a cell does not matter if the field is on one
  /// side in all of its parts that the ray may pass, which must be the ray's own side if that is
  /// known. Otherwise the ray is in doubt.
  HWY_INLINE MaskF without_touched(Lanes& lanes, const NextCell& next, const Corners& corners, const CubicLanes& cubic,
                                   MaskF looks, std::size_t r) {
    const MaskF touched = hn::And(looks, hn::Le(hn::Sub(next.way_out, next.way_in), lanes.way_error));
    if (hn::AllFalse(floats, touched)) return looks;
    const MaskF side = hn::Or(hn::And(lanes.has_side, lanes.inside), hn::AndNot(lanes.has_side, is_inside(cubic.b[0])));
    const MaskF unclear =
        hn::And(touched, is_in_doubt(cubic, margin_of(corners, lanes.way_error), side, no_lane(floats)));
    if (const std::uint64_t bits = bits_of(floats, unclear); bits != 0) doubt_from_block(bits << r);
    lanes.walking = hn::AndNot(unclear, lanes.walking);
    return hn::AndNot(touched, looks);
  }

  /// For rays that start in a crossing: their first cubics begin on the known side, as in
  /// crossing_methods::on_side. Removes the lanes that do not get farther from the surface than the
  /// error of their starts. Removes also those that begin farther from it on the other side: they
  /// have come out of cells without data, as in without_strays.
  HWY_INLINE MaskF leave_crossings(Lanes& lanes, const Corners& corners, MaskF looks, CubicLanes& cubic,
                                   std::size_t r) {
    MaskF starts = hn::And(looks, mask_of(floats, states_.starting >> r));
    VecF low = corners.f[0], high = corners.f[0], farthest = hn::Zero(floats);
    for (int c = 1; c < 8; ++c) low = hn::Min(low, corners.f[c]), high = hn::Max(high, corners.f[c]);
    for (int i = 0; i < 4; ++i) farthest = hn::Max(farthest, hn::Abs(cubic.b[i]));
    const VecF near = hn::Mul(hn::Set(floats, static_cast<float>(start_error_cells)), hn::Sub(high, low));
    if (surface_.source.has_gaps) {
      const MaskF is_far = hn::And(starts, hn::Gt(hn::Abs(cubic.b[0]), near));
      looks = without_strays(lanes, looks, is_far, is_inside(cubic.b[0]), r);
      starts = hn::And(starts, looks);
    }
    const MaskF stays = hn::And(starts, hn::Le(farthest, near)), leaves = hn::AndNot(stays, starts);
    const VecF least = hn::IfThenElse(lanes.inside, hn::Zero(floats), hn::Set(floats, -0x1p-126F));
    const MaskF is_wrong = hn::Xor(is_inside(cubic.b[0]), lanes.inside);
    cubic.b[0] = hn::IfThenElse(hn::And(leaves, is_wrong), least, cubic.b[0]);
    states_.starting &= ~(bits_of(floats, leaves) << r);
    return hn::AndNot(stays, looks);
  }

  /// Reads corners of cells from the volume itself.
  HWY_INLINE Corners loaded_corners(const NextCell& next, const VecF* block_corner, MaskF asked) {
    CornersScratch& cells = scratch_.scattered.corners;
    for (int a = 0; a < 3; ++a) {
      const VecF mirrored = hn::Add(block_corner[a], next.cell[a]);
      const VecF end = hn::Set(floats, static_cast<float>(16 * lattice_.node_count[a]));
      hn::Store(hn::ConvertTo(ints, lattice_.is_mirrored(a) ? hn::Sub(end, mirrored) : mirrored), ints,
                cells.lowest[a]);
    }
    reading_.load_corners(surface_.source, upward_, surface_.isovalue, bits_of(floats, asked), cells);
    Corners corners;
    for (int c = 0; c < 8; ++c) corners.f[c] = hn::Load(floats, cells.difference[c]);
    return corners;
  }

  /// Cells with corners on both sides, or on the other side than the ray's.
  HWY_INLINE static MaskF has_other_side(const Corners& corners, const Lanes& lanes) {
    MaskF any = is_inside(corners.f[0]), all = any;
    for (int c = 1; c < 8; ++c) {
      const MaskF here = is_inside(corners.f[c]);
      any = hn::Or(any, here), all = hn::And(all, here);
    }
    const MaskF is_active = hn::AndNot(all, any);
    return hn::Or(is_active, hn::And(lanes.has_side, hn::Xor(all, lanes.inside)));
  }

  /// Certified: those lanes where the side at the entry, or the change, is not certain within the
  /// margin. The margin is that of all cells of the block, or the cell's own where that is not
  /// sufficient.
  template <bool is_scattered>
  HWY_INLINE MaskF doubtful_looks(const Lanes& lanes, const Corners& corners, const CubicLanes& cubic, MaskF looks,
                                  MaskF found) const {
    if constexpr (!is_scattered) {
      const VecF margin = margin_in_block(lanes.range, lanes.way_error);
      looks = hn::And(looks, is_in_doubt(cubic, margin, lanes.inside, found));
      if (HWY_LIKELY(hn::AllFalse(floats, looks))) return looks;
    }
    return hn::And(looks, is_in_doubt(cubic, margin_of(corners, lanes.way_error), lanes.inside, found));
  }

  /// Searches the cells of some lanes; returns which of them found a crossing.
  template <bool is_scattered>
  HWY_INLINE MaskF look_into_cells(Lanes& lanes, const NextCell& next, const Corners& corners, MaskF looks,
                                   std::size_t r, const VecF* block_corner) {
    VecF in[3], out[3];
    ends_in_cell(lanes, next, in, out);
    CubicLanes cubic = along(corners, in, out);
    if (search != Search::certified && states_.starting != 0) looks = leave_crossings(lanes, corners, looks, cubic, r);
    const MaskF starts_inside = is_inside(cubic.b[0]);
    if (search != Search::certified && surface_.source.has_gaps)
      looks = without_strays(lanes, looks, looks, starts_inside, r);
    if constexpr (search == Search::certified) looks = without_touched(lanes, next, corners, cubic, looks, r);
    const MaskF sets_side = hn::AndNot(lanes.has_side, looks);
    lanes.inside = hn::Or(hn::AndNot(sets_side, lanes.inside), hn::And(sets_side, starts_inside));
    lanes.has_side = hn::Or(lanes.has_side, looks);
    Changes changes = search == Search::preview ? changes_between_ends(cubic.b[0], cubic.b[3], lanes.inside, looks)
                                                : first_changes(cubic, lanes.inside, looks);
    if constexpr (search == Search::certified) {
      const MaskF doubtful = doubtful_looks<is_scattered>(lanes, corners, cubic, looks, changes.found);
      if (const std::uint64_t bits = bits_of(floats, doubtful); bits != 0) doubt_from_block(bits << r);
      lanes.walking = hn::AndNot(doubtful, lanes.walking);
      changes.found = hn::AndNot(doubtful, changes.found);
    }
    if (const std::uint64_t bits = bits_of(floats, changes.found); bits != 0) {
      keep_hits<search>(scratch_.pending, r, lanes, next, block_corner, corners, in, out, changes);
      states_.alive &= ~(bits << r);
    }
    return changes.found;
  }

  const IsosurfaceQuery& surface_;
  const MirroredLattice& lattice_;
  const LatticeEnds ends_;
  const RayArrays& rays_;
  const HitArrays& hits_;
  IsosurfaceScratch& scratch_;
  RayGroup& group_;
  KernelCounters& counters_;
  const Reading reading_;
  const BlockCorners corners_;
  RayStates states_;
  int upward_[3];  ///< from a cell's lower to its upper sample, in the lattice
};

/// Records rays of a group that are in doubt.
template <Search search>
HWY_INLINE void keep_doubtful(const GroupWalk<search>& walk, std::uint64_t rays, std::size_t first,
                              IsosurfaceScratch& scratch) {
  for (; rays != 0; rays &= rays - 1) {
    const auto r = static_cast<std::size_t>(std::countr_zero(rays));
    scratch.doubtful.ray[scratch.doubtful.count++] = {static_cast<std::uint32_t>(first) + scratch.group.index[r],
                                                      walk.doubtful_from(r)};
  }
}

/// Traces at least half of the waiting rays.
template <Search search>
HWY_NOINLINE void answer_most(const IsosurfaceQuery& surface, WaitingRays& waiting, const RayArrays& rays,
                              const HitArrays& hits, IsosurfaceScratch& scratch, KernelCounters& counters) {
  RayGroup& group = scratch.group;
  group = waiting.rays;
  for (std::size_t lane = group.count; lane % 16 != 0; ++lane) copy_ray(group, group.count - 1, group, lane);
  group.inside = first_rays(group.count);
  scratch.scattered.search = waiting.places;
  for (std::size_t r = 0; r < RayGroup::size; ++r)
    scratch.visits[r] = (waiting.under_way >> r & 1) != 0 ? waiting.visits[r] : 0;
  const MirroredLattice lattice(group.octant, surface.node_count);
  GroupWalk<search> walk(surface, lattice, rays, hits, scratch, counters);
  keep_doubtful(walk, walk.run_scattered(waiting), 0, scratch);
}

template <Search search>
void first_crossings(const IsosurfaceQuery& surface, const RayArrays& rays, std::size_t first, std::size_t count,
                     const HitArrays& hits, IsosurfaceScratch& scratch, KernelCounters& counters) {
  const RayArrays chunk = from(rays, first);
  const HitArrays answers = from(hits, first);
  const auto visit = [&](RayGroup&, const MirroredLattice& lattice, Frustum& frustum) HWY_ATTR {
    GroupWalk<search> walk(surface, lattice, chunk, answers, scratch, counters);
    keep_doubtful(walk, walk.run(frustum), first, scratch);
  };
  const auto scatter = [&](const RayGroup& group) HWY_ATTR {
    if (surface.source.has_gaps) return false;
    // Rays that are already in doubt are not traced twice.
    std::uint64_t joining = search == Search::certified ? group.inside & ~group.grazing : group.inside;
    WaitingRays& waiting = scratch.scattered.waiting[group.octant];
    const RayGroup* source = &group;
    for (; joining != 0; joining &= joining - 1) {
      if (waiting.rays.count == RayGroup::size) {
        if (source == &group) source = &(scratch.scattered.joining = group);
        answer_most<search>(surface, waiting, rays, hits, scratch, counters);
      }
      copy_ray(*source, static_cast<std::size_t>(std::countr_zero(joining)), waiting.rays, waiting.rays.count);
      waiting.rays.index[waiting.rays.count++] += static_cast<std::uint32_t>(first);
    }
    return true;
  };
  const std::uint64_t grazing =
      for_each_group(chunk, count, surface.leaf_count, surface.node_count, scratch.group, visit, scatter);
  if constexpr (search == Search::certified)
    for (std::uint64_t bits = grazing; bits != 0; bits &= bits - 1)
      scratch.doubtful.ray[scratch.doubtful.count++] = {
          static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(std::countr_zero(bits)), {}};
}

template <Search search>
void answer_waiting(const IsosurfaceQuery& surface, const RayArrays& rays, const HitArrays& hits,
                    IsosurfaceScratch& scratch, KernelCounters& counters) {
  for (WaitingRays& waiting : scratch.scattered.waiting)
    while (waiting.rays.count != 0) answer_most<search>(surface, waiting, rays, hits, scratch, counters);
}

template <Search search>
constexpr CrossingKernels kernels_of{first_crossings<search>, answer_waiting<search>};

CrossingKernels crossing_kernels(Search search) {
  switch (search) {
    case Search::preview:
      return kernels_of<Search::preview>;
    case Search::certified:
      return kernels_of<Search::certified>;
    case Search::bracketed:
      break;
  }
  return kernels_of<Search::bracketed>;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace rhoray::render::wide {

CrossingKernels crossing_kernels_on(Machine machine, Search search) {
  RHORAY_RETURN_ON(machine, crossing_kernels(search));
}

}  // namespace rhoray::render::wide

#endif

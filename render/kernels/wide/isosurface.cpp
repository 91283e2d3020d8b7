#include <bit>

#include "render/kernels/wide/isosurface_parts.h"
#include "render/march/ticks.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/kernels/wide/isosurface.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once per machine

#include <hwy/highway.h>

#include "render/kernels/wide/cubic-inl.h"
#include "render/kernels/wide/fetch-inl.h"
#include "render/kernels/wide/group-inl.h"
#include "render/kernels/wide/lanes-inl.h"
#include "render/kernels/wide/margins-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// An inverse slope of an axis along which the ray passes no plane, and the time of planes that are never passed.
inline constexpr float never_passed = 0x1p100f;

/// Bounds of a certified hit's place, in cells, that are good enough without a second look.
inline constexpr double largest_place_error = 1e-3;

using Fetch = void (*)(const SampleSource&, const int*, double, BlockSamples&);
Fetch fetch_of(formats::ElementType type) {
  switch (type) {
    case formats::ElementType::U8:
      return fetch_block<std::uint8_t>;
    case formats::ElementType::I8:
      return fetch_block<std::int8_t>;
    case formats::ElementType::U16:
      return fetch_block<std::uint16_t>;
    case formats::ElementType::I16:
      return fetch_block<std::int16_t>;
    case formats::ElementType::U32:
      return fetch_block<std::uint32_t>;
    case formats::ElementType::I32:
      return fetch_block<std::int32_t>;
    case formats::ElementType::F32:
      return fetch_block<float>;
    default:
      return fetch_block<double>;
  }
}

/// The kernel at work on one group.
template <Search search>
class GroupWalk {
 public:
  HWY_INLINE GroupWalk(const Surface& surface, const MirroredLattice& lattice, const RayArrays& rays,
                       const HitArrays& hits, IsosurfaceScratch& scratch, KernelCounters& counters)
      : surface_(surface),
        lattice_(lattice),
        rays_(rays),
        hits_(hits),
        scratch_(scratch),
        group_(scratch.group),
        counters_(counters),
        fetch_(fetch_of(surface.type)),
        alive_(scratch.group.inside) {
    for (int a = 0; a < 3; ++a) {
      const int stride = a == 0 ? 1 : a == 1 ? 5 : 25;
      stride_[a] = lattice.is_mirrored(a) ? -stride : stride;
      if (lattice.is_mirrored(a)) lowest_sample_ += 4 * stride;
    }
  }

  /// @return  rays of the group of which not every decision is proven
  HWY_INLINE std::uint64_t run(Frustum& frustum) {
    prepare_slopes();
    if constexpr (search == Search::certified) prepare_errors();
    for (std::size_t r = 0; r < group_.count; r += float_lanes) hn::Store(hn::Zero(ints), ints, scratch_.state + r);
    scratch_.pending.count = 0;
    int alive_in_frustum = std::popcount(alive_);
    if (alive_ != 0)
      walk_blocks(frustum, lattice_, surface_.nodes, surface_.summits, [&](const int* block) HWY_ATTR {
        pass_block(block);
        if (alive_ == 0) return false;
        if (const int alive = std::popcount(alive_); 2 * alive < alive_in_frustum) {
          frustum = frustum_around(lattice_, group_, alive_);
          alive_in_frustum = alive;
        }
        return true;
      });
    write_hits();
    for (std::size_t r = 0; r < group_.count; ++r)
      hits_.cost[group_.index[r]] = static_cast<std::uint32_t>(scratch_.state[r] / RayState::one_visit);
    return doubtful_;
  }

 private:
  HWY_INLINE void doubt(std::uint64_t rays) {
    doubtful_ |= rays;
    alive_ &= ~rays;
  }

  /// What double precision may put the points of a ray off by (point_error of grid_certified.h). Rays that pass no
  /// plane of an axis, but are so close to one that single precision does not tell the sides of it apart, are in doubt.
  HWY_INLINE void prepare_errors() {
    for (std::size_t r = 0; r < group_.count; r += double_lanes) {
      const VecD t = hn::Max(hn::Abs(hn::Load(doubles, group_.t_in + r)), hn::Abs(hn::Load(doubles, group_.t_out + r)));
      VecD reach = hn::Zero(doubles);
      MaskD is_close = hn::FirstN(doubles, 0);
      for (int a = 0; a < 3; ++a) {
        const VecD o = hn::Load(doubles, group_.origin[a] + r);
        reach = hn::Max(reach, hn::MulAdd(t, speed(group_, a, r), hn::Abs(o)));
        const MaskD moves = has_finite_inverse(hn::Load(doubles, group_.direction[a] + r));
        const VecD off_plane = hn::Abs(hn::Sub(o, hn::Round(o)));
        const MaskD near = hn::And(hn::Gt(off_plane, hn::Zero(doubles)), hn::Lt(off_plane, hn::Set(doubles, 0x1p-20)));
        is_close = hn::Or(is_close, hn::AndNot(moves, near));
      }
      const VecD error = hn::MulAdd(reach, hn::Set(doubles, 0x1p-49), hn::Set(doubles, 0x1p-52));
      hn::StoreU(hn::DemoteTo(half_floats, hn::Min(error, hn::Set(doubles, 1.0))), half_floats,
                 scratch_.position_error + r);
      doubt((bits_of(doubles, is_close) << r) & alive_);
    }
  }

  /// A ray's way is counted along the axis on which it moves fastest: by itself, whatever the group's axis is.
  HWY_INLINE void prepare_slopes() {
    for (std::size_t r = 0; r < group_.count; r += double_lanes) {
      VecD inverse[3], fastest = hn::Zero(doubles), t_per_way = hn::Set(doubles, 0x1p1000);
      for (int a = 0; a < 3; ++a) {
        inverse[a] = hn::Abs(hn::Load(doubles, group_.inverse[a] + r));
        fastest = hn::Max(fastest, speed(group_, a, r));
        t_per_way = hn::Min(t_per_way, inverse[a]);
      }
      hn::Store(fastest, doubles, scratch_.way_per_t + r);
      hn::Store(t_per_way, doubles, scratch_.t_per_way + r);
      for (int a = 0; a < 3; ++a) {
        hn::StoreU(hn::DemoteTo(half_floats, hn::Mul(speed(group_, a, r), t_per_way)), half_floats,
                   scratch_.slope[a] + r);
        const VecD moving = hn::Min(hn::Mul(fastest, inverse[a]), hn::Set(doubles, double{never_passed} / 2));
        const VecD inverse_slope = hn::IfThenElse(has_finite_inverse(hn::Load(doubles, group_.direction[a] + r)),
                                                  moving, hn::Set(doubles, double{never_passed}));
        hn::StoreU(hn::DemoteTo(half_floats, inverse_slope), half_floats, scratch_.inverse_slope[a] + r);
      }
    }
  }

  /// The place in a block's mirrored coordinates at which rays enter it; exact on the planes that they enter by.
  HWY_INLINE VecD entry_on(int axis, const int* block, std::size_t r, VecD t_in, VecD t_near) const {
    const VecD plane = hn::Set(doubles, lattice_.plane(axis, 4 * block[axis]));
    const VecD at =
        hn::MulAdd(t_in, hn::Load(doubles, group_.direction[axis] + r), hn::Load(doubles, group_.origin[axis] + r));
    const VecD within = lattice_.is_mirrored(axis) ? hn::Sub(plane, at) : hn::Sub(at, plane);
    return hn::IfThenElse(hn::Eq(t_near, t_in), hn::Set(doubles, static_cast<double>(first_plane_[axis])), within);
  }

  struct Entries {
    MaskD part;
    VecD entry[3], end;
  };

  /// Rays that pass so close to an edge of the block that rounding may have put them on the wrong side of it.
  HWY_INLINE void doubt_close_to_edges(std::size_t r, VecD t_in, VecD t_out, const VecD* near, const VecD* far) {
    MaskD close = may_be_exchanged(t_in, t_out), enters = no_lane(doubles), leaves = no_lane(doubles);
    for (int a = 0; a < 3; ++a) {
      const MaskD at_entry = may_be_exchanged(near[a], t_in), at_exit = may_be_exchanged(far[a], t_out);
      close = hn::Or(close, hn::Or(hn::And(enters, at_entry), hn::And(leaves, at_exit)));
      enters = hn::Or(enters, at_entry);
      leaves = hn::Or(leaves, at_exit);
    }
    close = hn::And(close, hn::Not(hn::Gt(t_in, hn::Add(t_out, hn::Mul(hn::Abs(t_out), hn::Set(doubles, 0x1p-49))))));
    if (const std::uint64_t rays = (bits_of(doubles, close) << r) & alive_; rays != 0) doubt(rays);
  }

  /// Which of some rays pass the block, and where they enter.
  HWY_INLINE Entries entries(const int* block, std::size_t r) {
    const VecD from = hn::Load(doubles, group_.t_in + r), to = hn::Load(doubles, group_.t_out + r);
    VecD t_in = from, t_out = to, near[3], far[3];
    for (int a = 0; a < 3; ++a) {
      const VecD o = hn::Load(doubles, group_.plane_origin[a] + r), inverse = hn::Load(doubles, group_.inverse[a] + r);
      near[a] = hn::Mul(hn::Sub(hn::Set(doubles, lattice_.plane(a, 4 * block[a] + first_plane_[a])), o), inverse);
      far[a] = hn::Mul(hn::Sub(hn::Set(doubles, lattice_.plane(a, 4 * block[a] + last_cell_[a] + 1)), o), inverse);
      t_in = hn::Max(t_in, near[a]);
      t_out = hn::Min(t_out, far[a]);
    }
    if constexpr (search == Search::certified) doubt_close_to_edges(r, t_in, t_out, near, far);
    Entries found;
    found.part = hn::And(hn::Lt(t_in, t_out), mask_of(doubles, alive_ >> r));
    if (hn::AllFalse(doubles, found.part)) return found;
    hn::BlendedStore(t_in, found.part, doubles, scratch_.t_block + r);
    for (int a = 0; a < 3; ++a) found.entry[a] = entry_on(a, block, r, t_in, near[a]);
    found.end = hn::Mul(hn::Sub(t_out, t_in), hn::Load(doubles, scratch_.way_per_t + r));
    return found;
  }

  /// The rays that pass the block, side by side.
  HWY_INLINE void list_rays(const int* block) {
    RaysInBlock& list = scratch_.rays_in_block;
    list.count = 0;
    for (std::size_t r = 0; r < group_.count; r += float_lanes) {
      if ((alive_ >> r & first_rays(float_lanes)) == 0) continue;
      MaskF part;
      VecF entry[3], end;
#if HWY_TARGET == HWY_SCALAR
      const Entries all = entries(block, r);
      part = mask_of(floats, bits_of(doubles, all.part));
      if (hn::AllFalse(floats, part)) continue;
      for (int a = 0; a < 3; ++a) entry[a] = hn::DemoteTo(floats, all.entry[a]);
      end = hn::DemoteTo(floats, all.end);
#else
      const Entries low = entries(block, r), high = entries(block, r + double_lanes);
      const std::uint64_t bits = bits_of(doubles, low.part) | bits_of(doubles, high.part) << double_lanes;
      if (bits == 0) continue;
      part = mask_of(floats, bits);
      for (int a = 0; a < 3; ++a)
        entry[a] =
            hn::Combine(floats, hn::DemoteTo(half_floats, high.entry[a]), hn::DemoteTo(half_floats, low.entry[a]));
      end = hn::Combine(floats, hn::DemoteTo(half_floats, high.end), hn::DemoteTo(half_floats, low.end));
#endif
      const std::size_t at = list.count;
      for (int a = 0; a < 3; ++a) {
        hn::StoreU(hn::Compress(entry[a], part), floats, list.entry[a] + at);
        hn::StoreU(hn::Compress(hn::Load(floats, scratch_.slope[a] + r), part), floats, list.slope[a] + at);
        hn::StoreU(hn::Compress(hn::Load(floats, scratch_.inverse_slope[a] + r), part), floats,
                   list.inverse_slope[a] + at);
      }
      hn::StoreU(hn::Compress(end, part), floats, list.end + at);
      if constexpr (search == Search::certified)
        hn::StoreU(hn::Compress(hn::Load(floats, scratch_.position_error + r), part), floats, list.position_error + at);
      const VecI rays = hn::Iota(ints, static_cast<std::int32_t>(r));
      hn::StoreU(hn::Compress(rays, hn::RebindMask(ints, part)), ints, list.ray + at);
      list.count += hn::CountTrue(floats, part);
    }
  }

  HWY_INLINE const BlockSamples& samples_of(const int* mirrored) {
    const int block[3] = {lattice_.block(0, mirrored[0]), lattice_.block(1, mirrored[1]),
                          lattice_.block(2, mirrored[2])};
    const auto x = static_cast<std::uint64_t>(block[0]), y = static_cast<std::uint64_t>(block[1]),
               z = static_cast<std::uint64_t>(block[2]);
    const std::uint64_t key = x | y << 21 | z << 42;
    const std::size_t place = (x & 7) | (y & 3) << 3 | (z & 3) << 5;
    BlockSamples& samples = scratch_.blocks[place];
    if (scratch_.block_key[place] != key) {
      scratch_.block_key[place] = key;
      fetch_(surface_.source, block, surface_.isovalue, samples);
    }
    return samples;
  }

  /// Which cells of the block the lattice has.
  HWY_INLINE void measure_block(const int* block) {
    for (int a = 0; a < 3; ++a) {
      const int outside = 16 * lattice_.node_count[a] - surface_.leaf_count[a] - 4 * block[a];
      const int existing = surface_.leaf_count[a] - 4 * block[a];
      first_plane_[a] = lattice_.is_mirrored(a) && outside > 0 ? outside : 0;
      last_cell_[a] = !lattice_.is_mirrored(a) && existing < 4 ? existing - 1 : 3;
    }
  }

  HWY_INLINE void pass_block(const int* block) {
    measure_block(block);
    list_rays(block);
    const RaysInBlock& list = scratch_.rays_in_block;
    if (list.count == 0) return;
    counters_.macrocells_visited += list.count;
    const BlockSamples& samples = samples_of(block);
    const std::uint64_t active = mirrored_bits(samples.active, lattice_.octant);
    if (active == 0) return;
    // The cell's lowest corner is another one in the mirrored block; in a cell that is not active all are of one side.
    const std::uint64_t inside = mirrored_bits(samples.inside, lattice_.octant);
    for (std::size_t first = 0; first < list.count; first += float_lanes)
      walk_cells(block, samples, active, inside, first);
  }

  /// Lanes of rays on their way through the cells of a block.
  struct Lanes {
    VecF entry[3], slope[3], inverse_slope[3], end;
    VecF cell[3];        ///< 0 to 3
    VecF next[3];        ///< how far on its way the next plane of each axis inside the block is
    VecF after_next[3];  ///< and the one after it: known early, steps do not wait for it
    VecF way_in;         ///< how far the ray is where it enters the cell
    VecI bit;            ///< of the cell
    VecF way_error;      ///< certified: of times of planes, on the way, and of the points there
    MaskF doubtful;
    VecI state;
    MaskF inside, has_side;
    MaskF walking;
  };

  /// How far the upper plane of cell `cell` of an axis is; those of the block's last cells are not passed inside.
  HWY_INLINE VecF way_to_plane(const Lanes& lanes, int axis, VecF cell) const {
    const VecF one = hn::Set(floats, 1.0f), never = hn::Set(floats, never_passed);
    const VecF at = hn::Mul(hn::Sub(hn::Add(cell, one), lanes.entry[axis]), lanes.inverse_slope[axis]);
    return hn::IfThenElse(hn::Ge(cell, hn::Set(floats, static_cast<float>(last_cell_[axis]))), never, at);
  }

  HWY_INLINE Lanes lanes_from(std::size_t first) const {
    const RaysInBlock& list = scratch_.rays_in_block;
    const VecF zero = hn::Zero(floats);
    Lanes lanes;
    lanes.walking = hn::FirstN(floats, list.count - first);
    for (int a = 0; a < 3; ++a) {
      lanes.slope[a] = hn::Load(floats, list.slope[a] + first);
      lanes.inverse_slope[a] = hn::Load(floats, list.inverse_slope[a] + first);
      // A ray in the lattice's upper face goes through the cells below it. Being kept from the plane beyond, it reaches
      // that plane at a time above 0, and one that does not move towards it never.
      const VecF end = hn::Set(floats, static_cast<float>(last_cell_[a] + 1) - 0x1p-22f);
      lanes.entry[a] = hn::Min(hn::Max(hn::Load(floats, list.entry[a] + first), zero), end);
      lanes.cell[a] = hn::Floor(lanes.entry[a]);
      lanes.next[a] = way_to_plane(lanes, a, lanes.cell[a]);
      lanes.after_next[a] = way_to_plane(lanes, a, hn::Add(lanes.cell[a], hn::Set(floats, 1.0f)));
    }
    lanes.end = hn::Load(floats, list.end + first);
    lanes.way_in = zero;
    if constexpr (search == Search::certified) find_errors(lanes, hn::Load(floats, list.position_error + first));
    const VecF bit = hn::MulAdd(lanes.cell[2], hn::Set(floats, 16.0f),
                                hn::MulAdd(lanes.cell[1], hn::Set(floats, 4.0f), lanes.cell[0]));
    lanes.bit = hn::NearestInt(bit);
    const VecI rays = hn::IfThenElseZero(hn::RebindMask(ints, lanes.walking), hn::Load(ints, list.ray + first));
    lanes.state = hn::GatherIndex(ints, scratch_.state, rays);
    lanes.state = hn::Add(lanes.state, hn::Set(ints, RayState::one_visit));
    lanes.inside = hn::RebindMask(floats, hn::TestBit(lanes.state, hn::Set(ints, RayState::inside)));
    lanes.has_side = hn::RebindMask(floats, hn::TestBit(lanes.state, hn::Set(ints, RayState::has_side)));
    return lanes;
  }

  /// What the times of planes inside the block, as parts of the way, and the ray's points at these times may be off by.
  ///
  /// An entry is rounded to single precision (2 u of up to 4), a slope and its inverse by u of themselves. So the way
  /// to a plane is off by at most 2 u times the inverse slope and 12 u (three roundings of a way of at most 4), and a
  /// point there by that and by 8 u more; what double precision does to the entry comes on top. Only axes count of
  /// which the ray may pass a plane inside. A ray that enters close to such a plane is in doubt: it may be on its other
  /// side.
  HWY_INLINE void find_errors(Lanes& lanes, VecF position_error) const {
    const VecF one = hn::Set(floats, 1.0f), close = hn::Set(floats, 0x1p-20f);
    VecF steepest = one;
    lanes.doubtful = no_lane(floats);
    for (int a = 0; a < 3; ++a) {
      const VecF leaves_at = hn::MulAdd(lanes.end, lanes.slope[a], lanes.entry[a]);
      const MaskF passes = hn::Ge(leaves_at, hn::Sub(hn::Add(lanes.cell[a], one), close));
      const VecF first = hn::Set(floats, static_cast<float>(first_plane_[a]) + 0.5f);
      const VecF last = hn::Set(floats, static_cast<float>(last_cell_[a]) + 0.5f);
      const MaskF inside = hn::Lt(lanes.cell[a], hn::Set(floats, static_cast<float>(last_cell_[a])));
      steepest = hn::Max(steepest, hn::IfThenElseZero(hn::And(passes, inside), lanes.inverse_slope[a]));
      const VecF plane = hn::Round(lanes.entry[a]);
      const MaskF inner_plane = hn::And(hn::Gt(plane, first), hn::Lt(plane, last));
      const MaskF moves = hn::Lt(lanes.inverse_slope[a], hn::Set(floats, never_passed));
      const VecF distance = hn::Abs(hn::Sub(lanes.entry[a], plane));
      const MaskF is_close =
          hn::Le(distance, hn::MulAdd(hn::Set(floats, 4.0f), position_error, hn::Set(floats, 4 * rounding_unit)));
      lanes.doubtful = hn::Or(lanes.doubtful, hn::And(moves, hn::And(inner_plane, is_close)));
    }
    const VecF in_single =
        hn::MulAdd(steepest, hn::Set(floats, 4 * rounding_unit), hn::Set(floats, 24 * rounding_unit));
    lanes.way_error = hn::MulAdd(hn::Mul(hn::Set(floats, 4.0f), position_error), steepest, in_single);
  }

  /// Lanes that leave the cell so close to a second plane that rounding may have exchanged the two.
  HWY_INLINE MaskF leave_close_to_edges(const Lanes& lanes) const {
    const VecF low_xy = hn::Min(lanes.next[0], lanes.next[1]), high_xy = hn::Max(lanes.next[0], lanes.next[1]);
    const VecF low_ze = hn::Min(lanes.next[2], lanes.end), high_ze = hn::Max(lanes.next[2], lanes.end);
    const VecF first = hn::Min(low_xy, low_ze);
    const VecF second = hn::Min(hn::Max(low_xy, low_ze), hn::Min(high_xy, high_ze));
    return hn::Le(hn::Sub(second, first), hn::Add(lanes.way_error, lanes.way_error));
  }

  /// How far the ray is where it leaves the cell.
  HWY_INLINE VecF way_out(const Lanes& lanes) const {
    return hn::Min(hn::Min(hn::Min(lanes.next[0], lanes.next[1]), lanes.next[2]), lanes.end);
  }

  /// Lets some lanes go on to their next cells.
  HWY_INLINE void step(Lanes& lanes, MaskF moved) const {
    const VecF one = hn::Set(floats, 1.0f);
    const VecF first = hn::Min(hn::Min(lanes.next[0], lanes.next[1]), lanes.next[2]);
    const MaskF along_x = hn::And(moved, hn::Eq(lanes.next[0], first)), not_x = hn::AndNot(along_x, moved);
    const MaskF along_y = hn::And(not_x, hn::Eq(lanes.next[1], first)), along_z = hn::AndNot(along_y, not_x);
    const MaskF along[3] = {along_x, along_y, along_z};
    const MaskF stays = hn::Lt(first, lanes.end);
    for (int a = 0; a < 3; ++a) {
      lanes.cell[a] = hn::IfThenElse(along[a], hn::Add(lanes.cell[a], one), lanes.cell[a]);
      lanes.next[a] = hn::IfThenElse(along[a], lanes.after_next[a], lanes.next[a]);
      lanes.after_next[a] = way_to_plane(lanes, a, hn::Add(lanes.cell[a], one));
    }
    lanes.bit = hn::Add(lanes.bit, hn::IfThenElseZero(hn::RebindMask(ints, along[0]), hn::Set(ints, 1)));
    lanes.bit = hn::Add(lanes.bit, hn::IfThenElseZero(hn::RebindMask(ints, along[1]), hn::Set(ints, 4)));
    lanes.bit = hn::Add(lanes.bit, hn::IfThenElseZero(hn::RebindMask(ints, along[2]), hn::Set(ints, 16)));
    lanes.way_in = hn::IfThenElse(moved, first, lanes.way_in);
    lanes.walking = hn::And(lanes.walking, hn::Or(stays, hn::Not(moved)));
  }

  /// The same, for lanes of which it is certain to which cells they go on; the others are in doubt.
  HWY_INLINE void go_on(Lanes& lanes, MaskF moved) const {
    if constexpr (search == Search::certified) {
      const MaskF close = hn::And(moved, leave_close_to_edges(lanes));
      lanes.doubtful = hn::Or(lanes.doubtful, close);
      lanes.walking = hn::AndNot(close, lanes.walking);
      moved = hn::AndNot(close, moved);
    }
    step(lanes, moved);
  }

  /// The points, in the cell's coordinates, at which the rays enter and leave it.
  HWY_INLINE void ends_in_cell(const Lanes& lanes, VecF way_out_of_cell, VecF* in, VecF* out) const {
    const VecF zero = hn::Zero(floats), one = hn::Set(floats, 1.0f);
    for (int a = 0; a < 3; ++a) {
      const auto place = [&](VecF way) HWY_ATTR {
        return hn::Min(hn::Max(hn::Sub(hn::MulAdd(way, lanes.slope[a], lanes.entry[a]), lanes.cell[a]), zero), one);
      };
      const VecF last_plane = hn::Mul(hn::Sub(lanes.cell[a], lanes.entry[a]), lanes.inverse_slope[a]);
      in[a] = hn::IfThenZeroElse(hn::Eq(last_plane, lanes.way_in), place(lanes.way_in));
      out[a] = hn::IfThenElse(hn::Eq(lanes.next[a], way_out_of_cell), one, place(way_out_of_cell));
    }
  }

  HWY_INLINE Corners corners_of(const Lanes& lanes, const BlockSamples& samples, MaskF asked) const {
    VecF place = hn::Set(floats, static_cast<float>(lowest_sample_));
    for (int a = 0; a < 3; ++a)
      place = hn::MulAdd(lanes.cell[a], hn::Set(floats, static_cast<float>(stride_[a])), place);
    const VecI index =
        hn::NearestInt(hn::IfThenElse(asked, place, hn::Set(floats, static_cast<float>(lowest_sample_))));
    Corners corners;
    for (int c = 0; c < 8; ++c) {
      const int offset = (c & 1 ? stride_[0] : 0) + (c & 2 ? stride_[1] : 0) + (c & 4 ? stride_[2] : 0);
      corners.f[c] = hn::GatherIndex(floats, samples.difference, hn::Add(index, hn::Set(ints, offset)));
    }
    return corners;
  }

  HWY_INLINE void walk_cells(const int* block, const BlockSamples& samples, std::uint64_t active, std::uint64_t inside,
                             std::size_t first) {
    Lanes lanes = lanes_from(first);
    // Cells to look into: the active ones, and those of the other side than the ray's.
    const std::uint64_t from_inside = active | ~inside, from_outside = active | inside;
    const auto words = [](std::uint64_t bits, int high)
                           HWY_ATTR { return hn::Set(ints, static_cast<std::int32_t>(bits >> (32 * high))); };
    VecI to_look[2];
    const auto choose_cells = [&]() HWY_ATTR {
      const auto is_inside_lane = hn::RebindMask(ints, lanes.inside), has_side = hn::RebindMask(ints, lanes.has_side);
      for (int high = 0; high < 2; ++high)
        to_look[high] = hn::IfThenElse(
            has_side, hn::IfThenElse(is_inside_lane, words(from_inside, high), words(from_outside, high)),
            words(active, high));
    };
    choose_cells();
    if constexpr (search == Search::certified) lanes.walking = hn::AndNot(lanes.doubtful, lanes.walking);
    const VecF start = hn::Add(hn::Add(lanes.cell[0], lanes.cell[1]), lanes.cell[2]);
    MaskF hit = no_lane(floats);
    std::uint64_t solved = 0;
    while (!hn::AllFalse(floats, lanes.walking)) {
      const VecI word = hn::IfThenElse(hn::Gt(lanes.bit, hn::Set(ints, 31)), to_look[1], to_look[0]);
      constexpr hn::RebindToUnsigned<Ints> unsigned_ints;
      const auto bits =
          hn::Shr(hn::BitCast(unsigned_ints, word), hn::BitCast(unsigned_ints, hn::And(lanes.bit, hn::Set(ints, 31))));
      const MaskF looks =
          hn::And(lanes.walking, hn::RebindMask(floats, hn::TestBit(hn::BitCast(ints, bits), hn::Set(ints, 1))));
      const MaskF passes = hn::AndNot(looks, lanes.walking);
      if (!hn::AllFalse(floats, passes)) {
        go_on(lanes, passes);
        continue;
      }
      solved += hn::CountTrue(floats, looks);
      const std::uint64_t ticks = surface_.time_phases ? ticks_now() : 0;
      const bool has_new_sides = !hn::AllFalse(floats, hn::AndNot(lanes.has_side, looks));
      const MaskF found = look_into_cells(block, samples, lanes, looks, first);
      if (surface_.time_phases) counters_.intersection_ticks += ticks_now() - ticks;
      hit = hn::Or(hit, found);
      lanes.walking = hn::AndNot(found, lanes.walking);
      if (has_new_sides) choose_cells();
      go_on(lanes, lanes.walking);
    }
    // A step changes one coordinate by 1; that of a ray that left the block led to a cell that it did not visit.
    const VecF last = hn::Add(hn::Add(lanes.cell[0], lanes.cell[1]), lanes.cell[2]);
    const MaskF used = hn::FirstN(floats, scratch_.rays_in_block.count - first);
    const VecI visits = hn::Add(hn::NearestInt(hn::IfThenElseZero(used, hn::Sub(last, start))), ones_in(hit));
    counters_.cells_visited += static_cast<std::uint64_t>(hn::GetLane(hn::SumOfLanes(ints, visits)));
    counters_.cells_solved += solved;
    keep_state(lanes, visits, first);
    if constexpr (search == Search::certified)
      for (std::uint64_t bits = bits_of(floats, hn::And(used, lanes.doubtful)); bits != 0; bits &= bits - 1)
        doubt(std::uint64_t{1} << scratch_.rays_in_block.ray[first + static_cast<std::size_t>(std::countr_zero(bits))]);
  }

  /// Searches the cells of some lanes; which of them found a crossing.
  HWY_INLINE MaskF look_into_cells(const int* block, const BlockSamples& samples, Lanes& lanes, MaskF looks,
                                   std::size_t first) {
    const VecF leaves = way_out(lanes);
    VecF in[3], out[3];
    ends_in_cell(lanes, leaves, in, out);
    const Corners corners = corners_of(lanes, samples, looks);
    const CubicLanes cubic = along(corners, in, out);
    const MaskF starts_inside = is_inside(cubic.b[0]);
    const MaskF sets_side = hn::AndNot(lanes.has_side, looks);
    lanes.inside = hn::Or(hn::AndNot(sets_side, lanes.inside), hn::And(sets_side, starts_inside));
    lanes.has_side = hn::Or(lanes.has_side, looks);
    Changes changes = search == Search::preview ? changes_between_ends(cubic.b[0], cubic.b[3], lanes.inside, looks)
                                                : first_changes(cubic, lanes.inside, looks);
    VecF margin = hn::Zero(floats);
    if constexpr (search == Search::certified) {
      margin = margin_of(corners, lanes.way_error);
      const MaskF doubtful = hn::And(looks, is_in_doubt(cubic, margin, lanes.inside, changes.found));
      lanes.doubtful = hn::Or(lanes.doubtful, doubtful);
      lanes.walking = hn::AndNot(doubtful, lanes.walking);
      changes.found = hn::AndNot(doubtful, changes.found);
    }
    if (!hn::AllFalse(floats, changes.found)) keep_hits(block, lanes, corners, leaves, in, out, margin, changes, first);
    return changes.found;
  }

  /// Adds crossings to those that are to be refined.
  HWY_INLINE void keep_hits(const int* block, const Lanes& lanes, const Corners& corners, VecF leaves, const VecF* in,
                            const VecF* out, VecF margin, const Changes& changes, std::size_t first) {
    PendingHits& pending = scratch_.pending;
    const std::size_t at = pending.count;
    const auto keep = [&](VecF numbers, float* to)
                          HWY_ATTR { hn::StoreU(hn::Compress(numbers, changes.found), floats, to + at); };
    const auto found = hn::RebindMask(ints, changes.found);
    for (int c = 0; c < 8; ++c) keep(corners.f[c], pending.corner[c]);
    for (int a = 0; a < 3; ++a) keep(in[a], pending.in[a]), keep(out[a], pending.out[a]);
    keep(lanes.way_in, pending.way_in);
    keep(leaves, pending.way_out);
    keep(changes.low, pending.low);
    keep(changes.high, pending.high);
    if constexpr (search == Search::certified) {
      keep(margin, pending.margin);
      keep(lanes.way_error, pending.way_error);
    }
    hn::StoreU(hn::Compress(changes.count, found), ints, pending.root_count + at);
    hn::StoreU(hn::Compress(hn::Load(ints, scratch_.rays_in_block.ray + first), found), ints, pending.ray + at);
    HWY_ALIGN std::int32_t bits[16];
    hn::StoreU(hn::Compress(lanes.bit, found), ints, bits);
    const std::size_t count = hn::CountTrue(floats, changes.found);
    for (std::size_t h = 0; h < count; ++h) {
      pending.cell[at + h] = cell_id(block, bits[h]);
      alive_ &= ~(std::uint64_t{1} << pending.ray[at + h]);
    }
    pending.count += count;
  }

  /// @param bit  of the cell in the mirrored block
  HWY_INLINE std::int64_t cell_id(const int* block, int bit) const {
    std::int64_t id = 0;
    for (int a = 2; a >= 0; --a) {
      int cell = 4 * block[a] + (bit >> (2 * a) & 3);
      if (lattice_.is_mirrored(a)) cell = 16 * lattice_.node_count[a] - 1 - cell;
      id = id * surface_.leaf_count[a] + cell;
    }
    return id;
  }

  /// Refines the places of all crossings found and writes them down.
  HWY_INLINE void write_hits() {
    const PendingHits& pending = scratch_.pending;
    for (std::size_t first = 0; first < pending.count; first += float_lanes) {
      Corners corners;
      VecF in[3], out[3], p[3], gradient[3];
      for (int c = 0; c < 8; ++c) corners.f[c] = hn::Load(floats, pending.corner[c] + first);
      for (int a = 0; a < 3; ++a) {
        in[a] = hn::Load(floats, pending.in[a] + first);
        out[a] = hn::Load(floats, pending.out[a] + first);
      }
      // Lanes beyond the last hit hold what was there before: any numbers, which are not used.
      const CubicLanes cubic = along(corners, in, out);
      const MaskF used = hn::FirstN(floats, pending.count - first);
      const VecF low = hn::IfThenElseZero(used, hn::Load(floats, pending.low + first));
      const VecF high = hn::IfThenElseZero(used, hn::Load(floats, pending.high + first));
      const Roots roots = search == Search::preview ? secant_step(cubic, high) : refined(cubic, low, high);
      const VecF rest = hn::Sub(hn::Set(floats, 1.0f), roots.s);
      for (int a = 0; a < 3; ++a) p[a] = between(in[a], out[a], roots.s, rest);
      gradient_at(corners, p, gradient);
      const VecF way_in = hn::Load(floats, pending.way_in + first), way_out = hn::Load(floats, pending.way_out + first);

      HWY_ALIGN float ways[16], gradients[3][16];
      HWY_ALIGN std::int32_t iterations[16];
      hn::Store(hn::MulAdd(roots.s, hn::Sub(way_out, way_in), way_in), floats, ways);
      for (int a = 0; a < 3; ++a)
        hn::Store(lattice_.is_mirrored(a) ? hn::Neg(gradient[a]) : gradient[a], floats, gradients[a]);
      hn::Store(roots.iterations, ints, iterations);
      HWY_ALIGN float way_errors[16];
      if constexpr (search == Search::certified) {
        const VecF s_error = error_of_root(cubic, hn::Load(floats, pending.margin + first), roots.s);
        const VecF way_error = hn::Load(floats, pending.way_error + first);
        hn::Store(hn::MulAdd(s_error, hn::Sub(way_out, way_in), hn::Add(way_error, way_error)), floats, way_errors);
      }
      const std::size_t end = pending.count - first < float_lanes ? pending.count - first : float_lanes;
      for (std::size_t h = 0; h < end; ++h) {
        const auto ray = static_cast<std::size_t>(pending.ray[first + h]);
        const std::size_t at = group_.index[ray];
        const double t = scratch_.t_block[ray] + ways[h] * scratch_.t_per_way[ray];
        if constexpr (search == Search::certified) {
          const double error = way_errors[h] * scratch_.t_per_way[ray] + 0x1p-49 * (t < 0 ? -t : t);
          // A ray's own ends are exact: a hit that may lie beyond them is not certain. Neither is one without a bound.
          double per_way = 0;  // squared: how far the ray moves while it moves by 1 along the major axis
          for (int a = 0; a < 3; ++a) per_way += double{scratch_.slope[a][ray]} * scratch_.slope[a][ray];
          const double place = way_errors[h];
          if (!(t - error >= rays_.t_min[at] && t + error <= rays_.t_max[at] &&
                place * place * per_way <= largest_place_error * largest_place_error)) {
            doubt(std::uint64_t{1} << ray);
            continue;
          }
          hits_.error[at] = error;
        }
        hits_.t[at] = t < group_.t_out[ray] ? t : group_.t_out[ray];
        hits_.value[at] = surface_.isovalue;
        for (int a = 0; a < 3; ++a) hits_.gradient[a][at] = gradients[a][h];
        hits_.cell[at] = static_cast<std::uint64_t>(pending.cell[first + h]);
        hits_.root_count[at] = static_cast<std::uint32_t>(pending.root_count[first + h]);
        hits_.iteration_count[at] = static_cast<std::uint32_t>(iterations[h]);
      }
    }
  }

  HWY_INLINE void keep_state(const Lanes& lanes, VecI visits, std::size_t first) {
    const auto bit = [&](MaskF mask, std::int32_t value)
                         HWY_ATTR { return hn::IfThenElseZero(hn::RebindMask(ints, mask), hn::Set(ints, value)); };
    VecI state = hn::AndNot(hn::Set(ints, RayState::one_visit - 1), lanes.state);
    state = hn::Or(state, hn::Or(bit(lanes.inside, RayState::inside), bit(lanes.has_side, RayState::has_side)));
    state = hn::Add(state, hn::Mul(visits, hn::Set(ints, RayState::one_visit)));
    HWY_ALIGN std::int32_t states[16];
    hn::Store(state, ints, states);
    const RaysInBlock& list = scratch_.rays_in_block;
    for (std::size_t lane = 0; lane < float_lanes && first + lane < list.count; ++lane)
      scratch_.state[list.ray[first + lane]] = states[lane];
  }

  const Surface& surface_;
  const MirroredLattice& lattice_;
  const RayArrays& rays_;
  const HitArrays& hits_;
  IsosurfaceScratch& scratch_;
  RayGroup& group_;
  KernelCounters& counters_;
  Fetch fetch_;
  std::uint64_t alive_;                ///< rays without a hit
  std::uint64_t doubtful_ = 0;         ///< rays that have left the group because not all is certain
  int stride_[3];                      ///< from a cell's lower to its upper sample, by mirrored axis
  int lowest_sample_ = 0;              ///< of the mirrored block
  int first_plane_[3], last_cell_[3];  ///< of the mirrored block, as far as the lattice has cells there
};

template <Search search>
std::uint64_t first_crossings(const Surface& surface, const RayArrays& rays, std::size_t count, const HitArrays& hits,
                              IsosurfaceScratch& scratch, KernelCounters& counters) {
  std::uint64_t doubtful = 0;
  for_each_group(rays, count, surface.leaf_count, surface.node_count, scratch.group,
                 [&](RayGroup& group, const MirroredLattice& lattice, Frustum& frustum) HWY_ATTR {
                   GroupWalk<search> walk(surface, lattice, rays, hits, scratch, counters);
                   for (std::uint64_t bits = walk.run(frustum); bits != 0; bits &= bits - 1)
                     doubtful |= std::uint64_t{1} << group.index[std::countr_zero(bits)];
                 });
  return search == Search::certified ? doubtful | scratch.group.grazing : 0;
}

FirstCrossings first_crossings_by(Search search) {
  switch (search) {
    case Search::preview:
      return first_crossings<Search::preview>;
    case Search::certified:
      return first_crossings<Search::certified>;
    case Search::bracketed:
      break;
  }
  return first_crossings<Search::bracketed>;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace rhoray::render::wide {

FirstCrossings first_crossings_on(Machine machine, Search search) {
#if HWY_TARGETS & HWY_AVX3
  if (machine == Machine::avx512) return N_AVX3::first_crossings_by(search);
#endif
#if HWY_TARGETS & HWY_AVX2
  if (machine == Machine::avx2) return N_AVX2::first_crossings_by(search);
#endif
#if HWY_TARGETS & HWY_SSE4
  if (__builtin_cpu_supports("sse4.1")) return N_SSE4::first_crossings_by(search);
#endif
  return HWY_NAMESPACE::first_crossings_by(search);
}

}  // namespace rhoray::render::wide

#endif

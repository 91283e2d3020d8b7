// Finds the next block of each ray of a group, for scattered rays.
#if defined(RHORAY_WIDE_BLOCK_SEARCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_BLOCK_SEARCH_INL_H
#undef RHORAY_WIDE_BLOCK_SEARCH_INL_H
#else
#define RHORAY_WIDE_BLOCK_SEARCH_INL_H
#endif

#include <bit>
#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/isosurface/block_entry-inl.h"
#include "render/grid/isosurface/parts.h"
#include "render/traverse/group-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

using Wholes = hn::RebindToSigned<Doubles>;
using VecW = hn::Vec<Wholes>;
inline constexpr Wholes wholes{};

/// Conversion of whole numbers from 0 to 2^52 - 1: added to 2^52 as a double, the number's bits are
/// the low bits.
HWY_INLINE VecW as_wholes(VecD x) {
  const VecD unit = hn::Set(doubles, 0x1p52);
  return hn::Xor(hn::BitCast(wholes, hn::Add(x, unit)), hn::BitCast(wholes, unit));
}
HWY_INLINE VecD from_wholes(VecW x) {
  const VecD unit = hn::Set(doubles, 0x1p52);
  return hn::Sub(hn::BitCast(doubles, hn::Or(x, hn::BitCast(wholes, unit))), unit);
}
HWY_INLINE VecW shifted_left(VecW x, VecW by) {
  constexpr hn::RebindToUnsigned<Wholes> bits;
  return hn::BitCast(wholes, hn::Shl(hn::BitCast(bits, x), hn::BitCast(bits, by)));
}
HWY_INLINE VecW shifted_right(VecW x, VecW by) {
  constexpr hn::RebindToUnsigned<Wholes> bits;
  return hn::BitCast(wholes, hn::Shr(hn::BitCast(bits, x), hn::BitCast(bits, by)));
}

/// Rays of one octant, each on its own path through the occupancy's trees: from the end of one
/// region without surface to the next, by plane times in double precision. A ray visits exactly
/// those blocks with a bit that it passes according to their plane times (entry_into_blocks), in
/// order along the ray.
class BlockSearch {
 public:
  HWY_INLINE BlockSearch(const IsosurfaceQuery& surface, const MirroredLattice& lattice, IsosurfaceScratch& scratch,
                         bool is_certified)
      : surface_(surface),
        lattice_(lattice),
        ends_(lattice, surface.leaf_count),
        group_(scratch.group),
        scratch_(scratch.scattered.search),
        way_per_t_(scratch.way_per_t),
        position_error_(scratch.position_error),
        is_certified_(is_certified) {
    for (int a = 0; a < 3; ++a) {
      const bool mirrored = lattice.is_mirrored(a);
      super_node_count_[a] = lattice.node_count[a] / 4;
      for (int child = 0; child < 4; ++child)
        scratch_.ahead[a][child] =
            static_cast<std::int64_t>(spread_bits(mirrored ? 0xfu >> child : 0xfu << child & 0xfu, a) *
                                      spread_bits(0xf, (a + 1) % 3) * spread_bits(0xf, (a + 2) % 3));
    }
  }

  /// Places rays where they enter the lattice, or start in it; other rays keep their positions.
  /// @param touch  certified: (ray, block), called for each block with a bit that the ray comes so
  ///               close to that rounding may have decided that it does not pass it; returns false
  ///               where the ray must go no further
  template <class Touch>
  HWY_INLINE void start(std::uint64_t rays, const Touch& touch) {
    rays_ = rays;
    for (std::size_t r = 0; r < group_.count; r += double_lanes) {
      if ((rays >> r & first_rays(double_lanes)) == 0) continue;
      const VecD from = hn::Load(doubles, group_.t_in + r), to = hn::Load(doubles, group_.t_out + r);
      const VecD longest = hn::Max(hn::Abs(from), hn::Abs(to));
      VecD reach = hn::Set(doubles, 1.0);
      Known known;
      VecW low[3], high[3];
      for (int a = 0; a < 3; ++a) {
        reach = hn::Max(reach, hn::MulAdd(longest, speed(group_, a, r), hn::Abs(origin(a, r))));
        const VecD border = hn::Set(doubles, ends_.first[a]);
        known.is[a] = hn::Eq(time_of(a, border, r), from);
        low[a] = known.block[a] = as_wholes(hn::Floor(hn::Mul(border, hn::Set(doubles, 0.25))));
        high[a] = hn::Set(wholes, 4 * lattice_.node_count[a] - 1);
      }
      const VecD error = hn::Mul(reach, hn::Set(doubles, 0x1p-46));
      hn::BlendedStore(hn::Min(error, hn::Set(doubles, 1.0)), mask_of(doubles, rays >> r), doubles, scratch_.error + r);
      Place place{from, {}};
      const MaskD asked = mask_of(doubles, rays >> r);
      locate(place, known, low, high, asked, r, touch);
      hn::BlendedStore(place.t, asked, doubles, scratch_.t + r);
      for (int a = 0; a < 3; ++a)
        hn::BlendedStore(place.block[a], hn::RebindMask(wholes, asked), wholes, scratch_.block[a] + r);
    }
  }

  /// Advances these rays until most have reached a block with a bit, or their end. A ray that is in
  /// such a block reaches it if it is new there. Stores the corners of the blocks.
  /// @param new_there  in and out: rays that are new in their block
  /// @return           rays that have reached a block
  template <class Touch>
  HWY_NOINLINE std::uint64_t find_blocks(std::uint64_t rays, std::uint64_t& new_there, const Touch& touch) {
    std::uint64_t found = 0;
    rays_ = rays;
    const int most_left = std::popcount(rays) / 4;
    while (std::popcount(rays_) > most_left)
      for (std::size_t r = 0; r < group_.count; r += double_lanes) {
        const std::uint64_t lanes = rays_ >> r & first_rays(double_lanes);
        if (lanes == 0) continue;
        const std::uint64_t come = step(r, lanes, new_there >> r, touch) << r;
        found |= come;
        rays_ &= ~come;
        new_there |= first_rays(double_lanes) << r;
      }
    for (std::size_t r = 0; r < group_.count; r += double_lanes)
      for (int a = 0; a < 3; ++a) {
        const VecW block = hn::Load(wholes, scratch_.block[a] + r);
        hn::Store(hn::DemoteTo(half_floats, from_wholes(hn::ShiftLeft<2>(block))), half_floats, scratch_.corner[a] + r);
      }
    return found;
  }

  /// Rays that are still on their way to the next block.
  HWY_INLINE std::uint64_t still_searching() const { return rays_; }

 private:
  struct Place {
    VecD t;
    VecW block[3];
  };

  /// Blocks on whose lower plane the ray is.
  struct Known {
    MaskD is[3];
    VecW block[3];
  };

  HWY_INLINE VecD position(int axis, VecD k) const {
    return lattice_.is_mirrored(axis) ? hn::Sub(hn::Set(doubles, lattice_.plane(axis, 0)), k) : k;
  }
  HWY_INLINE VecD origin(int axis, std::size_t r) const {
    return position(axis, hn::Load(doubles, group_.plane_origin[axis] + r));
  }
  HWY_INLINE VecD time_of(int axis, VecD plane, std::size_t r) const {
    return hn::Mul(hn::Sub(position(axis, plane), hn::Load(doubles, group_.plane_origin[axis] + r)),
                   hn::Load(doubles, group_.inverse[axis] + r));
  }
  HWY_INLINE VecD time_of_block(int axis, VecW block, std::size_t r) const {
    return time_of(axis, from_wholes(hn::ShiftLeft<2>(block)), r);
  }

  /// The bits of the children of a node (or super node) that a ray in child `at` can still reach,
  /// and of that child.
  HWY_INLINE VecW ahead(const VecW* at) const {
    VecW bits[3];
    for (int a = 0; a < 3; ++a) {
      const VecW child = hn::And(at[a], hn::Set(wholes, 3));
      if constexpr (double_lanes >= 4)
        bits[a] = hn::TableLookupLanes(hn::Load(wholes, scratch_.ahead[a]), hn::IndicesFromVec(wholes, child));
      else
        bits[a] = hn::GatherIndex(wholes, scratch_.ahead[a], child);
    }
    return hn::And(bits[0], hn::And(bits[1], bits[2]));
  }

  /// Words of a tree's level at given positions of the mirrored lattice.
  HWY_INLINE VecW words_at(const std::uint64_t* level, const int* count, const VecW* at, MaskD asked) const {
    VecD place = hn::Zero(doubles);
    for (int a = 2; a >= 0; --a) {
      const VecD mirrored = from_wholes(at[a]);
      const VecD stored =
          lattice_.is_mirrored(a) ? hn::Sub(hn::Set(doubles, static_cast<double>(count[a] - 1)), mirrored) : mirrored;
      place = hn::MulAdd(place, hn::Set(doubles, static_cast<double>(count[a])), stored);
    }
    return hn::GatherIndex(wholes, reinterpret_cast<const std::int64_t*>(level),
                           as_wholes(hn::IfThenElseZero(asked, place)));
  }

  /// Advances rays that are in no block with a bit, or have passed it, to the end of the region
  /// without other such blocks.
  /// @return  rays that have reached a block instead
  template <class Touch>
  HWY_INLINE std::uint64_t step(std::size_t r, std::uint64_t lanes, std::uint64_t new_there, const Touch& touch) {
    const MaskD asked = mask_of(doubles, lanes);
    Place place{hn::Load(doubles, scratch_.t + r), {}};
    VecW node_at[3], super_node_at[3];
    for (int a = 0; a < 3; ++a) {
      place.block[a] = hn::Load(wholes, scratch_.block[a] + r);
      node_at[a] = hn::ShiftRight<2>(place.block[a]);
      super_node_at[a] = hn::ShiftRight<4>(place.block[a]);
    }
    const VecW node = words_at(surface_.nodes, lattice_.node_count, node_at, asked);
    // Always read: a branch that is often mispredicted would cost more.
    const VecW super_node = words_at(surface_.super_nodes, super_node_count_, super_node_at, asked);
    const VecW three = hn::Set(wholes, 3);
    VecW bit = hn::And(place.block[0], three);
    bit = hn::Or(bit, hn::ShiftLeft<2>(hn::And(place.block[1], three)));
    bit = hn::Or(bit, hn::ShiftLeft<4>(hn::And(place.block[2], three)));
    const unsigned mirrored = lattice_.octant;
    bit = hn::Xor(bit, hn::Set(wholes, (mirrored & 1 ? 3 : 0) | (mirrored & 2 ? 12 : 0) | (mirrored & 4 ? 48 : 0)));
    const VecW one = hn::Set(wholes, 1);
    const MaskD has_bit = hn::RebindMask(doubles, hn::TestBit(shifted_right(node, bit), one));
    const MaskD come = hn::And(hn::And(asked, has_bit), mask_of(doubles, new_there));
    const MaskD goes = hn::AndNot(come, asked);
    const std::uint64_t found = bits_of(doubles, come);

    const VecW others = hn::And(hn::AndNot(shifted_left(one, bit), node), ahead(place.block));
    const auto none = hn::Eq(others, hn::Zero(wholes));
    VecW edge = hn::IfThenElseZero(none, three);  // edge of the region, in blocks, minus 1
    const auto no_node = hn::Eq(hn::And(super_node, ahead(node_at)), hn::Zero(wholes));
    edge = hn::IfThenElse(no_node, hn::Set(wholes, 15), edge);

    Known known;
    VecD t[3];
    for (int a = 0; a < 3; ++a) {
      known.block[a] = hn::Add(hn::Or(place.block[a], edge), one);
      t[a] = time_of_block(a, known.block[a], r);
    }
    Place next{hn::Min(t[0], hn::Min(t[1], t[2])), {}};
    for (int a = 0; a < 3; ++a) known.is[a] = hn::Eq(t[a], next.t);
    const VecD to = hn::Load(doubles, group_.t_out + r);
    const MaskD ends = hn::And(goes, hn::Ge(next.t, to));
    next.t = hn::Min(next.t, to);
    locate(next, known, place.block, known.block, goes, r, touch);
    hn::Store(hn::IfThenElse(goes, next.t, place.t), doubles, scratch_.t + r);
    for (int a = 0; a < 3; ++a)
      hn::Store(hn::IfThenElse(hn::RebindMask(wholes, goes), next.block[a], place.block[a]), wholes,
                scratch_.block[a] + r);
    rays_ &= ~(bits_of(doubles, ends) << r);
    return found;
  }

  /// Finds the blocks at place.t: by the ray's point and, where that is close to a plane, by the
  /// plane's time.
  /// @param low, high  bounds of the blocks
  template <class Touch>
  HWY_INLINE void locate(Place& place, const Known& known, const VecW* low, const VecW* high, MaskD asked,
                         std::size_t r, const Touch& touch) {
    const VecD error = hn::Load(doubles, scratch_.error + r);
    MaskD close = hn::Gt(error, hn::Set(doubles, 0.125));
    for (int a = 0; a < 3; ++a) {
      const VecD at = hn::Mul(hn::MulAdd(place.t, speed(group_, a, r), origin(a, r)), hn::Set(doubles, 0.25));
      const VecD within = hn::Min(hn::Max(hn::Floor(at), from_wholes(low[a])), from_wholes(high[a]));
      const MaskD is_near = hn::Le(hn::Abs(hn::Sub(at, hn::Round(at))), error);
      close = hn::Or(close, hn::AndNot(known.is[a], is_near));
      place.block[a] = hn::IfThenElse(hn::RebindMask(wholes, known.is[a]), known.block[a], as_wholes(within));
    }
    for (int a = 0; a < 3; ++a) close = hn::Or(close, hn::And(known.is[a], known.is[(a + 1) % 3]));
    close = hn::And(close, asked);
    if (hn::AllFalse(doubles, close)) return;
    locate_by_times(place, low, high, r);
    if (is_certified_) touch_blocks(place, bits_of(doubles, close), r, touch);
  }

  HWY_INLINE void locate_by_times(Place& place, const VecW* low, const VecW* high, std::size_t r) const {
    const VecW one = hn::Set(wholes, 1);
    for (int a = 0; a < 3; ++a)
      for (bool has_moved = true; has_moved;) {
        const VecW at = place.block[a];
        const auto is_after =
            hn::And(hn::RebindMask(wholes, hn::Gt(time_of_block(a, at, r), place.t)), hn::Gt(at, low[a]));
        const auto is_before = hn::And(hn::RebindMask(wholes, hn::Le(time_of_block(a, hn::Add(at, one), r), place.t)),
                                       hn::Lt(at, high[a]));
        place.block[a] = hn::Sub(hn::Add(at, hn::IfThenElseZero(is_before, one)), hn::IfThenElseZero(is_after, one));
        has_moved = !hn::AllFalse(wholes, hn::Or(is_after, is_before));
      }
  }

  template <class Touch>
  HWY_NOINLINE void touch_blocks(const Place& place, std::uint64_t lanes, std::size_t r, const Touch& touch) {
    HWY_ALIGN std::int64_t block[3][double_lanes];
    HWY_ALIGN double t[double_lanes];
    for (int a = 0; a < 3; ++a) hn::Store(place.block[a], wholes, block[a]);
    hn::Store(place.t, doubles, t);
    for (std::uint64_t bits = lanes; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      bool goes_on = true;
      for (int neighbour = 0; neighbour < 27 && goes_on; ++neighbour) {
        const int step[3] = {neighbour % 3 - 1, neighbour / 3 % 3 - 1, neighbour / 9 - 1};
        int at[3];
        for (int a = 0; a < 3; ++a) at[a] = static_cast<int>(block[a][lane]) + step[a];
        if (has_bit(at) && is_touched(at, r + lane, t[lane])) goes_on = touch(r + lane, at);
      }
      if (!goes_on) rays_ &= ~(std::uint64_t{1} << (r + lane));
    }
  }

  HWY_INLINE bool has_bit(const int* mirrored) const {
    std::size_t node = 0;
    int bit = 0;
    for (int a = 2; a >= 0; --a) {
      const int block = lattice_.block(a, mirrored[a]);
      if (block < 0 || block >= 4 * lattice_.node_count[a]) return false;
      node = node * static_cast<std::size_t>(lattice_.node_count[a]) + static_cast<std::size_t>(block / 4);
      bit = 4 * bit + block % 4;
    }
    return (surface_.nodes[node] >> bit & 1) != 0;
  }

  /// True where the ray leaves the block no later than it enters it, but rounding may have
  /// exchanged the two, at t. A block touched at another t is found there, or not at all.
  HWY_INLINE bool is_touched(const int* block, std::size_t ray, double t) const {
    double t_in = group_.t_in[ray], t_out = group_.t_out[ray];
    for (int a = 0; a < 3; ++a) {
      const double low = 4 * block[a] > ends_.first[a] ? 4 * block[a] : ends_.first[a];
      const double high = 4 * block[a] + 4 < ends_.last[a] ? 4 * block[a] + 4 : ends_.last[a];
      const auto time = [&](double k) {
        const double at = lattice_.is_mirrored(a) ? lattice_.plane(a, 0) - k : k;
        return (at - group_.plane_origin[a][ray]) * group_.inverse[a][ray];
      };
      const double enters = time(low), leaves = time(high);
      t_in = enters > t_in ? enters : t_in, t_out = leaves < t_out ? leaves : t_out;
    }
    const auto way = [&](double apart) { return static_cast<float>(apart * way_per_t_[ray]); };
    const auto is_within = [](float x, float error) { return !((x < 0 ? -x : x) > error); };
    // Up to three planes are passed one after another, each very close to the next.
    return !(t_in < t_out) && is_within(way(t_out - t_in), position_error_[ray]) &&
           is_within(way(t - t_in), 4 * position_error_[ray]);
  }

  const IsosurfaceQuery& surface_;
  const MirroredLattice& lattice_;
  const LatticeEnds ends_;
  const RayGroup& group_;
  BlockSearchScratch& scratch_;
  const double* const way_per_t_;
  const float* const position_error_;
  const bool is_certified_;
  int super_node_count_[3];
  std::uint64_t rays_ = 0;  ///< rays still on their way to the next block
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

// What is known about each ray of a group while it is followed: whether it goes on, which side it
// is on, what is in doubt.
#if defined(RHORAY_WIDE_RAY_STATES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_RAY_STATES_INL_H
#undef RHORAY_WIDE_RAY_STATES_INL_H
#else
#define RHORAY_WIDE_RAY_STATES_INL_H
#endif

#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/isosurface/parts.h"
#include "render/grid/reference/resumed.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// State flags, with a bit for each ray of a group.
struct RayStates {
  std::uint64_t alive;  ///< rays without a hit
  /// Rays that have left the group and must be traced by another kernel
  std::uint64_t doubtful = 0;
  std::uint64_t resumed = 0;  ///< of these, rays without a doubt before their last blocks
  /// The side that they are on there, if it is known
  std::uint64_t resumed_with_side = 0, resumed_inside = 0;
  /// Of the rays at work now, those that graze their blocks.
  std::uint64_t touching = 0;
  std::uint64_t inside = 0, has_side = 0;  ///< the side that each ray is on, if it has met data
  /// Rays that start in a crossing and have searched no cell yet.
  std::uint64_t starting = 0;

  HWY_INLINE void take_start_sides(const StartSide* sides, const RayGroup& group) {
    for (std::size_t r = 0; r < group.count; ++r) {
      const StartSide side = sides[group.index[r]];
      inside |= std::uint64_t{side == StartSide::inside} << r;
      has_side |= std::uint64_t{side != StartSide::unknown} << r;
    }
    starting = has_side;
  }

  HWY_INLINE void doubt(std::uint64_t rays) {
    doubtful |= rays;
    alive &= ~rays;
  }

  /// The same for rays that have no doubt before the blocks that they have entered last.
  /// @param has_gaps  of the data. Without gaps a ray stays on one side until it crosses, so its
  ///                  known side also holds where it entered the block
  HWY_INLINE void doubt_from_block(std::uint64_t rays, bool has_gaps) {
    doubt(rays);
    if (has_gaps) return;
    resumed |= rays & ~touching;
    resumed_with_side |= rays & has_side;
    resumed_inside |= rays & inside;
  }

  /// Where another kernel must take up a ray that is in doubt.
  /// @param t_block  where it entered its last block
  HWY_INLINE ResumedAt doubtful_from(std::size_t r, double t_block) const {
    ResumedAt from;
    const auto has = [r](std::uint64_t rays) { return (rays >> r & 1) != 0; };
    if (!has(resumed)) return from;
    from.t = t_block;
    if (has(resumed_with_side)) from.side = has(resumed_inside) ? StartSide::inside : StartSide::outside;
    return from;
  }

  /// Restores the states of rays that have waited; other rays keep their present states.
  /// @param fresh  the other rays
  HWY_INLINE void take_up(const WaitingRays& rays, std::uint64_t fresh) {
    inside = (inside & fresh) | rays.inside;
    has_side = (has_side & fresh) | rays.has_side;
    starting = (starting & fresh) | rays.starting;
  }

  /// Stores the state of a ray in a waiting list.
  HWY_INLINE void keep(std::size_t r, WaitingRays& rays, std::size_t lane) const {
    const auto take_bit = [&](std::uint64_t from, std::uint64_t& to) { to |= (from >> r & 1) << lane; };
    take_bit(inside, rays.inside), take_bit(has_side, rays.has_side), take_bit(starting, rays.starting);
  }
};

/// Computes the error of the points of a group's rays due to double precision (point_error of
/// render/grid/reference/certified.h), in cells, as needed by the search in single precision.
/// @return  rays whose error is too large, and rays that pass no plane of an axis but are so close
///          to one that its sides cannot be told apart in single precision
HWY_INLINE std::uint64_t prepare_errors(const RayGroup& group, IsosurfaceScratch& scratch) {
  std::uint64_t doubtful = 0;
  for (std::size_t r = 0; r < group.count; r += double_lanes) {
    const VecD t = hn::Max(hn::Abs(hn::Load(doubles, group.t_in + r)), hn::Abs(hn::Load(doubles, group.t_out + r)));
    VecD farthest = hn::Zero(doubles);
    MaskD is_close = no_lane(doubles);
    for (int a = 0; a < 3; ++a) {
      const VecD o = hn::Load(doubles, group.origin[a] + r);
      farthest = hn::Max(farthest, hn::Abs(o));
      const MaskD moves = has_finite_inverse(hn::Load(doubles, group.direction[a] + r));
      if (hn::AllTrue(doubles, moves)) continue;
      const VecD off_plane = hn::Abs(hn::Sub(o, hn::Round(o)));
      const MaskD near = hn::And(hn::Gt(off_plane, hn::Zero(doubles)), hn::Lt(off_plane, hn::Set(doubles, 0x1p-20)));
      is_close = hn::Or(is_close, hn::AndNot(moves, near));
    }
    const VecD reach = hn::MulAdd(t, hn::Load(doubles, scratch.way_per_t + r), farthest);
    const VecD error = hn::MulAdd(reach, hn::Set(doubles, 0x1p-49), hn::Set(doubles, 0x1p-52));
    hn::StoreU(hn::DemoteTo(half_floats, hn::Min(error, hn::Set(doubles, 1.0))), half_floats,
               scratch.position_error + r);
    const MaskD is_small = hn::Le(error, hn::Set(doubles, 0x1p-21));
    doubtful |= bits_of(doubles, hn::Or(is_close, hn::Not(is_small))) << r;
  }
  for (std::uint64_t& rays : scratch.slow) rays = 0;
  for (std::size_t r = 0; r < group.count; r += float_lanes) {
    VecF steepest = hn::Zero(floats);
    for (int a = 0; a < 3; ++a) {
      const VecF inverse = hn::Load(floats, scratch.inverse_slope[a] + r);
      const MaskF is_slow = hn::Gt(inverse, hn::Set(floats, slow_from));
      steepest = hn::Max(steepest, hn::IfThenZeroElse(is_slow, inverse));
      scratch.slow[a] |= bits_of(floats, hn::And(is_slow, hn::Lt(inverse, hn::Set(floats, never_passed)))) << r;
    }
    hn::Store(steepest, floats, scratch.steepest + r);
  }
  return doubtful;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

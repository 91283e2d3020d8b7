// How rays become groups: sorted by octant, clipped to the lattice, and enclosed in a frustum.
#if defined(RHORAY_WIDE_GROUP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_GROUP_INL_H
#undef RHORAY_WIDE_GROUP_INL_H
#else
#define RHORAY_WIDE_GROUP_INL_H
#endif

#include <array>
#include <bit>
#include <cstdint>

#include <hwy/highway.h>

#include "render/traverse/frustum_walk.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/octant.h"
#include "render/traverse/ray_group.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

inline constexpr std::uint64_t all_rays = ~std::uint64_t{0};
HWY_INLINE std::uint64_t first_rays(std::size_t count) {
  return count >= 64 ? all_rays : (std::uint64_t{1} << count) - 1;
}

/// Properties of a chunk's directions, a bit per ray.
struct Directions {
  std::uint64_t down[3];   ///< moves towards lower planes
  std::uint64_t steep[3];  ///< moves along the axis at least a quarter as fast as along any other
  std::uint64_t fastest[3];
  std::uint64_t usable;  ///< finite, and moves
};

/// True where 1 / d is finite; otherwise a ray passes no plane of this axis (PlaneTimesOf).
HWY_INLINE MaskD has_finite_inverse(VecD d) {
  return hn::Gt(hn::Abs(d), hn::Set(doubles, 0x1p-1024));
}

HWY_INLINE Directions directions_of(const RayArrays& rays, std::size_t count) {
  Directions bits{};
  for (std::size_t r = 0; r < count; r += double_lanes) {
    VecD size[3];
    MaskD finite = hn::FirstN(doubles, count - r), moves = no_lane(doubles);
    for (int a = 0; a < 3; ++a) {
      const VecD d = hn::Load(doubles, rays.direction[a] + r);
      const MaskD steps = has_finite_inverse(d);
      finite = hn::And(finite, hn::And(is_finite(d), is_finite(hn::Load(doubles, rays.origin[a] + r))));
      moves = hn::Or(moves, steps);
      bits.down[a] |= bits_of(doubles, hn::And(steps, hn::Lt(d, hn::Zero(doubles)))) << r;
      size[a] = hn::Abs(d);
    }
    const VecD most = hn::Max(hn::Max(size[0], size[1]), size[2]), least = hn::Mul(hn::Set(doubles, 0.25), most);
    for (int a = 0; a < 3; ++a) {
      bits.steep[a] |= bits_of(doubles, hn::Ge(size[a], least)) << r;
      bits.fastest[a] |= bits_of(doubles, hn::Ge(size[a], most)) << r;
    }
    bits.usable |= bits_of(doubles, hn::And(finite, moves)) << r;
  }
  return bits;
}

/// Those rays of `remaining` in the octant of its first ray for which one common axis is steep. At
/// least that first ray.
struct ChosenRays {
  std::uint64_t rays;
  unsigned octant;
  int major;
};
HWY_INLINE ChosenRays rays_of_one_octant(const Directions& directions, std::uint64_t remaining) {
  const int first = std::countr_zero(remaining);
  ChosenRays chosen{remaining, 0, 0};
  for (int a = 0; a < 3; ++a) {
    const bool down = (directions.down[a] >> first & 1) != 0;
    chosen.octant |= static_cast<unsigned>(down) << a;
    chosen.rays &= down ? directions.down[a] : ~directions.down[a];
  }
  int most = -1;
  for (int a = 0; a < 3; ++a) {
    if ((directions.steep[a] >> first & 1) == 0) continue;
    // Among axes that are steep for equally many rays, prefer the one that is fastest for more.
    const int steep = std::popcount(chosen.rays & directions.steep[a]),
              fastest = std::popcount(chosen.rays & directions.fastest[a]);
    if (const int score = 128 * steep + fastest; score > most) most = score, chosen.major = a;
  }
  chosen.rays &= directions.steep[chosen.major];
  return chosen;
}

/// Copies these rays of a chunk into the group, from its first lane on.
HWY_INLINE void gather_rays(const RayArrays& rays, std::uint64_t chosen, RayGroup& group) {
  group.count = static_cast<std::size_t>(std::popcount(chosen));
  group.is_in_order = chosen == first_rays(group.count);
  if (group.is_in_order) {
    for (std::size_t r = 0; r < group.count; r += double_lanes) {
      for (int a = 0; a < 3; ++a) {
        hn::Store(hn::Load(doubles, rays.origin[a] + r), doubles, group.origin[a] + r);
        hn::Store(hn::Load(doubles, rays.direction[a] + r), doubles, group.direction[a] + r);
      }
      hn::Store(hn::Load(doubles, rays.t_min + r), doubles, group.t_in + r);
      hn::Store(hn::Load(doubles, rays.t_max + r), doubles, group.t_out + r);
    }
    for (std::uint32_t r = 0; r < group.count; ++r) group.index[r] = r;
  } else {
    std::size_t lane = 0;
    for (std::uint64_t bits = chosen; bits != 0; bits &= bits - 1, ++lane) {
      const int r = std::countr_zero(bits);
      for (int a = 0; a < 3; ++a) {
        group.origin[a][lane] = rays.origin[a][r];
        group.direction[a][lane] = rays.direction[a][r];
      }
      group.t_in[lane] = rays.t_min[r];
      group.t_out[lane] = rays.t_max[r];
      group.index[lane] = static_cast<std::uint32_t>(r);
    }
  }
  for (std::size_t lane = group.count; lane % 16 != 0; ++lane) {
    for (int a = 0; a < 3; ++a) {
      group.origin[a][lane] = group.origin[a][group.count - 1];
      group.direction[a][lane] = group.direction[a][group.count - 1];
    }
    group.t_in[lane] = group.t_in[group.count - 1];
    group.t_out[lane] = group.t_out[group.count - 1];
    group.index[lane] = group.index[group.count - 1];
  }
}

/// Copies a clipped ray of a group into a lane of another group.
HWY_INLINE void copy_ray(const RayGroup& from, std::size_t ray, RayGroup& to, std::size_t lane) {
  for (int a = 0; a < 3; ++a) {
    to.origin[a][lane] = from.origin[a][ray], to.direction[a][lane] = from.direction[a][ray];
    to.plane_origin[a][lane] = from.plane_origin[a][ray], to.inverse[a][lane] = from.inverse[a][ray];
  }
  to.t_in[lane] = from.t_in[ray], to.t_out[lane] = from.t_out[ray];
  to.index[lane] = from.index[ray];
}

/// True where two times lie so close together that rounding may have exchanged them
/// (WalkRounding::may_be_exchanged), or where they are not finite numbers.
HWY_INLINE MaskD may_be_exchanged(VecD a, VecD b) {
  const VecD largest = hn::Max(hn::Abs(a), hn::Abs(b));
  return hn::Not(hn::Gt(hn::Abs(hn::Sub(a, b)), hn::Mul(hn::Set(doubles, 0x1p-50), largest)));
}

/// Computes plane origins, inverses and the parts inside the lattice, with the results of
/// clip_to_lattice.
HWY_INLINE void clip_group(const int* leaf_count, RayGroup& group) {
  const VecD zero = hn::Zero(doubles), half = hn::Set(doubles, 0.5);
  // An inverse with which no plane ahead is ever reached.
  const VecD never = hn::Set(doubles, 0x1p960);
  group.inside = 0, group.grazing = 0;
  for (std::size_t r = 0; r < group.count; r += double_lanes) {
    VecD t_in = hn::Load(doubles, group.t_in + r), t_out = hn::Load(doubles, group.t_out + r);
    MaskD inside = hn::FirstN(doubles, group.count - r), possible = inside;
    for (int a = 0; a < 3; ++a) {
      const VecD size = hn::Set(doubles, static_cast<double>(leaf_count[a]));
      const VecD o = hn::Load(doubles, group.origin[a] + r);
      const VecD quotient = hn::Div(hn::Set(doubles, 1.0), hn::Load(doubles, group.direction[a] + r));
      const MaskD steps = is_finite(quotient);
      const VecD in_cell = hn::Add(hn::Min(hn::Max(hn::Floor(o), zero), hn::Sub(size, hn::Set(doubles, 1.0))), half);
      const VecD plane_origin = hn::IfThenElse(steps, o, in_cell);
      const VecD inverse = hn::IfThenElse(steps, quotient, never);
      hn::Store(plane_origin, doubles, group.plane_origin[a] + r);
      hn::Store(inverse, doubles, group.inverse[a] + r);
      const VecD at_low = hn::Mul(hn::Sub(zero, plane_origin), inverse);
      const VecD at_high = hn::Mul(hn::Sub(size, plane_origin), inverse);
      const bool down = (group.octant >> a & 1) != 0;
      const VecD enter = down ? at_high : at_low, leave = down ? at_low : at_high;
      inside = hn::And(inside, hn::Le(enter, leave));
      possible = hn::And(possible, hn::Or(steps, hn::And(hn::Ge(o, zero), hn::Le(o, size))));
      t_in = hn::IfThenElse(hn::Gt(enter, t_in), enter, t_in);
      t_out = hn::IfThenElse(hn::Lt(leave, t_out), leave, t_out);
    }
    inside = hn::And(hn::And(inside, hn::Le(t_in, t_out)), hn::And(is_finite(t_in), is_finite(t_out)));
    inside = hn::And(inside, possible);
    group.grazing |= bits_of(doubles, hn::And(possible, may_be_exchanged(t_in, t_out))) << r;
    hn::Store(t_in, doubles, group.t_in + r);
    hn::Store(t_out, doubles, group.t_out + r);
    group.inside |= bits_of(doubles, inside) << r;
  }
}

/// A mirrored coordinate of the rays' origins, and the speed at which it grows.
template <class Group>
HWY_INLINE VecD mirrored_origin(const MirroredLattice& lattice, const Group& group, int axis, std::size_t r) {
  const VecD o = hn::Load(doubles, group.origin[axis] + r);
  return lattice.is_mirrored(axis) ? hn::Sub(hn::Set(doubles, lattice.plane(axis, 0)), o) : o;
}
template <class Group>
HWY_INLINE VecD speed(const Group& group, int axis, std::size_t r) {
  return hn::Abs(hn::Load(doubles, group.direction[axis] + r));
}
/// How far rays move along an axis while they move by 1 along the major axis.
HWY_INLINE VecD slope_along(const RayGroup& group, int axis, std::size_t r) {
  return hn::Mul(speed(group, axis, r), hn::Abs(hn::Load(doubles, group.inverse[group.major] + r)));
}

/// The frustum around the parts inside the lattice of these rays; each must have such a part. It is
/// wider by a margin that covers all rounding of positions and plane times.
HWY_INLINE Frustum frustum_around(const MirroredLattice& lattice, const RayGroup& group, std::uint64_t rays) {
  constexpr double far = 0x1p1000;
  const VecD high = hn::Set(doubles, far), low = hn::Set(doubles, -far);
  const int w = group.major;
  Frustum frustum{.major = w, .minor = {w == 0 ? 1 : 0, w == 2 ? 1 : 2}, .first = 0, .last = 0, .low = {}, .high = {}};
  VecD first = high, last = low, largest = hn::Zero(doubles);
  for (std::size_t r = 0; r < group.count; r += double_lanes) {
    const MaskD part = mask_of(doubles, rays >> r);
    const VecD o = mirrored_origin(lattice, group, w, r), d = speed(group, w, r);
    first = hn::Min(first, hn::IfThenElse(part, hn::MulAdd(hn::Load(doubles, group.t_in + r), d, o), high));
    last = hn::Max(last, hn::IfThenElse(part, hn::MulAdd(hn::Load(doubles, group.t_out + r), d, o), low));
    for (int a = 0; a < 3; ++a)
      largest = hn::Max(largest, hn::IfThenElseZero(part, hn::Abs(mirrored_origin(lattice, group, a, r))));
  }
  const double end = 16.0 * lattice.node_count[w];
  const double margin = 1e-3 + 0x1p-46 * hn::GetLane(hn::MaxOfLanes(doubles, largest));
  const auto clamped = [end](double x) { return x > 0 ? (x < end ? x : end) : 0.0; };
  frustum.first = clamped(hn::GetLane(hn::MinOfLanes(doubles, first)) - margin);
  frustum.last = clamped(hn::GetLane(hn::MaxOfLanes(doubles, last)) + margin);
  const VecD at_first = hn::Set(doubles, frustum.first), at_last = hn::Set(doubles, frustum.last);
  for (int m = 0; m < 2; ++m) {
    const int u = frustum.minor[m];
    VecD low_first = high, low_last = high, high_first = low, high_last = low;
    for (std::size_t r = 0; r < group.count; r += double_lanes) {
      const MaskD part = mask_of(doubles, rays >> r);
      const VecD o = mirrored_origin(lattice, group, u, r), o_w = mirrored_origin(lattice, group, w, r);
      const VecD slope = slope_along(group, u, r);
      const VecD from = hn::MulAdd(hn::Sub(at_first, o_w), slope, o), to = hn::MulAdd(hn::Sub(at_last, o_w), slope, o);
      low_first = hn::Min(low_first, hn::IfThenElse(part, from, high));
      low_last = hn::Min(low_last, hn::IfThenElse(part, to, high));
      high_first = hn::Max(high_first, hn::IfThenElse(part, from, low));
      high_last = hn::Max(high_last, hn::IfThenElse(part, to, low));
    }
    const double length = frustum.last - frustum.first;
    const auto line = [&](double from, double to) {
      const double slope = length > 0 ? (to - from) / length : 0;
      return Frustum::Line{from - frustum.first * slope, slope};
    };
    frustum.low[m] = line(hn::GetLane(hn::MinOfLanes(doubles, low_first)) - margin,
                          hn::GetLane(hn::MinOfLanes(doubles, low_last)) - margin);
    frustum.high[m] = line(hn::GetLane(hn::MaxOfLanes(doubles, high_first)) + margin,
                           hn::GetLane(hn::MaxOfLanes(doubles, high_last)) + margin);
  }
  return frustum;
}

/// True where the frustum is so wide that no ray meets most of the blocks in it.
HWY_INLINE bool is_too_wide(const Frustum& frustum, std::size_t ray_count) {
  double largest = 0;
  for (const double w : {frustum.first, frustum.last}) {
    double blocks = 1;
    for (int m = 0; m < 2; ++m) blocks *= (frustum.high[m].at(w) - frustum.low[m].at(w)) * 0.25 + 1;
    largest = blocks > largest ? blocks : largest;
  }
  return largest > 4.0 * static_cast<double>(ray_count);
}

/// Fewer rays than this share too little for a group to pay off.
inline constexpr std::size_t fewest_together = 8;

/// Calls visit(group, lattice, frustum) with groups of the rays of a chunk until every ray that
/// enters the lattice was in one. Groups of few rays and groups that are too wide are offered to
/// scatter(group) first. Where scatter declines, the rays of a group that is too wide are visited
/// one by one.
/// @return  rays of the chunk for which rounding hides whether they meet the lattice
template <class Visit, class Scatter>
HWY_INLINE std::uint64_t for_each_group(const RayArrays& rays, std::size_t count, const int* leaf_count,
                                        const std::array<int, 3>& node_count, RayGroup& group, Visit&& visit,
                                        Scatter&& scatter) {
  const Directions directions = directions_of(rays, count);
  std::uint64_t grazing = 0;
  for (std::uint64_t remaining = directions.usable; remaining != 0;) {
    ChosenRays chosen = rays_of_one_octant(directions, remaining);
    const MirroredLattice lattice(chosen.octant, node_count);
    group.octant = chosen.octant;
    group.major = chosen.major;
    gather_rays(rays, chosen.rays, group);
    clip_group(leaf_count, group);
    for (std::uint64_t bits = group.grazing; bits != 0; bits &= bits - 1)
      grazing |= std::uint64_t{1} << group.index[std::countr_zero(bits)];
    const auto inside = static_cast<std::size_t>(std::popcount(group.inside));
    if (inside != 0 && !(inside < fewest_together && scatter(group))) {
      Frustum frustum = frustum_around(lattice, group, group.inside);
      const bool is_wide = group.count > 1 && is_too_wide(frustum, inside);
      if (!is_wide || !scatter(group)) {
        if (is_wide) {
          chosen.rays &= ~chosen.rays + 1;  // its first ray alone
          gather_rays(rays, chosen.rays, group);
          clip_group(leaf_count, group);
          frustum = frustum_around(lattice, group, group.inside);
        }
        if (group.inside != 0) visit(group, lattice, frustum);
      }
    }
    remaining &= ~chosen.rays;
  }
  return grazing;
}

template <class Visit>
HWY_INLINE void for_each_group(const RayArrays& rays, std::size_t count, const int* leaf_count,
                               const std::array<int, 3>& node_count, RayGroup& group, Visit&& visit) {
  for_each_group(rays, count, leaf_count, node_count, group, visit, [](const RayGroup&) { return false; });
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

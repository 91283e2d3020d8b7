// How much rounding in single precision may have changed cubics (render/cell/certified_crossing.h),
// one in each lane.
#if defined(RHORAY_WIDE_MARGINS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MARGINS_INL_H
#undef RHORAY_WIDE_MARGINS_INL_H
#else
#define RHORAY_WIDE_MARGINS_INL_H
#endif

#include <limits>

#include <hwy/highway.h>

#include "render/grid/isosurface/cubic-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// A unit of rounding in single precision.
inline constexpr float rounding_unit = 0x1p-24f;

/// Bound on the distance of the cubic from the exact one on any segment in question (enclosed_along
/// of render/cell/certified_crossing.h); infinite where nothing is certain. The unrounded third
/// adds 0.5 u to its 18.7 u, and a part that is halved adds 3 u.
HWY_INLINE VecF margin_of(const Corners& corners, VecF way_error) {
  VecF least = corners.f[0], largest = corners.f[0];
  for (int c = 1; c < 8; ++c) least = hn::Min(least, corners.f[c]), largest = hn::Max(largest, corners.f[c]);
  const VecF size = hn::Max(hn::Abs(least), hn::Abs(largest));
  const VecF of_points = hn::Mul(hn::Set(floats, 3.2f), hn::Add(way_error, hn::Set(floats, rounding_unit)));
  const VecF margin =
      hn::MulAdd(size, hn::Set(floats, 23.5f * rounding_unit), hn::Mul(of_points, hn::Sub(largest, least)));
  const MaskF usable = hn::And(hn::Le(way_error, hn::Set(floats, 1e-3f)), hn::Ge(size, hn::Set(floats, 0x1p-100f)));
  return hn::IfThenElse(usable, margin, hn::Set(floats, std::numeric_limits<float>::infinity()));
}

/// An upper bound of margin_of for any cell of a block whose values minus the isovalue, together
/// with 0, span `range`. Infinite where `range` is infinite (BlockSamples).
HWY_INLINE VecF margin_in_block(VecF range, VecF way_error) {
  const VecF share = hn::MulAdd(way_error, hn::Set(floats, 3.25f), hn::Set(floats, 27 * rounding_unit));
  const MaskF usable = hn::Le(way_error, hn::Set(floats, 1e-3f));
  return hn::IfThenElse(usable, hn::Mul(range, share), hn::Set(floats, std::numeric_limits<float>::infinity()));
}

HWY_INLINE CubicLanes start_side_up(const CubicLanes& cubic, MaskF starts_inside) {
  CubicLanes turned;
  const VecF sign = hn::IfThenZeroElse(starts_inside, hn::SignBit(floats));
  for (int i = 0; i < 4; ++i) turned.b[i] = hn::Xor(cubic.b[i], sign);
  return turned;
}

/// The Bernstein coefficients of the part on [0, s] and of the rest.
struct Parts {
  CubicLanes before, after;
};
HWY_INLINE Parts parts_at(const CubicLanes& cubic, VecF s) {
  const VecF rest = hn::Sub(hn::Set(floats, 1.0f), s);
  const VecF* b = cubic.b;
  const VecF c0 = between(b[0], b[1], s, rest), c1 = between(b[1], b[2], s, rest), c2 = between(b[2], b[3], s, rest);
  const VecF d0 = between(c0, c1, s, rest), d1 = between(c1, c2, s, rest);
  const VecF middle = between(d0, d1, s, rest);
  return {{{b[0], c0, d0, middle}}, {{middle, d1, c2, b[3]}}};
}

/// Certain that no exact cubic is on the other side: its convex hull stays above the margin.
HWY_INLINE MaskF is_clear(const CubicLanes& cubic, VecF margin) {
  const VecF* b = cubic.b;
  return hn::Gt(hn::Min(hn::Min(b[0], b[1]), hn::Min(b[2], b[3])), margin);
}

/// Where the side on which the ray enters the cell is not certain, or, where no change was found,
/// that there is none.
HWY_INLINE MaskF is_in_doubt(const CubicLanes& cubic, VecF margin, MaskF starts_inside, MaskF found) {
  const CubicLanes turned = start_side_up(cubic, starts_inside);
  const MaskF starts = hn::Gt(turned.b[0], margin);
  const VecF rest = hn::Min(hn::Min(turned.b[1], turned.b[2]), turned.b[3]);
  MaskF decided = hn::And(starts, hn::Or(found, hn::Gt(rest, margin)));
  return hn::Not(decided);
}

/// Bound on the distance of the exact first change of side from a root, as a share of the path
/// through the cell; infinite where nothing is proven.
HWY_INLINE VecF error_of_root(const CubicLanes& cubic, VecF margin, VecF root) {
  const VecF zero = hn::Zero(floats), one = hn::Set(floats, 1.0f);
  const CubicLanes turned = start_side_up(cubic, is_inside(cubic.b[0]));
  const VecF slope = hn::Abs(turned.at(root).slope);
  const VecF reach = hn::Max(hn::Set(floats, 0x1p-22f), hn::Div(hn::Mul(hn::Set(floats, 1.5f), margin), slope));
  const VecF low = hn::Max(hn::Sub(root, reach), zero), high = hn::Min(hn::Add(root, reach), one);
  const CubicLanes until = parts_at(turned, low).before;
  MaskF clear = is_clear(until, margin);
  if (!hn::AllTrue(floats, clear)) {
    const Parts halves = parts_at(until, hn::Set(floats, 0.5f));
    clear = hn::Or(clear, hn::And(is_clear(halves.before, margin), is_clear(halves.after, margin)));
  }
  const MaskF changed = hn::Lt(turned.at(high).value, hn::Neg(margin));
  const MaskF proven = hn::And(clear, changed);
  const VecF error = hn::Mul(hn::Max(hn::Sub(high, root), hn::Sub(root, low)), hn::Set(floats, 1 + 0x1p-20f));
  return hn::IfThenElse(proven, error, hn::Set(floats, std::numeric_limits<float>::infinity()));
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

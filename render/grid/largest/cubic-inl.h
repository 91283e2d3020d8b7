// Cubics on the ways of rays through cells: bounds in single precision, the largest value in
// double.
#if defined(RHORAY_WIDE_MAXIMUM_CUBIC_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_CUBIC_INL_H
#undef RHORAY_WIDE_MAXIMUM_CUBIC_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_CUBIC_INL_H
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Coordinates on the three axes.
struct Point {
  VecF u, v, w;
};

/// The Bernstein coefficients along the way from p to q (render/cell/trilinear.h), b0 to b3.
struct Coefficients {
  VecF b0, b1, b2, b3;

  HWY_INLINE VecF largest() const { return hn::Max(hn::Max(b0, b1), hn::Max(b2, b3)); }
  HWY_INLINE VecF smallest() const { return hn::Min(hn::Min(b0, b1), hn::Min(b2, b3)); }
  HWY_INLINE Coefficients negated() const { return {hn::Neg(b0), hn::Neg(b1), hn::Neg(b2), hn::Neg(b3)}; }

  HWY_INLINE VecF at(VecF s) const {
    const VecF r = hn::Sub(hn::Set(floats, 1.0F), s), three = hn::Set(floats, 3.0F);
    const VecF outer = hn::MulAdd(hn::Mul(hn::Mul(r, r), r), b0, hn::Mul(hn::Mul(hn::Mul(s, s), s), b3));
    return hn::MulAdd(hn::Mul(three, hn::Mul(r, s)), hn::MulAdd(r, b1, hn::Mul(s, b2)), outer);
  }

  /// A position not far from the largest value, away from both ends.
  HWY_INLINE VecF likely_maximum() const {
    const VecF d0 = hn::Sub(b1, b0), d1 = hn::Sub(b2, b1), d2 = hn::Sub(b3, b2);
    const VecF discriminant = hn::Max(hn::NegMulAdd(d0, d2, hn::Mul(d1, d1)), hn::Zero(floats));
    const VecF turn = hn::Div(d0, hn::Add(hn::Sqrt(discriminant), hn::Sub(d0, d1)));
    const VecF first = hn::Set(floats, 1.0F / 64), last = hn::Set(floats, 63.0F / 64);
    const VecF end = hn::IfThenElse(hn::Gt(b3, b0), last, first);
    return hn::IfThenElse(hn::And(hn::Gt(turn, first), hn::Lt(turn, last)), turn, end);
  }
};

/// @param f  at the corners: (u, v, w) at u + 2 v + 4 w
HWY_INLINE Coefficients coefficients(const VecF* f, const Point& p, const Point& q) {
  struct Pair {
    VecF p, q;
  };
  const auto between = [](VecF a, VecF b, VecF at_p, VecF at_q) HWY_ATTR {
    const VecF difference = hn::Sub(b, a);
    return Pair{hn::MulAdd(difference, at_p, a), hn::MulAdd(difference, at_q, a)};
  };
  const Pair f00 = between(f[0], f[1], p.u, q.u), f10 = between(f[2], f[3], p.u, q.u);
  const Pair f01 = between(f[4], f[5], p.u, q.u), f11 = between(f[6], f[7], p.u, q.u);
  const Pair low_p = between(f00.p, f10.p, p.v, q.v), low_q = between(f00.q, f10.q, p.v, q.v);
  const Pair high_p = between(f01.p, f11.p, p.v, q.v), high_q = between(f01.q, f11.q, p.v, q.v);
  const Pair pp = between(low_p.p, high_p.p, p.w, q.w), qp = between(low_q.p, high_q.p, p.w, q.w);
  const Pair pq = between(low_p.q, high_p.q, p.w, q.w), qq = between(low_q.q, high_q.q, p.w, q.w);
  // Each is a weighted sum of all corners: a single NaN makes all of them NaN.
  const VecF third = hn::Set(floats, 1.0F / 3);
  return {pp.p, hn::Mul(hn::Add(hn::Add(qp.p, pq.p), pp.q), third), hn::Mul(hn::Add(hn::Add(qq.p, qp.q), pq.q), third),
          qq.q};
}

HWY_INLINE VecD between(VecD a, VecD b, VecD w) {
  return hn::Add(hn::Mul(hn::Sub(hn::Set(doubles, 1.0), w), a), hn::Mul(w, b));
}

/// Where ways pass faces of their cells, at one end.
struct FacePassage {
  MaskD through[3];  ///< across which axis; none where the ray ends between planes
  VecD p[3];
  bool is_high[3];  ///< by axis: faces across it are passed where p is 1
};

/// value_on_face of render/grid/reference/largest.h.
/// @param f  at the corners; the result is meaningless for lanes that pass no face
HWY_INLINE VecD value_on_face(const VecD* f, const FacePassage& at) {
  const auto chosen = [&](VecD x, VecD y, VecD z)
                          HWY_ATTR { return hn::IfThenElse(at.through[0], x, hn::IfThenElse(at.through[1], y, z)); };
  VecD face[4];
  for (int c = 0; c < 4; ++c)
    face[c] =
        chosen(f[at.is_high[0] | c << 1], f[at.is_high[1] << 1 | (c & 1) | (c >> 1) << 2], f[at.is_high[2] << 2 | c]);
  const VecD first = chosen(at.p[1], at.p[0], at.p[0]), second = chosen(at.p[2], at.p[2], at.p[1]);
  const VecD largest = hn::Max(hn::Max(face[0], face[1]), hn::Max(face[2], face[3]));
  for (VecD& value : face) value = hn::Sub(value, largest);
  return hn::Add(largest, between(between(face[0], face[1], first), between(face[2], face[3], first), second));
}

/// The largest value on a way and its position; the values at its ends.
struct Answer {
  VecD value, s;
  VecD first, last;
};

/// CubicOf::along and largest_value (render/cell/trilinear.h, render/cell/cubic.h).
HWY_INLINE Answer largest_on_way(const VecD* f, const VecD* in, const VecD* out) {
  struct Pair {
    VecD p, q;
  };
  const auto on_axis = [&](VecD a, VecD b, int axis) HWY_ATTR {
    return Pair{between(a, b, in[axis]), between(a, b, out[axis])};
  };
  const Pair x00 = on_axis(f[0], f[1], 0), x10 = on_axis(f[2], f[3], 0), x01 = on_axis(f[4], f[5], 0),
             x11 = on_axis(f[6], f[7], 0);
  const Pair low_p = on_axis(x00.p, x10.p, 1), low_q = on_axis(x00.q, x10.q, 1);
  const Pair high_p = on_axis(x01.p, x11.p, 1), high_q = on_axis(x01.q, x11.q, 1);
  // g.._: by x and y, each for both ends on z.
  const Pair gpp = on_axis(low_p.p, high_p.p, 2), gqp = on_axis(low_q.p, high_q.p, 2);
  const Pair gpq = on_axis(low_p.q, high_p.q, 2), gqq = on_axis(low_q.q, high_q.q, 2);
  const VecD zero = hn::Zero(doubles), one = hn::Set(doubles, 1.0), three = hn::Set(doubles, 3.0);
  const VecD b0 = gpp.p, b1 = hn::Div(hn::Add(hn::Add(gqp.p, gpq.p), gpp.q), three),
             b2 = hn::Div(hn::Add(hn::Add(gqq.p, gqp.q), gpq.q), three), b3 = gqq.q;

  Answer best{b0, zero, b0, b3};
  const MaskD may_turn = hn::Or(hn::Gt(b1, b0), hn::Gt(b2, b3));
  VecD d0 = hn::Sub(b1, b0), d1 = hn::Sub(b2, b1), d2 = hn::Sub(b3, b2);
  const VecD unit = hn::Max(hn::Max(hn::Abs(d0), hn::Abs(d1)), hn::Abs(d2));
  // If all three are clear of zero on one side, so is the derivative all the way, by far more than
  // rounding moves its roots.
  const VecD tiny = hn::Mul(hn::Set(doubles, 0x1p-20), unit);
  const MaskD is_monotone =
      hn::Or(hn::Gt(hn::Min(hn::Min(d0, d1), d2), tiny), hn::Lt(hn::Max(hn::Max(d0, d1), d2), hn::Neg(tiny)));
  if (!hn::AllFalse(doubles, hn::AndNot(is_monotone, may_turn))) {
    d0 = hn::Div(d0, unit), d1 = hn::Div(d1, unit), d2 = hn::Div(d2, unit);
    const VecD a = hn::Add(hn::Sub(d0, hn::Mul(hn::Set(doubles, 2.0), d1)), d2), half_b = hn::Sub(d1, d0);
    const VecD discriminant = hn::Sub(hn::Mul(d1, d1), hn::Mul(d0, d2));
    const VecD q = hn::Neg(hn::Add(half_b, hn::CopySign(hn::Sqrt(discriminant), half_b)));
    const VecD one_root = hn::Div(q, a), other_root = hn::Div(d0, q);
    const MaskD turns = hn::And(may_turn, hn::Ge(discriminant, zero));
    const auto is_inside = [&](VecD s) HWY_ATTR { return hn::And(turns, hn::And(hn::Gt(s, zero), hn::Lt(s, one))); };
    const MaskD has_one = is_inside(one_root), has_other = is_inside(other_root);
    // The nearer one first; a larger value replaces it.
    const MaskD swaps = hn::And(hn::And(has_one, has_other), hn::Lt(other_root, one_root));
    const auto offer = [&](VecD s, MaskD valid) HWY_ATTR {
      const VecD r = hn::Sub(one, s);
      const auto mix = [&](VecD from, VecD to) HWY_ATTR { return hn::Add(hn::Mul(r, from), hn::Mul(s, to)); };
      const VecD c0 = mix(b0, b1), c1 = mix(b1, b2), c2 = mix(b2, b3);
      const VecD value = mix(mix(c0, c1), mix(c1, c2));
      const MaskD better = hn::And(valid, hn::Gt(value, best.value));
      best.value = hn::IfThenElse(better, value, best.value);
      best.s = hn::IfThenElse(better, s, best.s);
    };
    offer(hn::IfThenElse(swaps, other_root, one_root), has_one);
    offer(hn::IfThenElse(swaps, one_root, other_root), has_other);
  }
  const MaskD ends_higher = hn::Gt(b3, best.value);
  return {hn::IfThenElse(ends_higher, b3, best.value), hn::IfThenElse(ends_higher, one, best.s), b0, b3};
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

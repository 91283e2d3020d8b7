// The field on straight paths through cells, one cell in each lane: cubics, where they change side,
// and their roots (render/cell/trilinear.h, render/cell/cubic.h).
#if defined(RHORAY_WIDE_CUBIC_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_CUBIC_INL_H
#undef RHORAY_WIDE_CUBIC_INL_H
#else
#define RHORAY_WIDE_CUBIC_INL_H
#endif

#include <cstdint>

#include <hwy/highway.h>

#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// (1 - w) a + w b: exact at w = 0 and w = 1. Where a and b have the same sign, the result has it
/// too.
HWY_INLINE VecF between(VecF a, VecF b, VecF w, VecF rest) {
  return hn::MulAdd(w, b, hn::Mul(rest, a));
}

/// The eight corners of a cell.
struct Corners {
  VecF f[8];
};

/// A cubic by its Bernstein coefficients.
struct CubicLanes {
  VecF b[4];

  struct Jet {
    VecF value, slope;
  };
  HWY_INLINE Jet at(VecF s) const {
    const VecF r = hn::Sub(hn::Set(floats, 1.0f), s);
    const VecF c0 = between(b[0], b[1], s, r), c1 = between(b[1], b[2], s, r), c2 = between(b[2], b[3], s, r);
    const VecF d0 = between(c0, c1, s, r), d1 = between(c1, c2, s, r);
    return {between(d0, d1, s, r), hn::Mul(hn::Set(floats, 3.0f), hn::Sub(d1, d0))};
  }
};

/// The field along a straight line between two points of a cell (`along` in
/// render/cell/trilinear.h).
HWY_INLINE CubicLanes along(const Corners& corners, const VecF* in, const VecF* out) {
  const VecF one = hn::Set(floats, 1.0f);
  VecF w[3][2], rest[3][2];
  for (int a = 0; a < 3; ++a) {
    w[a][0] = in[a], w[a][1] = out[a];
    rest[a][0] = hn::Sub(one, in[a]), rest[a][1] = hn::Sub(one, out[a]);
  }
  VecF g[8];  // a + 2 b + 4 c
  for (int a = 0; a < 2; ++a) {
    VecF x[4];
    for (int e = 0; e < 4; ++e) x[e] = between(corners.f[2 * e], corners.f[2 * e + 1], w[0][a], rest[0][a]);
    for (int b = 0; b < 2; ++b) {
      const VecF near = between(x[0], x[1], w[1][b], rest[1][b]), far = between(x[2], x[3], w[1][b], rest[1][b]);
      for (int c = 0; c < 2; ++c) g[a + 2 * b + 4 * c] = between(near, far, w[2][c], rest[2][c]);
    }
  }
  const VecF third = hn::Set(floats, 1.0f / 3.0f);
  return {{g[0], hn::Mul(hn::Add(hn::Add(g[1], g[2]), g[4]), third), hn::Mul(hn::Add(hn::Add(g[3], g[5]), g[6]), third),
           g[7]}};
}

/// Derivatives along the axes at a point of the cell.
HWY_INLINE void gradient_at(const Corners& corners, const VecF* p, VecF* gradient) {
  const VecF one = hn::Set(floats, 1.0f);
  const VecF* f = corners.f;
  const VecF rest[3] = {hn::Sub(one, p[0]), hn::Sub(one, p[1]), hn::Sub(one, p[2])};
  const auto bilinear = [&](VecF a, VecF b, VecF c, VecF d, int u, int v) HWY_ATTR {
    return between(between(a, b, p[u], rest[u]), between(c, d, p[u], rest[u]), p[v], rest[v]);
  };
  gradient[0] = bilinear(hn::Sub(f[1], f[0]), hn::Sub(f[3], f[2]), hn::Sub(f[5], f[4]), hn::Sub(f[7], f[6]), 1, 2);
  gradient[1] = bilinear(hn::Sub(f[2], f[0]), hn::Sub(f[3], f[1]), hn::Sub(f[6], f[4]), hn::Sub(f[7], f[5]), 0, 2);
  gradient[2] = bilinear(hn::Sub(f[4], f[0]), hn::Sub(f[5], f[1]), hn::Sub(f[6], f[2]), hn::Sub(f[7], f[3]), 0, 1);
}

HWY_INLINE MaskF is_inside(VecF difference) {
  return hn::Ge(difference, hn::Zero(floats));
}

/// In which lanes a cubic changes side, how often, and the first piece of [0, 1] on which it does
/// so and is monotone. A change at 0 itself has the piece [0, 0].
struct Changes {
  MaskF found;
  VecF low, high;
  VecI count;
};

HWY_INLINE VecI ones_in(MaskF mask) {
  return hn::IfThenElseZero(hn::RebindMask(ints, mask), hn::Set(ints, 1));
}

/// Where cubics that start on a given side may change it.
struct Pieces {
  MaskF once;     ///< lanes that change side once, somewhere on [0, 1]
  MaskF split;    ///< lanes that may change side at 0 and on each of three monotone pieces
  MaskF at_zero;  ///< of these, the lanes that change side at 0
  /// Of the pieces; only where any lane is split. Missing pieces have both ends at 1.
  VecF ends[3];
};

/// @param inside  the sides on which they start
HWY_INLINE Pieces pieces_of(const CubicLanes& cubic, MaskF inside, MaskF asked) {
  const VecF zero = hn::Zero(floats), one = hn::Set(floats, 1.0f);
  MaskF changed[4];
  for (int i = 0; i < 4; ++i) changed[i] = hn::And(asked, hn::Xor(is_inside(cubic.b[i]), inside));
  const MaskF any = hn::Or(hn::Or(changed[0], changed[1]), hn::Or(changed[2], changed[3]));
  // With one change of sign among the coefficients there is one root, unless an end is as good as
  // zero. Then there is one more root, and a search on all of [0, 1] would end there.
  VecF largest = hn::Max(hn::Abs(cubic.b[1]), hn::Abs(cubic.b[2]));
  const VecF least_end = hn::Min(hn::Abs(cubic.b[0]), hn::Abs(cubic.b[3]));
  largest = hn::Max(largest, hn::Max(hn::Abs(cubic.b[0]), hn::Abs(cubic.b[3])));
  const MaskF clear_ends = hn::Gt(least_end, hn::Mul(largest, hn::Set(floats, 0x1p-23f)));
  const MaskF one_sign = hn::AndNot(hn::Or(changed[0], hn::AndNot(changed[2], changed[1])), changed[3]);
  Pieces pieces;
  pieces.once = hn::And(clear_ends, one_sign);
  pieces.split = hn::AndNot(pieces.once, any);
  pieces.at_zero = hn::And(pieces.split, changed[0]);
  if (hn::AllFalse(floats, pieces.split)) return pieces;

  // The critical points, without cancellation (critical_points of render/cell/cubic.h).
  VecF d0 = hn::Sub(cubic.b[1], cubic.b[0]), d1 = hn::Sub(cubic.b[2], cubic.b[1]), d2 = hn::Sub(cubic.b[3], cubic.b[2]);
  const VecF unit = hn::Max(hn::Abs(d0), hn::Max(hn::Abs(d1), hn::Abs(d2)));
  d0 = hn::Div(d0, unit), d1 = hn::Div(d1, unit), d2 = hn::Div(d2, unit);
  const VecF a = hn::Add(hn::Sub(d0, hn::Add(d1, d1)), d2), half_b = hn::Sub(d1, d0);
  const VecF discriminant = hn::NegMulAdd(d0, d2, hn::Mul(d1, d1));
  const MaskF has_roots = hn::Ge(discriminant, zero);
  const VecF q = hn::Neg(hn::Add(half_b, hn::CopySign(hn::Sqrt(hn::Max(discriminant, zero)), half_b)));
  VecF s0 = hn::Div(q, a), s1 = hn::Div(d0, q);
  const auto in_unit = [&](VecF s) HWY_ATTR { return hn::And(has_roots, hn::And(hn::Gt(s, zero), hn::Lt(s, one))); };
  s0 = hn::IfThenElse(in_unit(s0), s0, one), s1 = hn::IfThenElse(in_unit(s1), s1, one);
  pieces.ends[0] = hn::Min(s0, s1), pieces.ends[1] = hn::Max(s0, s1), pieces.ends[2] = one;
  return pieces;
}

/// Calls change(lanes, low, high) for the pieces on which cubics change side, one after another.
/// @param inside  the sides on which they start
template <class Change>
HWY_INLINE void for_each_change(const CubicLanes& cubic, const Pieces& pieces, MaskF inside, const Change& change) {
  const VecF zero = hn::Zero(floats), one = hn::Set(floats, 1.0f);
  change(pieces.once, zero, one);
  if (hn::AllFalse(floats, pieces.split)) return;
  change(pieces.at_zero, zero, zero);
  MaskF side = hn::Xor(inside, pieces.at_zero);
  VecF low = zero;
  for (const VecF& end : pieces.ends) {
    const VecF value = hn::IfThenElse(hn::Eq(end, one), cubic.b[3], cubic.at(end).value);
    const MaskF changes_here = hn::And(pieces.split, hn::Xor(is_inside(value), side));
    change(changes_here, low, end);
    side = hn::Xor(side, changes_here);
    low = end;
  }
}

/// The first changes of side of cubics that start on the side `inside` (changes_of_side of
/// render/cell/cubic.h).
HWY_INLINE Changes first_changes(const CubicLanes& cubic, MaskF inside, MaskF asked) {
  Changes changes{no_lane(floats), hn::Zero(floats), hn::Set(floats, 1.0f), hn::Zero(ints)};
  for_each_change(cubic, pieces_of(cubic, inside, asked), inside, [&](MaskF lanes, VecF low, VecF high) HWY_ATTR {
    const MaskF first = hn::AndNot(changes.found, lanes);
    changes.low = hn::IfThenElse(first, low, changes.low);
    changes.high = hn::IfThenElse(first, high, changes.high);
    changes.found = hn::Or(changes.found, lanes);
    changes.count = hn::Add(changes.count, ones_in(lanes));
  });
  return changes;
}

/// Changes between the sides at entry and exit only.
HWY_INLINE Changes changes_between_ends(VecF at_in, VecF at_out, MaskF inside, MaskF asked) {
  const MaskF changed_in = hn::And(asked, hn::Xor(is_inside(at_in), inside));
  const MaskF changed_out = hn::And(asked, hn::Xor(is_inside(at_out), inside));
  const MaskF found = hn::Or(changed_in, changed_out);
  return {found, hn::Zero(floats), hn::IfThenZeroElse(changed_in, hn::Set(floats, 1.0f)), ones_in(found)};
}

struct Roots {
  VecF s;
  VecI iterations;
};

/// Newton's method kept inside a bracket, like bracketed_root of render/cell/cubic.h.
class RootSearch {
 public:
  HWY_INLINE RootSearch(const CubicLanes& cubic, VecF low, VecF high) : cubic_(cubic), low_(low), high_(high) {
    const VecF half = hn::Set(floats, 0.5f), zero = hn::Zero(floats), one = hn::Set(floats, 1.0f);
    VecF largest = hn::Abs(cubic.b[0]);
    for (int i = 1; i < 4; ++i) largest = hn::Max(largest, hn::Abs(cubic.b[i]));
    noise_ = hn::Mul(largest, hn::Set(floats, 0x1p-23f));

    // First guess: the zero of the straight line between the ends, or of the parabola with its
    // vertex at the end that is critical, if just one is.
    const VecF width = hn::Sub(high, low);
    const MaskF low_critical = hn::Gt(low, zero), high_critical = hn::And(hn::Lt(high, one), hn::Gt(high, zero));
    const MaskF any_critical = hn::Or(low_critical, high_critical);
    VecF f_low = cubic.b[0], f_high = cubic.b[3];
    if (!hn::AllFalse(floats, any_critical)) {
      f_low = hn::IfThenElse(low_critical, cubic.at(low).value, f_low);
      f_high = hn::IfThenElse(high_critical, cubic.at(high).value, f_high);
    }
    const VecF rise = hn::Sub(f_low, f_high);
    VecF guess = hn::MulAdd(width, hn::Div(f_low, rise), low);
    const MaskF by_parabola = hn::Xor(low_critical, high_critical);
    if (!hn::AllFalse(floats, by_parabola)) {
      const VecF from_low = hn::MulAdd(width, hn::Sqrt(hn::Max(zero, hn::Div(f_low, rise))), low);
      const VecF from_high = hn::NegMulAdd(width, hn::Sqrt(hn::Max(zero, hn::Div(f_high, hn::Neg(rise)))), high);
      guess = hn::IfThenElse(by_parabola, hn::IfThenElse(low_critical, from_low, from_high), guess);
    }
    const MaskF in_piece = hn::And(hn::Ge(guess, low), hn::Le(guess, high));
    roots_ = {hn::IfThenElse(in_piece, guess, hn::Mul(half, hn::Add(low, high))), hn::Zero(ints)};
    inside_low_ = is_inside(f_low);
    step_before_ = width;
    active_ = hn::Gt(width, hn::Set(floats, resolution));
  }

  HWY_INLINE bool is_done() const { return hn::AllFalse(floats, active_); }
  HWY_INLINE const CubicLanes& cubic() const { return cubic_; }
  HWY_INLINE const Roots& roots() const { return roots_; }

  HWY_INLINE void step() {
    const VecF half = hn::Set(floats, 0.5f), least = hn::Set(floats, resolution);
    const CubicLanes::Jet f = cubic_.at(roots_.s);
    roots_.iterations = hn::Add(roots_.iterations, ones_in(active_));
    const MaskF at_low_side = hn::Not(hn::Xor(is_inside(f.value), inside_low_));
    low_ = hn::IfThenElse(hn::And(active_, at_low_side), roots_.s, low_);
    high_ = hn::IfThenElse(hn::AndNot(at_low_side, active_), roots_.s, high_);
    const VecF newton = hn::Sub(roots_.s, hn::Div(f.value, f.slope));
    const VecF size = hn::Abs(hn::Sub(newton, roots_.s));
    const MaskF is_newton =
        hn::And(hn::And(hn::Ge(newton, low_), hn::Le(newton, high_)), hn::Le(size, hn::Mul(half, step_before_)));
    const VecF next = hn::IfThenElse(is_newton, newton, hn::Mul(half, hn::Add(low_, high_)));
    active_ = hn::AndNot(hn::Le(hn::Abs(f.value), noise_), active_);
    step_before_ = hn::Abs(hn::Sub(next, roots_.s));
    roots_.s = hn::IfThenElse(active_, next, roots_.s);
    active_ = hn::And(active_, hn::And(hn::Gt(step_before_, least), hn::Gt(hn::Sub(high_, low_), least)));
  }

 private:
  static constexpr float resolution = 1.19e-7f;

  CubicLanes cubic_;
  VecF low_, high_, step_before_, noise_;
  MaskF inside_low_, active_;
  Roots roots_;
};

/// Advances two searches side by side until all lanes are done, so that neither waits for its own
/// last step.
HWY_INLINE void refine(RootSearch& a, RootSearch& b) {
  for (int step = 0; step < 100 && !(a.is_done() && b.is_done()); ++step) a.step(), b.step();
}

/// One secant step.
HWY_INLINE Roots secant_step(const CubicLanes& cubic, VecF high) {
  const VecF s = hn::Div(cubic.b[0], hn::Sub(cubic.b[0], cubic.b[3]));
  return {hn::IfThenElseZero(hn::Gt(high, hn::Zero(floats)), s), hn::Set(ints, 1)};
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

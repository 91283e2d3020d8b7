#include "render/exact/exact_tets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include "render/exact/ball.h"
#include "render/exact/polynomial.h"

namespace rhoray::render {

namespace {

using exact::Rational;
using exact::Whole;

bool is_finite(const Vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

bool has_data(const ExactTet& tet) {
  return std::all_of(tet.point.begin(), tet.point.end(), is_finite) &&
         std::all_of(tet.value.begin(), tet.value.end(), [](double f) { return std::isfinite(f); });
}

bool is_ray(const Ray& ray) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return is_finite(ray.origin) && is_finite(ray.direction) && ray.direction != Vec3(0, 0, 0) &&
         ray.t_min <= ray.t_max && ray.t_min < infinity && ray.t_max > -infinity;
}

// --- In double precision ---------------------------------------------------------------------

/// The values of t at which the ray enters and leaves, and value - isovalue there. `in` is
/// certainly before `out`, and all signs are certain.
struct CertainPassage {
  Ball t_in, t_out, value_in, value_out;
  const ExactTet* tet;
};

enum class Seen { missed, passed, in_doubt };

/// A tetrahedron that the ray may hit.
struct Met {
  const ExactTet* tet;
  Enclosure t;                            ///< range in which the ray may be in it
  std::optional<CertainPassage> passage;  ///< nothing when in doubt
};

/// Tests tetrahedra along the ray, in a picture plane in which the ray is at (0, 0).
class PicturePlane {
 public:
  PicturePlane(const Ray& ray, double isovalue) : ray_(ray), isovalue_(isovalue) {
    const Vec3& d = ray.direction;
    for (int axis = 1; axis < 3; ++axis)
      if (std::abs(d[axis]) > std::abs(d[z_])) z_ = axis;
  }

  /// Returns nothing for a tetrahedron that the ray certainly misses.
  std::optional<Met> look(const ExactTet& tet) const {
    CertainPassage passage{};
    Enclosure depth{};
    const Seen seen = look(tet, passage, depth);
    if (seen == Seen::missed) return std::nullopt;
    if (seen == Seen::passed) return Met{&tet, hull(passage.t_in.enclosure(), passage.t_out.enclosure()), passage};
    return Met{&tet, depth, std::nullopt};
  }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  struct Vertex {
    Ball x, y, t, value;
  };

  /// Unbounded when an overflow has destroyed the limits.
  static Enclosure hull(const Enclosure& a, const Enclosure& b) {
    const double lo = std::min(a.lo, b.lo), hi = std::max(a.hi, b.hi);
    const bool is_known = a.lo <= a.hi && b.lo <= b.hi;
    return is_known ? Enclosure{lo, hi} : Enclosure{-infinity, infinity};
  }

  /// @param depth  of the vertices along the ray
  Seen look(const ExactTet& tet, CertainPassage& passage, Enclosure& depth) const {
    std::array<Vertex, 4> v;
    for (std::size_t i = 0; i < 4; ++i) v[i] = see(tet.point[i], tet.value[i]);
    depth = v[0].t.enclosure();
    for (std::size_t i = 1; i < 4; ++i) depth = hull(depth, v[i].t.enclosure());
    Ball edge[4][4];
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) edge[i][j] = v[i].x * v[j].y - v[i].y * v[j].x;

    std::size_t passed = 0;
    Vertex through[2];
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      const std::size_t i = left_out == 0 ? 1 : 0, j = left_out <= 1 ? 2 : 1, k = left_out == 3 ? 2 : 3;
      const Ball weights[] = {edge[j][k], Ball{-edge[i][k].middle, edge[i][k].radius}, edge[i][j]};
      const auto [least, most] = std::minmax({weights[0].sign(), weights[1].sign(), weights[2].sign()});
      if (least < 0 && most > 0) continue;           // passes beside this face
      if (least * most != 1) return Seen::in_doubt;  // a sign is not certain
      if (passed == 2) return Seen::in_doubt;
      const Ball sum = weights[0] + weights[1] + weights[2];
      through[passed].t = (weights[0] * v[i].t + weights[1] * v[j].t + weights[2] * v[k].t) / sum;
      through[passed].value = (weights[0] * v[i].value + weights[1] * v[j].value + weights[2] * v[k].value) / sum;
      ++passed;
    }
    if (passed == 0) return Seen::missed;
    if (passed != 2) return Seen::in_doubt;
    const int order = (through[1].t - through[0].t).sign();
    if (order == 0) return Seen::in_doubt;
    if (order < 0) std::swap(through[0], through[1]);
    passage = {through[0].t, through[1].t, through[0].value, through[1].value, &tet};
    return clip(passage);
  }

  Vertex see(const Vec3& point, double value) const {
    const int x = (z_ + 1) % 3, y = (z_ + 2) % 3;
    const auto from_origin = [&](int axis) { return Ball{point[axis]} - Ball{ray_.origin[axis]}; };
    const Ball t = from_origin(z_) / Ball{ray_.direction[z_]};
    return {from_origin(x) - t * Ball{ray_.direction[x]}, from_origin(y) - t * Ball{ray_.direction[y]}, t,
            Ball{value} - Ball{isovalue_}};
  }

  /// Clips a passage to [t_min, t_max].
  Seen clip(CertainPassage& passage) const {
    const CertainPassage whole = passage;
    const auto cut = [&](double limit, Ball& t, Ball& value) {
      const Ball share = (Ball{limit} - whole.t_in) / (whole.t_out - whole.t_in);
      t = Ball{limit};
      value = whole.value_in + share * (whole.value_out - whole.value_in);
    };
    const auto side_of = [](const Ball& t, double limit) {
      return std::isfinite(limit) ? (t - Ball{limit}).sign() : limit > 0 ? -1 : 1;
    };
    const int in_min = side_of(whole.t_in, ray_.t_min), in_max = side_of(whole.t_in, ray_.t_max);
    const int out_min = side_of(whole.t_out, ray_.t_min), out_max = side_of(whole.t_out, ray_.t_max);
    if (out_min < 0 || in_max > 0) return Seen::missed;
    if (in_min == 0 || in_max == 0 || out_min == 0 || out_max == 0) return Seen::in_doubt;
    if (in_min < 0) cut(ray_.t_min, passage.t_in, passage.value_in);
    if (out_max > 0) cut(ray_.t_max, passage.t_out, passage.value_out);
    return passage.value_in.sign() != 0 && passage.value_out.sign() != 0 ? Seen::passed : Seen::in_doubt;
  }

  const Ray& ray_;
  double isovalue_;
  int z_ = 0;
};

// --- In rational numbers -----------------------------------------------------------------------

/// numerator / denominator > 0, not in lowest terms: comparing costs less than reducing.
struct Fraction {
  Whole numerator, denominator;

  Rational rational() const { return Rational(numerator, denominator); }
};

Fraction fraction(double x) {
  const exact::CommonUnit unit(std::array{x});
  const Whole whole = unit.whole(x);
  const Whole power = Whole(1) << static_cast<unsigned>(std::abs(unit.exponent()));
  return unit.exponent() >= 0 ? Fraction{whole * power, 1} : Fraction{whole, power};
}

/// -1, 0 or 1.
int compare(const Fraction& a, const Fraction& b) {
  return Whole(a.numerator * b.denominator - b.numerator * a.denominator).sign();
}

/// A linear function c0 + c1 t.
struct Linear {
  Whole c0, c1;

  int sign_at(const Fraction& t) const { return Whole(c0 * t.denominator + c1 * t.numerator).sign(); }

  /// Returns its zero; c1 must not be 0.
  Fraction zero() const { return c1.sign() > 0 ? Fraction{-c0, c1} : Fraction{c0, -c1}; }
};

/// The part of the ray in a tetrahedron, in < out. Inside it value - offset = excess / volume *
/// unit, volume > 0.
struct ExactPassage {
  Fraction in, out;
  Linear excess;
  Whole volume;
  int unit_exponent = 0;
  const ExactTet* tet = nullptr;

  Rational value_at(const Fraction& t) const {
    const Rational value = excess.c0 + excess.c1 * t.rational();
    return value * exact::power_of_two(unit_exponent) / Rational(volume);
  }
};

using WholeVec = std::array<Whole, 3>;

WholeVec cross(const WholeVec& a, const WholeVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Whole dot(const WholeVec& a, const WholeVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Returns six times the volumes that a point of the ray spans with the faces, as functions of t.
/// Each is signed so that all are positive inside. Returns nothing for a tetrahedron without
/// volume.
std::optional<std::array<Linear, 4>> weights_along(const ExactTet& tet, const Ray& ray) {
  std::array<double, 18> numbers{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) numbers[3 * i + axis] = tet.point[i][static_cast<int>(axis)];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    numbers[12 + axis] = ray.origin[static_cast<int>(axis)];
    numbers[15 + axis] = ray.direction[static_cast<int>(axis)];
  }
  const exact::CommonUnit unit(numbers);
  std::array<WholeVec, 4> p;  // relative to the origin of the ray
  WholeVec d;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Whole origin = unit.whole(numbers[12 + axis]);
    for (std::size_t i = 0; i < 4; ++i) p[i][axis] = unit.whole(numbers[3 * i + axis]) - origin;
    d[axis] = unit.whole(numbers[15 + axis]);
  }
  // det(a - t d, b - t d, c - t d) = det(a, b, c) - t (d . (a x b + b x c + c x a)); each edge's
  // part serves two faces
  const WholeVec x01 = cross(p[0], p[1]), x02 = cross(p[0], p[2]), x03 = cross(p[0], p[3]);
  const WholeVec x12 = cross(p[1], p[2]), x13 = cross(p[1], p[3]), x23 = cross(p[2], p[3]);
  const Whole e01 = dot(d, x01), e02 = dot(d, x02), e03 = dot(d, x03);
  const Whole e12 = dot(d, x12), e13 = dot(d, x13), e23 = dot(d, x23);
  std::array<Linear, 4> weight{Linear{dot(p[1], x23), e13 - e12 - e23}, Linear{-dot(p[0], x23), e02 + e23 - e03},
                               Linear{dot(p[0], x13), e03 - e01 - e13}, Linear{-dot(p[0], x12), e01 + e12 - e02}};
  const Whole volume = weight[0].c0 + weight[1].c0 + weight[2].c0 + weight[3].c0;
  if (volume == 0) return std::nullopt;
  if (volume < 0)
    for (Linear& w : weight) w = {-w.c0, -w.c1};
  return weight;
}

/// Returns nothing when the ray misses the tetrahedron or meets it in a point only.
std::optional<ExactPassage> passage_of(const ExactTet& tet, const Ray& ray, double offset) {
  const auto weights = weights_along(tet, ray);
  if (!weights) return std::nullopt;
  std::optional<Fraction> in, out;
  const auto not_before = [&](Fraction t) {
    if (!in || compare(t, *in) > 0) in = std::move(t);
  };
  const auto not_behind = [&](Fraction t) {
    if (!out || compare(t, *out) < 0) out = std::move(t);
  };
  if (std::isfinite(ray.t_min)) not_before(fraction(ray.t_min));
  if (std::isfinite(ray.t_max)) not_behind(fraction(ray.t_max));
  for (const Linear& w : *weights) {
    const int slope = w.c1.sign();
    if (slope == 0 && w.c0.sign() < 0) return std::nullopt;
    if (slope > 0) not_before(w.zero());
    if (slope < 0) not_behind(w.zero());
  }
  // Both exist: along any direction some weights increase and some decrease.
  if (compare(*in, *out) >= 0) return std::nullopt;

  ExactPassage passage{.in = *in, .out = *out, .excess = {}, .volume = 0, .tet = &tet};
  const exact::CommonUnit unit(std::array{tet.value[0], tet.value[1], tet.value[2], tet.value[3], offset});
  passage.unit_exponent = unit.exponent();
  for (std::size_t i = 0; i < 4; ++i) {
    const Whole value = unit.whole(tet.value[i]) - unit.whole(offset);
    passage.excess.c0 += (*weights)[i].c0 * value;
    passage.excess.c1 += (*weights)[i].c1 * value;
    passage.volume += (*weights)[i].c0;
  }
  return passage;
}

/// Returns the first change in one tetrahedron for a ray that enters it on a known side.
std::optional<Fraction> change_in(const ExactPassage& passage, bool starts_inside) {
  const auto is_other_side_at = [&](const Fraction& t) { return (passage.excess.sign_at(t) >= 0) != starts_inside; };
  if (is_other_side_at(passage.in)) return passage.in;
  if (is_other_side_at(passage.out)) return passage.excess.zero();
  return std::nullopt;
}

/// True when the ray continues inside behind t in this tetrahedron.
bool goes_on_inside(const ExactPassage& passage, const Fraction& t) {
  if (compare(passage.in, t) > 0 || compare(t, passage.out) >= 0) return false;
  const int sign = passage.excess.sign_at(t);
  return sign > 0 || (sign == 0 && passage.excess.c1.sign() >= 0);
}

/// Returns the first change in passages that join one another.
/// @param joined  sorted by where they begin, then by id
TetRayVerdict first_change(std::span<const ExactPassage> joined) {
  TetRayVerdict verdict;
  const bool starts_inside = joined.front().excess.sign_at(joined.front().in) >= 0;
  std::optional<Fraction> first;
  for (const ExactPassage& passage : joined) {
    auto t = change_in(passage, starts_inside);
    if (!t || (first && compare(*t, *first) >= 0)) continue;
    first = std::move(t);
    verdict.cell = passage.tet->id;
  }
  if (!first) return verdict;
  verdict.is_hit = true;
  verdict.t = exact::enclosing(first->rational());
  verdict.touches = !starts_inside && std::none_of(joined.begin(), joined.end(), [&](const ExactPassage& passage) {
    return goes_on_inside(passage, *first);
  });
  return verdict;
}

TetRayVerdict rational_first_crossing(std::span<const Met> met, const Ray& ray, double isovalue) {
  std::vector<ExactPassage> passages;
  for (const Met& each : met)
    if (auto passage = passage_of(*each.tet, ray, isovalue)) passages.push_back(std::move(*passage));
  std::sort(passages.begin(), passages.end(), [](const ExactPassage& a, const ExactPassage& b) {
    const int order = compare(a.in, b.in);
    return order != 0 ? order < 0 : a.tet->id < b.tet->id;
  });
  TetRayVerdict verdict;
  for (std::size_t begin = 0; begin < passages.size() && !verdict.is_hit;) {
    std::size_t end = begin + 1;
    const Fraction* reaches = &passages[begin].out;
    for (; end < passages.size() && compare(passages[end].in, *reaches) <= 0; ++end)
      if (compare(passages[end].out, *reaches) > 0) reaches = &passages[end].out;
    verdict = first_change(std::span(passages).subspan(begin, end - begin));
    begin = end;
  }
  verdict.road = Road::exact;
  verdict.tets_exact = static_cast<std::int64_t>(met.size());
  return verdict;
}

/// Returns the verdict from passages that are all certain. Returns nothing when one is not, when
/// they may overlap, or when they disagree where they may meet.
/// @param width  of t, which is computed exactly where doubles are not precise enough
std::optional<TetRayVerdict> certain_first_crossing(std::span<const Met> met, const Ray& ray, double isovalue,
                                                    double width) {
  std::vector<const CertainPassage*> passages;
  for (const Met& each : met) {
    if (!each.passage) return std::nullopt;
    passages.push_back(&*each.passage);
  }
  std::sort(passages.begin(), passages.end(),
            [](const CertainPassage* a, const CertainPassage* b) { return a->t_in.middle < b->t_in.middle; });
  const CertainPassage* first = nullptr;
  for (std::size_t p = 0; p < passages.size(); ++p) {
    const CertainPassage& here = *passages[p];
    if (p > 0) {
      const CertainPassage& before = *passages[p - 1];
      const int gap = (here.t_in - before.t_out).sign();
      if (gap < 0 || (gap == 0 && here.value_in.sign() != before.value_out.sign())) return std::nullopt;
    }
    if (first == nullptr && here.value_in.sign() != here.value_out.sign()) first = &here;
  }
  if (first == nullptr) return TetRayVerdict{};
  const Ball share = first->value_in / (first->value_in - first->value_out);
  const Ball t = first->t_in + share * (first->t_out - first->t_in);
  TetRayVerdict verdict{.is_hit = true, .t = t.enclosure(), .cell = first->tet->id};
  if (verdict.t.width() <= width) return verdict;
  const auto passage = passage_of(*first->tet, ray, isovalue);
  verdict.t = exact::enclosing(change_in(*passage, first->value_in.sign() > 0).value().rational());
  verdict.road = Road::exact;
  verdict.tets_exact = 1;
  return verdict;
}

}  // namespace

TetRayVerdict exact_first_crossing(std::span<const ExactTet> tets, const Ray& ray, double isovalue, double width) {
  if (!is_ray(ray) || !std::isfinite(isovalue)) return {};
  const PicturePlane view(ray, isovalue);
  std::vector<Met> met;
  for (const ExactTet& tet : tets)
    if (has_data(tet))
      if (auto seen = view.look(tet)) met.push_back(std::move(*seen));
  std::sort(met.begin(), met.end(), [](const Met& a, const Met& b) { return a.t.lo < b.t.lo; });

  // A part of the ray with a certain gap before it does not join the parts before the gap: process
  // the groups one after the other.
  TetRayVerdict verdict;
  for (std::size_t begin = 0; begin < met.size() && !verdict.is_hit;) {
    double reaches = met[begin].t.hi;
    std::size_t end = begin + 1;
    for (; end < met.size() && met[end].t.lo <= reaches; ++end) reaches = std::max(reaches, met[end].t.hi);
    const std::span<const Met> group = std::span(met).subspan(begin, end - begin);
    const TetRayVerdict before = verdict;
    const auto certain = certain_first_crossing(group, ray, isovalue, width);
    verdict = certain ? *certain : rational_first_crossing(group, ray, isovalue);
    verdict.tets_exact += before.tets_exact;
    if (before.road == Road::exact) verdict.road = Road::exact;
    begin = end;
  }
  return verdict;
}

TetMaximumVerdict exact_largest_value(std::span<const ExactTet> tets, const Ray& ray) {
  TetMaximumVerdict verdict;
  if (!is_ray(ray)) return verdict;
  const PicturePlane view(ray, 0);
  struct Best {
    Rational value, t, in;
    std::uint64_t id;
  };
  std::optional<Best> best;
  for (const ExactTet& tet : tets) {
    if (!has_data(tet) || !view.look(tet)) continue;
    if (best && Rational(*std::max_element(tet.value.begin(), tet.value.end())) < best->value) continue;
    const auto passage = passage_of(tet, ray, 0);
    if (!passage) continue;
    const bool rises = passage->excess.c1.sign() > 0;
    const Fraction& highest = rises ? passage->out : passage->in;
    Best here{passage->value_at(highest), highest.rational(), passage->in.rational(), tet.id};
    if (!best || here.value > best->value ||
        (here.value == best->value && std::tie(here.t, here.in, here.id) < std::tie(best->t, best->in, best->id)))
      best = std::move(here);
  }
  if (!best) return verdict;
  verdict.has_value = true;
  verdict.value = exact::enclosing(best->value);
  verdict.t = exact::enclosing(best->t);
  verdict.cell = best->id;
  return verdict;
}

}  // namespace rhoray::render

#include "render/exact/exact_tets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include "render/exact/polynomial.h"
#include "render/exact/tet_filter.h"

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

/// Where a ray is: on a side from t on, or behind t when it has just left the inside there.
struct Standing {
  Fraction t;
  bool is_inside = false;
  bool has_left = false;
};

/// Returns the first change in one tetrahedron. A ray that has just left the inside enters it again
/// only behind that point.
std::optional<Fraction> change_in(const ExactPassage& passage, const Standing& from) {
  const bool is_ahead = compare(passage.in, from.t) > 0;
  const Fraction& begin = is_ahead ? passage.in : from.t;
  if (compare(begin, passage.out) > 0) return std::nullopt;
  const auto is_other_side_at = [&](const Fraction& t) { return (passage.excess.sign_at(t) >= 0) != from.is_inside; };
  if (is_other_side_at(begin)) {
    if (from.has_left && !is_ahead) return std::nullopt;
    return begin;
  }
  if (is_other_side_at(passage.out)) return passage.excess.zero();
  return std::nullopt;
}

/// True when the ray continues inside behind t in this tetrahedron.
bool goes_on_inside(const ExactPassage& passage, const Fraction& t) {
  if (compare(passage.in, t) > 0 || compare(t, passage.out) >= 0) return false;
  const int sign = passage.excess.sign_at(t);
  return sign > 0 || (sign == 0 && passage.excess.c1.sign() >= 0);
}

/// Passages that join one another, sorted by where they begin, then by id.
using Joined = std::span<const ExactPassage>;

struct Change {
  Fraction t;
  const ExactTet* tet;
};

/// Finds the changes in passages that join one another, one after the other.
class ChangeSearch {
 public:
  explicit ChangeSearch(Joined joined)
      : joined_(joined), now_{joined.front().in, joined.front().excess.sign_at(joined.front().in) >= 0} {}

  /// The side that the ray is on.
  bool is_inside() const { return now_.is_inside; }

  std::optional<Change> next() {
    while (!joined_.empty() && compare(joined_.front().out, now_.t) <= 0) joined_ = joined_.subspan(1);
    std::optional<Change> first;
    for (const ExactPassage& passage : joined_) {
      if (first && compare(passage.in, first->t) >= 0) break;
      auto t = change_in(passage, now_);
      if (t && (!first || compare(*t, first->t) < 0)) first = Change{std::move(*t), passage.tet};
    }
    if (first) now_ = {first->t, !now_.is_inside, now_.is_inside};
    return first;
  }

 private:
  Joined joined_;
  Standing now_;
};

/// Calls act(Joined) for the joined parts of the ray, front to back, until it returns false.
template <class Act>
void for_each_joined(std::span<const MetTet> met, const Ray& ray, double isovalue, Act&& act) {
  std::vector<ExactPassage> passages;
  for (const MetTet& each : met)
    if (auto passage = passage_of(*each.tet, ray, isovalue)) passages.push_back(std::move(*passage));
  std::sort(passages.begin(), passages.end(), [](const ExactPassage& a, const ExactPassage& b) {
    const int order = compare(a.in, b.in);
    return order != 0 ? order < 0 : a.tet->id < b.tet->id;
  });
  for (std::size_t begin = 0; begin < passages.size();) {
    std::size_t end = begin + 1;
    const Fraction* reaches = &passages[begin].out;
    for (; end < passages.size() && compare(passages[end].in, *reaches) <= 0; ++end)
      if (compare(passages[end].out, *reaches) > 0) reaches = &passages[end].out;
    if (!act(Joined(passages).subspan(begin, end - begin))) return;
    begin = end;
  }
}

TetRayVerdict rational_first_crossing(std::span<const MetTet> met, const Ray& ray, double isovalue) {
  TetRayVerdict verdict;
  for_each_joined(met, ray, isovalue, [&](Joined joined) {
    ChangeSearch search(joined);
    const bool starts_inside = search.is_inside();
    const std::optional<Change> first = search.next();
    if (!first) return true;
    verdict.is_hit = true;
    verdict.t = exact::enclosing(first->t.rational());
    verdict.cell = first->tet->id;
    verdict.touches = !starts_inside && std::none_of(joined.begin(), joined.end(), [&](const ExactPassage& passage) {
      return goes_on_inside(passage, first->t);
    });
    return false;
  });
  verdict.road = Road::exact;
  verdict.tets_exact = static_cast<std::int64_t>(met.size());
  return verdict;
}

/// Returns the passages in which the side changes, in their order along the ray. Returns nothing
/// when a passage is not certain, when passages may overlap, or when they disagree where they may
/// meet.
std::optional<std::vector<const CertainPassage*>> certain_changes(std::span<const MetTet> met) {
  std::vector<const CertainPassage*> passages;
  for (const MetTet& each : met) {
    if (!each.passage) return std::nullopt;
    passages.push_back(&*each.passage);
  }
  std::sort(passages.begin(), passages.end(),
            [](const CertainPassage* a, const CertainPassage* b) { return a->t_in.middle < b->t_in.middle; });
  for (std::size_t p = 1; p < passages.size(); ++p) {
    const CertainPassage &here = *passages[p], &before = *passages[p - 1];
    const int gap = (here.t_in - before.t_out).sign();
    if (gap < 0 || (gap == 0 && here.value_in.sign() != before.value_out.sign())) return std::nullopt;
  }
  std::erase_if(passages, [](const CertainPassage* p) { return p->value_in.sign() == p->value_out.sign(); });
  return passages;
}

struct ChangeFound {
  Enclosure t{};
  Road road = Road::filter;
};

/// Finds where the side changes in a certain passage: exactly where doubles are not precise enough.
ChangeFound change_in(const CertainPassage& passage, const Ray& ray, double isovalue, double width) {
  const Ball share = passage.value_in / (passage.value_in - passage.value_out);
  const Ball t = passage.t_in + share * (passage.t_out - passage.t_in);
  if (const Enclosure found = t.enclosure(); found.width() <= width) return {found, Road::filter};
  return {exact::enclosing(passage_of(*passage.tet, ray, isovalue)->excess.zero().rational()), Road::exact};
}

/// As rational_first_crossing, from what certain_changes returns.
TetRayVerdict first_crossing_of(std::span<const CertainPassage* const> changes, const Ray& ray, double isovalue,
                                double width) {
  if (changes.empty()) return {};
  const ChangeFound change = change_in(*changes.front(), ray, isovalue, width);
  return {.is_hit = true,
          .t = change.t,
          .cell = changes.front()->tet->id,
          .road = change.road,
          .tets_exact = change.road == Road::exact ? 1 : 0};
}

/// Calls act(std::span<const MetTet>) for groups of tetrahedra, front to back, until it returns
/// false. Groups are certainly apart along the ray: what is in different ones does not join.
template <class Act>
void for_each_group(std::span<const ExactTet> tets, const Ray& ray, double isovalue, Act&& act) {
  if (!is_ray(ray) || !std::isfinite(isovalue)) return;
  const PicturePlane view(ray, isovalue);
  std::vector<MetTet> met;
  for (const ExactTet& tet : tets)
    if (has_data(tet))
      if (auto seen = view.look(tet)) met.push_back(std::move(*seen));
  std::sort(met.begin(), met.end(), [](const MetTet& a, const MetTet& b) { return a.t.lo < b.t.lo; });
  for (std::size_t begin = 0; begin < met.size();) {
    double reaches = met[begin].t.hi;
    std::size_t end = begin + 1;
    for (; end < met.size() && met[end].t.lo <= reaches; ++end) reaches = std::max(reaches, met[end].t.hi);
    if (!act(std::span<const MetTet>(met).subspan(begin, end - begin))) return;
    begin = end;
  }
}

}  // namespace

TetRayVerdict exact_first_crossing(std::span<const ExactTet> tets, const Ray& ray, double isovalue, double width) {
  TetRayVerdict verdict;
  for_each_group(tets, ray, isovalue, [&](std::span<const MetTet> group) {
    const TetRayVerdict before = verdict;
    const auto changes = certain_changes(group);
    verdict =
        changes ? first_crossing_of(*changes, ray, isovalue, width) : rational_first_crossing(group, ray, isovalue);
    verdict.tets_exact += before.tets_exact;
    if (before.road == Road::exact) verdict.road = Road::exact;
    return !verdict.is_hit;
  });
  return verdict;
}

std::vector<TetCrossing> exact_crossings(std::span<const ExactTet> tets, const Ray& ray, double isovalue, double width,
                                         std::size_t most) {
  std::vector<TetCrossing> crossings;
  const auto add = [&](const Enclosure& t, const ExactTet& tet, bool to_inside) {
    if (crossings.size() < most)
      crossings.push_back({crossings.empty() ? t : not_below(crossings.back().t, t), tet.id, to_inside});
    return crossings.size() < most;
  };
  for_each_group(tets, ray, isovalue, [&](std::span<const MetTet> group) {
    if (const auto changes = certain_changes(group)) {
      for (const CertainPassage* passage : *changes)
        if (!add(change_in(*passage, ray, isovalue, width).t, *passage->tet, passage->value_out.sign() > 0)) break;
    } else {
      for_each_joined(group, ray, isovalue, [&](Joined joined) {
        ChangeSearch search(joined);
        while (const auto change = search.next())
          if (!add(exact::enclosing(change->t.rational()), *change->tet, search.is_inside())) break;
        return crossings.size() < most;
      });
    }
    return crossings.size() < most;
  });
  return crossings;
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

#include "tools/validate/exact_tets.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>
#include <CGAL/Interval_nt.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "tools/validate/shot.h"

namespace rhoray::tools::validate {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Exact = CGAL::Exact_rational;
using Interval = CGAL::Interval_nt<false>;  // within Protect_FPU_rounding

/// A cell's box as a primitive of CGAL's tree.
class BoxPrimitive {
 public:
  using Id = std::uint32_t;
  using Point = Kernel::Point_3;
  using Datum = Kernel::Iso_cuboid_3;

  BoxPrimitive(Id cell, const Box3& box)
      : cell_(cell), box_(Point(box.min.x, box.min.y, box.min.z), Point(box.max.x, box.max.y, box.max.z)) {}

  Id id() const { return cell_; }
  const Datum& datum() const { return box_; }
  Point reference_point() const { return box_.min(); }

 private:
  Id cell_;
  Datum box_;
};

using Aabb = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, BoxPrimitive>>;

template <class Number>
using Point3 = std::array<Number, 3>;

template <class Number>
Number determinant(const Point3<Number>& a, const Point3<Number>& b, const Point3<Number>& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/// A ray's intersection with a face, and value - isovalue there.
template <class Number>
struct FacePoint {
  Number t, excess;
};

/// Finds the ray's crossing of a closed cell. Comparisons of overlapping intervals throw; rational
/// numbers always decide. Consider a point on the plane of the corners a, b, c, all relative to the
/// ray's origin. By Cramer's rule, the weight of a is det(d, b, c) over the sum of the three
/// weights, and t is det(a, b, c) over that sum.
template <class Number>
std::optional<Number> crossing(const render::Ray& ray, const TetField::Cell& cell, double isovalue) {
  using Vector = Point3<Number>;
  const Vector d{Number(ray.direction.x), Number(ray.direction.y), Number(ray.direction.z)};
  std::array<Vector, 4> corner;
  std::array<Number, 4> excess;
  for (std::size_t v = 0; v < 4; ++v) {
    for (std::size_t a = 0; a < 3; ++a)
      corner[v][a] = Number(cell.point[v][a]) - Number(ray.origin[static_cast<int>(a)]);
    excess[v] = Number(cell.value[v]) - Number(isovalue);
  }

  std::array<FacePoint<Number>, 4> points;
  std::size_t count = 0;
  constexpr std::array<std::array<std::size_t, 3>, 4> faces{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  for (const auto& [a, b, c] : faces) {
    const std::array<Number, 3> weight{determinant(d, corner[b], corner[c]), determinant(d, corner[c], corner[a]),
                                       determinant(d, corner[a], corner[b])};
    // Two weights of certainly opposite signs are enough to reject.
    const auto is_one = [&](const auto& compare) { return std::any_of(weight.begin(), weight.end(), compare); };
    if (is_one([](const Number& w) { return CGAL::certainly(w < Number(0)); }) &&
        is_one([](const Number& w) { return CGAL::certainly(w > Number(0)); }))
      continue;
    const bool negative = is_one([](const Number& w) { return static_cast<bool>(w < Number(0)); });
    const bool positive = is_one([](const Number& w) { return static_cast<bool>(w > Number(0)); });
    if (negative == positive) continue;
    const Number sum = weight[0] + weight[1] + weight[2];
    points[count++] = {determinant(corner[a], corner[b], corner[c]) / sum,
                       (weight[0] * excess[a] + weight[1] * excess[b] + weight[2] * excess[c]) / sum};
  }
  if (count < 2) return std::nullopt;
  FacePoint<Number> in = points[0], out = points[0];
  bool is_below = false, is_above = false;  // at any of the points
  for (std::size_t p = 0; p < count; ++p) {
    if (p > 0 && points[p].t < in.t) in = points[p];
    if (p > 0 && points[p].t > out.t) out = points[p];
    (points[p].excess < Number(0) ? is_below : is_above) = true;
  }
  if (!(is_below && is_above) || out.t < Number(0)) return std::nullopt;

  Vector edge[3];
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t a = 0; a < 3; ++a) edge[v][a] = corner[v + 1][a] - corner[0][a];
  const Number volume = determinant(edge[0], edge[1], edge[2]);
  if (volume == Number(0)) {
    // In a cell without volume the field jumps where the ray passes the plane, from one face's
    // value to the other's.
    if (in.t == out.t) return in.t;
    return std::nullopt;
  }
  if (in.t == out.t) return std::nullopt;
  if (in.t < Number(0)) {
    in.excess = in.excess - in.t * (out.excess - in.excess) / (out.t - in.t);
    in.t = Number(0);
    if ((in.excess < Number(0)) == (out.excess < Number(0))) return std::nullopt;
  }
  return in.t + (out.t - in.t) * in.excess / (in.excess - out.excess);
}

std::optional<double> decided_crossing(const render::Ray& ray, const TetField::Cell& cell, double isovalue) {
  constexpr double wanted_width = 1e-13;  // relative to t
  try {
    const CGAL::Protect_FPU_rounding<true> protect;
    const auto t = crossing<Interval>(ray, cell, isovalue);
    if (!t) return std::nullopt;
    const double width = t->sup() - t->inf();
    if (width <= wanted_width * std::max(std::abs(t->inf()), std::abs(t->sup()))) return t->inf() + width / 2;
  } catch (const CGAL::Uncertain_conversion_exception&) {
    // Decided below.
  }
  const auto t = crossing<Exact>(ray, cell, isovalue);
  return t ? std::optional(CGAL::to_double(*t)) : std::nullopt;
}

}  // namespace

struct ExactTets::Boxes {
  Box3 all;
  Aabb aabb;
};

ExactTets::ExactTets(const TetField& field, const std::vector<std::uint32_t>& straddling, double isovalue)
    : field_(&field), isovalue_(isovalue), boxes_(std::make_unique<Boxes>()) {
  for (const std::uint32_t cell : straddling) boxes_->all.extendBy(field.cell(cell).box());
  const double slack = 1e-12 * boxes_->all.size().length();  // far above a shot's rounding
  std::vector<BoxPrimitive> boxes;
  for (const std::uint32_t cell : straddling) {
    const Box3 box = field.cell(cell).box();
    boxes.emplace_back(cell, Box3(box.min - Vec3(slack), box.max + Vec3(slack)));
  }
  for (const BoxPrimitive& box : boxes) boxes_->aabb.insert(box);
  if (!boxes.empty()) boxes_->aabb.build();
}

ExactTets::~ExactTets() = default;
ExactTets::ExactTets(ExactTets&&) noexcept = default;
ExactTets& ExactTets::operator=(ExactTets&&) noexcept = default;

std::optional<double> ExactTets::crossing_in(const render::Ray& ray, std::uint32_t cell) const {
  return decided_crossing(ray, field_->cell(cell), isovalue_);
}

std::optional<ExactTets::Crossing> ExactTets::first_crossing(const render::Ray& ray) const {
  if (boxes_->aabb.empty()) return std::nullopt;
  std::vector<std::uint32_t> candidates;
  boxes_->aabb.all_intersected_primitives(shot_of(ray, boxes_->all), std::back_inserter(candidates));
  std::optional<Crossing> first;
  for (const std::uint32_t cell : candidates) {
    const std::optional<double> t = decided_crossing(ray, field_->cell(cell), isovalue_);
    if (t && (!first || *t < first->t)) first = Crossing{.t = *t, .cell = cell};
  }
  return first;
}

}  // namespace rhoray::tools::validate

#include "preprocess/workers/tetgen/triangle_crossings.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <utility>

namespace rhoray::preprocess {

namespace {

using Predicates = CGAL::Exact_predicates_inexact_constructions_kernel;
using Exact = CGAL::Exact_predicates_exact_constructions_kernel;
using Corners = std::array<std::uint64_t, 3>;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint64_t>;

template <class Kernel>
typename Kernel::Point_3 point_of(const std::array<double, 3>& p) {
  return {p[0], p[1], p[2]};
}

class Soup {
 public:
  Soup(std::span<const std::array<double, 3>> points, std::span<const Corners> triangles)
      : points_(points), triangles_(triangles) {}

  bool cross(std::uint64_t first, std::uint64_t second) const {
    // Shared corners come first in both, in the same order.
    Corners a = triangles_[first], b = triangles_[second];
    std::size_t shared = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto same = std::find(b.begin() + static_cast<std::ptrdiff_t>(shared), b.end(), a[i]);
      if (same == b.end()) continue;
      std::swap(*same, b[shared]);
      std::swap(a[i], a[shared]);
      ++shared;
    }
    if (shared == 2) {  // an edge in common: they overlap when they are folded flat onto the same side of it
      const auto p = point(a[0]), q = point(a[1]), r = point(a[2]), s = point(b[2]);
      return CGAL::coplanar(p, q, r, s) && CGAL::coplanar_orientation(p, q, r, s) == CGAL::POSITIVE;
    }
    if (shared == 1)
      return CGAL::do_intersect(triangle(a), edge(b[1], b[2])) || CGAL::do_intersect(triangle(b), edge(a[1], a[2]));
    return CGAL::do_intersect(triangle(a), triangle(b));
  }

  /// The middle of what two crossing triangles have in common.
  std::array<double, 3> place(std::uint64_t first, std::uint64_t second) const {
    const auto common = CGAL::intersection(exact_triangle(first), exact_triangle(second));
    std::vector<Exact::Point_3> corners;
    if (const auto* p = boost::get<Exact::Point_3>(&*common))
      corners = {*p};
    else if (const auto* s = boost::get<Exact::Segment_3>(&*common))
      corners = {s->source(), s->target()};
    else if (const auto* t = boost::get<Exact::Triangle_3>(&*common))
      corners = {t->vertex(0), t->vertex(1), t->vertex(2)};
    else
      corners = boost::get<std::vector<Exact::Point_3>>(*common);
    std::array<double, 3> middle{};
    for (const auto& p : corners)
      for (int axis = 0; axis < 3; ++axis)
        middle[static_cast<std::size_t>(axis)] += CGAL::to_double(p[axis]) / static_cast<double>(corners.size());
    return middle;
  }

  Box box(std::uint64_t t) const {
    return {point(triangles_[t][0]).bbox() + point(triangles_[t][1]).bbox() + point(triangles_[t][2]).bbox(), t};
  }

 private:
  Predicates::Point_3 point(std::uint64_t p) const { return point_of<Predicates>(points_[p]); }
  Predicates::Segment_3 edge(std::uint64_t p, std::uint64_t q) const { return {point(p), point(q)}; }
  Predicates::Triangle_3 triangle(const Corners& c) const { return {point(c[0]), point(c[1]), point(c[2])}; }
  Exact::Triangle_3 exact_triangle(std::uint64_t t) const {
    const Corners& c = triangles_[t];
    return {point_of<Exact>(points_[c[0]]), point_of<Exact>(points_[c[1]]), point_of<Exact>(points_[c[2]])};
  }

  std::span<const std::array<double, 3>> points_;
  std::span<const Corners> triangles_;
};

}  // namespace

Crossings find_crossings(std::span<const std::array<double, 3>> points, std::span<const Corners> triangles,
                         std::size_t most_places) {
  const Soup soup(points, triangles);
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (std::uint64_t t = 0; t < triangles.size(); ++t) boxes.push_back(soup.box(t));

  std::vector<std::pair<std::uint64_t, std::uint64_t>> pairs;
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
    const auto [first, second] = std::minmax({a.info(), b.info()});
    if (soup.cross(first, second)) pairs.emplace_back(first, second);
  });
  std::sort(pairs.begin(), pairs.end());  // the box tree visits in an order of its own

  Crossings found;
  found.pair_count = pairs.size();
  for (const auto& [first, second] : pairs) found.triangles.insert(found.triangles.end(), {first, second});
  std::sort(found.triangles.begin(), found.triangles.end());
  found.triangles.erase(std::unique(found.triangles.begin(), found.triangles.end()), found.triangles.end());
  for (std::size_t i = 0; i < std::min(pairs.size(), most_places); ++i)
    found.first_pairs.push_back({pairs[i].first, pairs[i].second, soup.place(pairs[i].first, pairs[i].second)});
  return found;
}

bool are_collinear(const std::array<double, 3>& a, const std::array<double, 3>& b, const std::array<double, 3>& c) {
  return CGAL::collinear(point_of<Predicates>(a), point_of<Predicates>(b), point_of<Predicates>(c));
}

bool are_coplanar(std::span<const std::array<double, 3>> points) {
  const auto p = [&](std::size_t i) { return point_of<Predicates>(points[i]); };
  std::size_t second = 1, third = 1;
  while (second < points.size() && points[second] == points[0]) ++second;
  if (second >= points.size()) return true;
  while (third < points.size() && CGAL::collinear(p(0), p(second), p(third))) ++third;
  if (third >= points.size()) return true;
  const auto a = p(0), b = p(second), c = p(third);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!CGAL::coplanar(a, b, c, p(i))) return false;
  return true;
}

}  // namespace rhoray::preprocess

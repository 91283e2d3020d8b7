#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <gtest/gtest.h>

#include <optional>

#include "render/exact/exact_tets.h"
#include "tests/render/support/rays.h"

namespace rhoray::render {
namespace {

using tests::Dice;
using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Number = Kernel::FT;
using Point = Kernel::Point_3;

Point cgal_point(const Vec3& p) {
  return {p.x, p.y, p.z};
}

struct Part {
  Number in, out;
};

/// Returns the part of a line in a tetrahedron, by CGAL's intersections with its four triangles.
std::optional<Part> part_in(const ExactTet& tet, const Ray& ray) {
  const Kernel::Vector_3 direction(ray.direction.x, ray.direction.y, ray.direction.z);
  const Kernel::Line_3 line(cgal_point(ray.origin), direction);
  std::optional<Part> part;
  const auto take = [&](const Point& p) {
    const Number t = (p - cgal_point(ray.origin)) * direction / direction.squared_length();
    if (!part) part = Part{t, t};
    part->in = CGAL::min(part->in, t);
    part->out = CGAL::max(part->out, t);
  };
  for (std::size_t left_out = 0; left_out < 4; ++left_out) {
    std::array<Point, 3> p;
    for (std::size_t i = 0, k = 0; i < 4; ++i)
      if (i != left_out) p[k++] = cgal_point(tet.point[i]);
    const Kernel::Triangle_3 triangle(p[0], p[1], p[2]);
    if (triangle.is_degenerate()) continue;
    const auto meets = CGAL::intersection(line, triangle);
    if (!meets) continue;
    if (const Point* point = boost::get<Point>(&*meets)) take(*point);
    if (const Kernel::Segment_3* segment = boost::get<Kernel::Segment_3>(&*meets)) {
      take(segment->source());
      take(segment->target());
    }
  }
  return part;
}

/// Returns the linear field at a parameter of the line, by volumes of CGAL's tetrahedra.
Number value_at(const ExactTet& tet, const Ray& ray, const Number& t) {
  const Point x = cgal_point(ray.origin) + t * Kernel::Vector_3(ray.direction.x, ray.direction.y, ray.direction.z);
  const std::array p{cgal_point(tet.point[0]), cgal_point(tet.point[1]), cgal_point(tet.point[2]),
                     cgal_point(tet.point[3])};
  const Number whole = CGAL::volume(p[0], p[1], p[2], p[3]);
  return (CGAL::volume(x, p[1], p[2], p[3]) * tet.value[0] + CGAL::volume(p[0], x, p[2], p[3]) * tet.value[1] +
          CGAL::volume(p[0], p[1], x, p[3]) * tet.value[2] + CGAL::volume(p[0], p[1], p[2], x) * tet.value[3]) /
         whole;
}

struct Case {
  ExactTet tet;
  Ray ray;
};

/// Tetrahedra with integer and arbitrary coordinates, slivers and needles, and lines aimed at their
/// vertices, edges and faces.
Case any_case(Dice& dice) {
  Case made;
  const std::int64_t kind = dice.below(4);
  for (std::size_t i = 0; i < 4; ++i) {
    made.tet.value[i] = kind == 0 ? static_cast<double>(dice.below(4)) : dice.between(0, 3);
    for (int axis = 0; axis < 3; ++axis)
      made.tet.point[i][axis] = kind == 0 ? static_cast<double>(dice.below(4)) : dice.between(0, 3);
    if (kind == 2) made.tet.point[i].z *= 1e-12;
    if (kind == 3) made.tet.point[i] = 1e5 * Vec3(1, -1, 0.5) + made.tet.point[i];
  }
  Vec3 target(0, 0, 0);
  const std::int64_t corners = 1 + dice.below(4);
  for (std::size_t i = 0; i < static_cast<std::size_t>(corners); ++i)
    target += made.tet.point[i] / static_cast<double>(corners);
  made.ray.t_min = -1e9;
  made.ray.direction = dice.coin() ? dice.direction() : made.tet.point[3] - made.tet.point[2];
  if (made.ray.direction == Vec3(0, 0, 0)) made.ray.direction.y = 1;
  made.ray.origin = target + dice.one_of(std::array{0.0, 1.0, -4.0}) * made.ray.direction;
  return made;
}

TEST(JudgeAgainstCgal, cuts_lines_with_tetrahedra_as_cgal_does) {
  Dice dice(31);
  int met = 0, points = 0, missed = 0, crossed = 0;
  for (int round = 0; round < 3000; ++round) {
    const Case here = any_case(dice);
    const std::array tets{here.tet};
    const auto& p = here.tet.point;
    const bool is_flat = CGAL::coplanar(cgal_point(p[0]), cgal_point(p[1]), cgal_point(p[2]), cgal_point(p[3]));
    const auto part = part_in(here.tet, here.ray);
    const TetMaximumVerdict maximum = exact_largest_value(tets, here.ray);
    ASSERT_EQ(maximum.has_value, !is_flat && part && part->in < part->out) << round;
    points += part && part->in == part->out;
    missed += !part;
    if (!maximum.has_value) continue;
    ++met;
    const Number at_in = value_at(here.tet, here.ray, part->in), at_out = value_at(here.tet, here.ray, part->out);
    const Number& larger = at_out > at_in ? at_out : at_in;
    ASSERT_TRUE(Number(maximum.value.lo) <= larger && larger <= Number(maximum.value.hi)) << round;
    const Number& where = at_out > at_in ? part->out : part->in;
    ASSERT_TRUE(Number(maximum.t.lo) <= where && where <= Number(maximum.t.hi)) << round;

    const double isovalue = dice.coin() ? here.tet.value[0] : dice.between(0, 3);
    const TetRayVerdict verdict = exact_first_crossing(tets, here.ray, isovalue, 1e-13);
    const bool inside_in = at_in >= isovalue, inside_out = at_out >= isovalue;
    ASSERT_EQ(verdict.is_hit, inside_in != inside_out) << round;
    if (!verdict.is_hit) continue;
    ++crossed;
    const Number t = part->in + (part->out - part->in) * (at_in - isovalue) / (at_in - at_out);
    ASSERT_TRUE(Number(verdict.t.lo) <= t && t <= Number(verdict.t.hi)) << round;
    ASSERT_EQ(verdict.touches, !inside_in && t == part->out) << round;
  }
  EXPECT_GT(met, 1000);
  EXPECT_GT(points, 100);
  EXPECT_GT(missed, 10);
  EXPECT_GT(crossed, 200);
}

}  // namespace
}  // namespace rhoray::render

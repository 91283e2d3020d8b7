#include "render/cell/tet_crossing.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/render/support/exact.h"
#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::clip;
using render::edge_weight;
using render::FaceCrossing;
using render::passes_left;
using render::Ray;
using render::RayShear;
using render::SeenTet;
using render::tet_gradient;
using render::TetPassage;
using Seen = RayShear::Seen;
using Points = std::array<std::array<double, 3>, 4>;
using Values = std::array<double, 4>;

SeenTet see(const Ray& ray, const Points& points, const Values& values) {
  const RayShear shear(ray);
  return {{shear.see(points[0]), shear.see(points[1]), shear.see(points[2]), shear.see(points[3])}, values};
}

std::array<double, 3> to_array(const Vec3& p) {
  return {p.x, p.y, p.z};
}

Points any_points(Dice& dice, double flatness = 1) {
  const Vec3 squeezed = dice.direction();
  Points points;
  for (auto& point : points) {
    Vec3 p = dice.point({-1, -1, -1}, {1, 1, 1});
    p -= (1 - flatness) * p.dot(squeezed) * squeezed;
    point = to_array(p);
  }
  return points;
}

/// Twice the signed area of the triangle 0, a, b: exact.
Rational exact_cross(const Seen& a, const Seen& b) {
  return exact(a.x) * exact(b.y) - exact(a.y) * exact(b.x);
}

/// The same for the ray at (e, e^2), with e > 0 as small as needed: the first coefficient that is
/// not zero decides.
bool exactly_left(const Seen& a, const Seen& b) {
  for (const Rational& coefficient :
       {exact_cross(a, b), Rational(exact(a.y) - exact(b.y)), Rational(exact(b.x) - exact(a.x))})
    if (const int sign = sign_of(coefficient); sign != 0) return sign > 0;
  return false;
}

/// Edges that pass close by the ray or through it: collinear up to rounding, containing it, along
/// axes, coincident.
std::vector<std::array<Seen, 2>> difficult_edges() {
  Dice dice(1);
  std::vector<std::array<Seen, 2>> edges;
  for (int trial = 0; trial < 20000; ++trial) {
    Seen a{dice.between(-1, 1), dice.between(-1, 1), 0};
    const double factor = dice.coin() ? dice.between(-3, 3) : static_cast<double>(dice.below(9) - 4);
    Seen b{a.x * factor, a.y * factor, 1};
    if (dice.coin() && b.x != 0) b.x = std::nextafter(b.x, dice.between(-1, 1));
    if (dice.coin() && b.y != 0) b.y = std::nextafter(b.y, dice.between(-1, 1));
    if (dice.below(6) == 0) (dice.coin() ? a.x : a.y) = dice.coin() ? 0.0 : -0.0;
    if (dice.below(6) == 0) (dice.coin() ? b.x : b.y) = dice.coin() ? 0.0 : -0.0;
    if (dice.below(20) == 0) b = a;
    if (dice.below(20) == 0) a = {0, 0, 0};
    edges.push_back({a, b});
  }
  return edges;
}

TEST(PassesLeft, is_the_exact_sign_also_where_rounded_products_are_equal) {
  int undecided_by_rounding = 0, through_the_ray = 0, wrong_by_rounding = 0;
  for (const auto& [a, b] : difficult_edges()) {
    EXPECT_EQ(passes_left(a, b), exactly_left(a, b)) << a.x << " " << a.y << ", " << b.x << " " << b.y;
    const double naive = a.x * b.y - a.y * b.x;
    undecided_by_rounding += naive == 0 && exact_cross(a, b) != 0;
    wrong_by_rounding += (naive > 0) != exactly_left(a, b);
    through_the_ray += exact_cross(a, b) == 0;
  }
  EXPECT_GT(undecided_by_rounding, 1000) << "rounded products decide here: are these still the difficult edges?";
  EXPECT_GT(wrong_by_rounding, 1000);
  EXPECT_GT(through_the_ray, 1000);
}

TEST(PassesLeft, says_the_opposite_for_the_edge_turned_round) {
  for (const auto& [a, b] : difficult_edges())
    if (a.x != b.x || a.y != b.y) {
      EXPECT_NE(passes_left(a, b), passes_left(b, a));
    }
}

TEST(EdgeWeight, is_twice_the_area_without_cancellation) {
  for (const auto& [a, b] : difficult_edges()) {
    const double area = std::abs(rounded(exact_cross(a, b)));
    const double products = std::abs(a.x * b.y) + std::abs(a.y * b.x);
    EXPECT_NEAR(edge_weight(a, b), area, 4e-16 * area + 1e-31 * products);
    EXPECT_EQ(edge_weight(a, b), edge_weight(b, a));
  }
}

TEST(RayShear, sees_a_point_of_the_ray_in_the_middle_and_at_its_t) {
  Dice dice(2);
  for (int trial = 0; trial < 2000; ++trial) {
    const Ray ray{.origin = dice.point({-5, -5, -5}, {5, 5, 5}), .direction = dice.direction() * 3.0};
    const double t = dice.between(-2, 2);
    const Seen seen = RayShear(ray).see(to_array(ray.at(t)));
    EXPECT_NEAR(seen.x, 0, 1e-14);
    EXPECT_NEAR(seen.y, 0, 1e-14);
    EXPECT_NEAR(seen.t, t, 1e-14);
  }
}

/// Returns how many faces a ray passes through, by the rule of passes_left alone.
int faces_crossed(const SeenTet& tet) {
  int count = 0;
  const auto left = [&](std::size_t a, std::size_t b) { return passes_left(tet.vertex[a], tet.vertex[b]); };
  for (const auto& [i, j, k] : {std::array<std::size_t, 3>{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}})
    count += left(i, j) == left(j, k) && left(i, j) != left(i, k);
  return count;
}

/// Rays aimed at the parts of a tetrahedron: inside, faces, edges, vertices; along edges; in planes
/// of faces.
std::vector<Ray> rays_at(const Points& points, Dice& dice) {
  const auto vertex = [&](std::size_t i) { return Vec3(points[i][0], points[i][1], points[i][2]); };
  std::vector<Ray> rays;
  const auto aim = [&](const Vec3& target, const Vec3& direction) {
    rays.push_back({.origin = target - dice.between(1, 4) * direction, .direction = direction});
  };
  const auto share = [&] { return dice.below(4) == 0 ? 0.5 : dice.between(0, 1); };
  for (int trial = 0; trial < 4; ++trial) {
    std::array<double, 4> w{dice.between(0, 1), dice.between(0, 1), dice.between(0, 1), dice.between(0, 1)};
    const double sum = w[0] + w[1] + w[2] + w[3];
    aim((w[0] * vertex(0) + w[1] * vertex(1) + w[2] * vertex(2) + w[3] * vertex(3)) / sum, dice.direction());
  }
  for (std::size_t i = 0; i < 4; ++i) {
    aim(vertex(i), dice.direction());
    aim(vertex(i), Vec3(0, 0, 1));
    for (std::size_t j = 0; j < 4; ++j) {
      if (i == j) continue;
      const Vec3 along = vertex(j) - vertex(i);
      aim(vertex(i) + share() * along, dice.direction());
      if (along.length() == 0) continue;
      aim(vertex(i), along);  // along the edge
      const std::size_t k = (6 - i - j) / 2 == i ? 0 : 6 - i - j > 3 ? 3 : 6 - i - j;
      if (k == i || k == j) continue;
      const Vec3 in_face = share() * along + share() * (vertex(k) - vertex(i));
      // In the plane of a face.
      if (in_face.length() > 0) aim(vertex(i) + share() * along, in_face);
    }
  }
  return rays;
}

std::vector<Points> difficult_tets() {
  Dice dice(3);
  std::vector<Points> tets;
  for (int trial = 0; trial < 400; ++trial) tets.push_back(any_points(dice));
  for (int trial = 0; trial < 400; ++trial) tets.push_back(any_points(dice, std::pow(10, dice.between(-17, -1))));
  for (int trial = 0; trial < 200; ++trial) tets.push_back(any_points(dice, 0));
  // Integers: exactly flat, collinear and coincident ones are among them.
  for (int trial = 0; trial < 400; ++trial) {
    Points points;
    for (auto& point : points)
      for (double& x : point) x = static_cast<double>(dice.below(3));
    tets.push_back(points);
  }
  return tets;
}

TEST(PassThrough, crosses_no_face_or_two_of_every_tetrahedron) {
  Dice dice(4);
  int none = 0, two = 0;
  for (const Points& points : difficult_tets())
    for (const Ray& ray : rays_at(points, dice)) {
      const SeenTet tet = see(ray, points, {1, 2, 3, 4});
      const int crossed = faces_crossed(tet);
      ASSERT_TRUE(crossed == 0 || crossed == 2) << crossed;
      EXPECT_EQ(pass_through(tet, 0).has_value(), crossed == 2);
      (crossed == 0 ? none : two)++;
    }
  EXPECT_GT(none, 10000);
  EXPECT_GT(two, 10000);
}

/// Returns the part of a ray in a tetrahedron of positive volume, by exact half-spaces; empty when
/// it misses.
struct ExactPassage {
  bool hits = true;
  Rational t_in = -1000000, t_out = 1000000;
};
ExactPassage exact_passage(const Ray& ray, const Points& points) {
  ExactPassage passage;
  const ExactVec3 o = exact(ray.origin), d = exact(ray.direction);
  for (std::size_t v = 0; v < 4; ++v) {
    const ExactVec3 p = exact(points[(v + 1) % 4]);
    ExactVec3 n = (exact(points[(v + 2) % 4]) - p).cross(exact(points[(v + 3) % 4]) - p);
    const Rational orientation = n.dot(exact(points[v]) - p);
    if (orientation < 0) n = {-n.x, -n.y, -n.z};
    // Inside is at_origin + t slope >= 0.
    const Rational at_origin = n.dot(o - p), slope = n.dot(d);
    if (slope == 0) {
      if (at_origin < 0) passage.hits = false;
      continue;
    }
    const Rational t = -at_origin / slope;
    if (slope > 0 && t > passage.t_in) passage.t_in = t;
    if (slope < 0 && t < passage.t_out) passage.t_out = t;
  }
  if (passage.t_in > passage.t_out) passage.hits = false;
  return passage;
}

/// Returns the smallest barycentric coordinate of the ray's point at t.
double depth(const Ray& ray, const Points& points, const Rational& t) {
  const ExactVec3 o = exact(ray.origin), d = exact(ray.direction);
  const ExactVec3 p{o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
  Rational smallest = 1;
  for (std::size_t v = 0; v < 4; ++v) {
    const ExactVec3 q = exact(points[(v + 1) % 4]);
    const ExactVec3 n = (exact(points[(v + 2) % 4]) - q).cross(exact(points[(v + 3) % 4]) - q);
    smallest = std::min(smallest, Rational(n.dot(p - q) / n.dot(exact(points[v]) - q)));
  }
  return rounded(smallest);
}

TEST(PassThrough, enters_and_leaves_where_exact_arithmetic_does) {
  Dice dice(5);
  int hits = 0, misses = 0, in_the_boundary = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Points points = any_points(dice);
    const ExactVec3 e1 = exact(points[1]) - exact(points[0]), e2 = exact(points[2]) - exact(points[0]),
                    e3 = exact(points[3]) - exact(points[0]);
    if (std::abs(rounded(e1.dot(e2.cross(e3)))) < 0.2) continue;
    // A field that is a linear function of position.
    const Vec3 slope = dice.direction();
    Values values;
    for (std::size_t v = 0; v < 4; ++v) values[v] = slope.dot(Vec3(points[v][0], points[v][1], points[v][2]));
    for (const Ray& ray : rays_at(points, dice)) {
      const auto passage = pass_through(see(ray, points, values), 0.25);
      const ExactPassage truth = exact_passage(ray, points);
      if (truth.hits && depth(ray, points, (truth.t_in + truth.t_out) / 2) > 1e-12) {
        ASSERT_TRUE(passage);
        ++hits;
      } else {
        truth.hits ? ++in_the_boundary : ++misses;
      }
      if (!passage) continue;
      // What counts as passed through is in the cell, and the values there are those of the field.
      EXPECT_GT(depth(ray, points, exact(passage->in.t)), -1e-13);
      EXPECT_GT(depth(ray, points, exact(passage->out.t)), -1e-13);
      EXPECT_NEAR(passage->in.value, slope.dot(ray.at(passage->in.t)) - 0.25, 1e-13);
      EXPECT_NEAR(passage->out.value, slope.dot(ray.at(passage->out.t)) - 0.25, 1e-13);
    }
  }
  EXPECT_GT(hits, 200);
  EXPECT_GT(misses, 20);
  EXPECT_GT(in_the_boundary, 80);
}

TEST(PassThrough, gives_the_exact_chord_of_a_ray_through_the_inside) {
  Dice dice(6);
  int hits = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Points points = any_points(dice);
    Vec3 center(0, 0, 0);
    for (const auto& p : points) center += 0.25 * Vec3(p[0], p[1], p[2]);
    const Vec3 direction = dice.direction();
    const Ray ray{.origin = center - 3.0 * direction, .direction = direction};
    const ExactPassage truth = exact_passage(ray, points);
    const double length = rounded(truth.t_out - truth.t_in);
    if (!truth.hits || length < 0.05) continue;
    const auto passage = pass_through(see(ray, points, {0, 0, 0, 0}), 0);
    ASSERT_TRUE(passage);
    EXPECT_NEAR(passage->in.t, rounded(truth.t_in), 1e-12);
    EXPECT_NEAR(passage->out.t, rounded(truth.t_out), 1e-12);
    ++hits;
  }
  EXPECT_GT(hits, 150);
}

TEST(PassThrough, agrees_with_the_neighbour_on_the_shared_face_bit_for_bit) {
  Dice dice(7);
  int both = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    // Vertices 0..4 in increasing order of ids; the cells are 0123 and 0124 or 1234: they share a
    // face.
    std::array<std::array<double, 3>, 5> p;
    std::array<double, 5> f;
    for (std::size_t i = 0; i < 5; ++i) {
      p[i] = to_array(dice.point({-1, -1, -1}, {1, 1, 1}));
      f[i] = dice.between(-1, 1);
    }
    const Vec3 target = dice.point({-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3}), direction = dice.direction();
    const Ray ray{.origin = target - 3.0 * direction, .direction = direction};
    const SeenTet a = see(ray, {p[0], p[1], p[2], p[3]}, {f[0], f[1], f[2], f[3]});
    const SeenTet b = see(ray, {p[1], p[2], p[3], p[4]}, {f[1], f[2], f[3], f[4]});
    const FaceCrossing of_a = cross_face(a, 1, 2, 3, 0.1), of_b = cross_face(b, 0, 1, 2, 0.1);
    EXPECT_EQ(of_a.t, of_b.t);
    EXPECT_EQ(of_a.value, of_b.value);
    const auto in_a = pass_through(a, 0.1), in_b = pass_through(b, 0.1);
    const bool crosses_face = passes_left(a.vertex[1], a.vertex[2]) == passes_left(a.vertex[2], a.vertex[3]) &&
                              passes_left(a.vertex[1], a.vertex[2]) != passes_left(a.vertex[1], a.vertex[3]);
    if (crosses_face) {
      ASSERT_TRUE(in_a && in_b);
      EXPECT_TRUE(in_a->in.t == of_a.t || in_a->out.t == of_a.t);
      EXPECT_TRUE(in_b->in.t == of_a.t || in_b->out.t == of_a.t);
      ++both;
    }
  }
  EXPECT_GT(both, 300);
}

TEST(PassThrough, does_not_go_through_a_face_that_it_lies_in) {
  // The ray runs in the plane z = 0 of face 0, 1, 2: it passes through the other faces, at its
  // edges.
  const Points points{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}}};
  for (const double z_sign : {1.0, -1.0}) {
    Points side = points;
    side[3][2] *= z_sign;
    const Ray ray{.origin = {-1, 0.5, 0}, .direction = {1, 0, 0}};
    if (const auto passage = pass_through(see(ray, side, {0, 2, 0, 0}), 0)) {
      EXPECT_EQ(passage->in.t, 1);
      EXPECT_EQ(passage->out.t, 2.5);
      EXPECT_EQ(passage->in.value, 0);
      EXPECT_EQ(passage->out.value, 1.5);
    }
  }
}

TEST(PassThrough, is_the_same_for_inverted_tetrahedra) {
  Dice dice(8);
  for (int trial = 0; trial < 500; ++trial) {
    const Points points = any_points(dice);
    Points mirrored = points;  // at the plane z = 0, rays too: same chord
    for (auto& p : mirrored) p[2] = -p[2];
    const Vec3 direction = dice.direction();
    const Ray ray{.origin = -3.0 * direction, .direction = direction};
    const Ray mirrored_ray{.origin = {ray.origin.x, ray.origin.y, -ray.origin.z},
                           .direction = {direction.x, direction.y, -direction.z}};
    const auto a = pass_through(see(ray, points, {1, 2, 3, 4}), 0);
    const auto b = pass_through(see(mirrored_ray, mirrored, {1, 2, 3, 4}), 0);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    EXPECT_NEAR(a->in.t, b->in.t, 1e-13);
    EXPECT_NEAR(a->out.value, b->out.value, 1e-12);
  }
}

TEST(Clip, cuts_a_passage_and_its_values) {
  const TetPassage passage{{1, 10}, {3, 30}};
  const auto cut = clip(passage, 1.5, 2);
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->in.t, 1.5);
  EXPECT_EQ(cut->in.value, 15);
  EXPECT_EQ(cut->out.t, 2);
  EXPECT_EQ(cut->out.value, 20);
  EXPECT_FALSE(clip(passage, 3.5, 9));
  EXPECT_FALSE(clip(passage, 0, 0.5));
  EXPECT_FALSE(
      clip({{std::numeric_limits<double>::quiet_NaN(), 1}, {std::numeric_limits<double>::quiet_NaN(), 2}}, 0, 9));
  EXPECT_TRUE(clip({{2, 1}, {2, 1}}, 2, 2)) << "length zero is kept";
  EXPECT_EQ(clip(passage, 0, 1)->out.value, 10);
  EXPECT_EQ(clip(passage, 3, 9)->in.value, 30);
}

TEST(FirstCrossing, is_a_change_of_side_between_entry_and_exit) {
  using render::first_crossing;
  EXPECT_EQ(first_crossing({{0, -1}, {4, 3}}), 1.0);
  EXPECT_EQ(first_crossing({{0, 3}, {4, -1}}), 3.0);
  EXPECT_EQ(first_crossing({{0, 1}, {4, 3}}), std::nullopt);
  EXPECT_EQ(first_crossing({{0, -1}, {4, -3}}), std::nullopt);
  EXPECT_EQ(first_crossing({{0, 0}, {4, 3}}), std::nullopt) << "zero is inside";
  EXPECT_EQ(first_crossing({{0, 0}, {4, 0}}), std::nullopt);
  EXPECT_EQ(first_crossing({{0, -1}, {4, 0}}), 4.0);
  EXPECT_EQ(first_crossing({{0, 0}, {4, -1}}), 0.0);
  EXPECT_EQ(first_crossing({{2, -5e-324}, {2, 1}}), 2.0);
  Dice dice(9);
  for (int trial = 0; trial < 5000; ++trial) {
    const double t0 = dice.between(-1e6, 1e6), t1 = t0 + std::pow(10, dice.between(-12, 3));
    const auto t =
        first_crossing({{t0, -std::pow(10, dice.between(-300, 300))}, {t1, std::pow(10, dice.between(-300, 300))}});
    ASSERT_TRUE(t);
    EXPECT_LE(t0, *t);
    EXPECT_GE(t1, *t);
  }
}

TEST(TetGradient, is_that_of_the_linear_field_through_the_four_values) {
  Dice dice(10);
  for (int trial = 0; trial < 500; ++trial) {
    Points points = any_points(dice, std::pow(10, dice.between(-3, 0)));
    Values values;
    for (double& f : values) f = dice.between(-1, 1);
    const ExactVec3 a = exact(points[1]) - exact(points[0]), b = exact(points[2]) - exact(points[0]),
                    c = exact(points[3]) - exact(points[0]);
    const Rational six_volumes = a.dot(b.cross(c));
    const ExactVec3 bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
    const Rational f1 = exact(values[1]) - exact(values[0]), f2 = exact(values[2]) - exact(values[0]),
                   f3 = exact(values[3]) - exact(values[0]);
    const Vec3 truth(rounded((f1 * bc.x + f2 * ca.x + f3 * ab.x) / six_volumes),
                     rounded((f1 * bc.y + f2 * ca.y + f3 * ab.y) / six_volumes),
                     rounded((f1 * bc.z + f2 * ca.z + f3 * ab.z) / six_volumes));
    const double condition = 1 / std::abs(rounded(six_volumes));
    EXPECT_LE((tet_gradient(points, values) - truth).length(), 1e-13 * condition * (1 + truth.length()));
  }
}

TEST(TetGradient, of_a_flat_cell_is_the_normal_of_its_plane_and_of_a_line_zero) {
  const Points flat{{{0, 0, 5}, {1, 0, 5}, {0, 1, 5}, {3, 4, 5}}};
  const Vec3 normal = tet_gradient(flat, {1, 2, 3, 4});
  EXPECT_EQ(normal.x, 0);
  EXPECT_EQ(normal.y, 0);
  EXPECT_NE(normal.z, 0);
  const Points coincident{{{0, 0, 5}, {0, 0, 5}, {0, 1, 5}, {3, 4, 5}}};
  EXPECT_NE(tet_gradient(coincident, {1, 2, 3, 4}).z, 0);
  const Points line{{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}};
  EXPECT_EQ(tet_gradient(line, {1, 2, 3, 4}), Vec3(0, 0, 0));
  const Points point{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
  EXPECT_EQ(tet_gradient(point, {1, 2, 3, 4}), Vec3(0, 0, 0));
}

}  // namespace
}  // namespace rhoray::tests

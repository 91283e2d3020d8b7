#include "preprocess/grid/resample/brick_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace rhoray::preprocess {
namespace {

/// A tetrahedron around a leaf cell, with values at its vertices and at the leaf cell's corners.
struct Case {
  std::array<Point, 4> points;
  FieldView field;
  std::array<double, 8> corners;

  /// The face opposite the last vertex.
  BrickFace face() const { return {{points[0], points[2], points[1]}, {0, 2, 1}, 0}; }
};

template <class Random>
Case random_case(Random& random) {
  std::uniform_real_distribution<double> place(-1, 2), value(-1, 1);
  Case made;
  for (;;) {
    for (Point& p : made.points) p = {place(random), place(random), place(random)};
    const Point e1 = minus(made.points[1], made.points[0]), e2 = minus(made.points[2], made.points[0]);
    if (dot(cross(e1, e2), minus(made.points[3], made.points[0])) > 0.1) break;
  }
  std::array<double, 4> values;
  for (double& v : values) v = value(random);
  for (double& v : made.corners) v = value(random);
  made.field.values.assign(values.begin(), values.end());
  made.field.gradients = {gradient_of(made.points, values)};
  return made;
}

double trilinear(const std::array<double, 8>& corners, const Point& p) {
  double sum = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    double weight = 1;
    for (std::size_t a = 0; a < 3; ++a) weight *= (c >> a & 1) != 0 ? p[a] : 1 - p[a];
    sum += weight * corners[c];
  }
  return sum;
}

struct Found {
  double largest = 0;
  int point_count = 0;
};

/// On the face's part in the leaf cell from 0 to 1, at points strewn densely.
Found search(const Case& looked_at, int order) {
  const BrickFace face = looked_at.face();
  Found found;
  for (int a = 0; a <= order; ++a)
    for (int b = 0; a + b <= order; ++b) {
      const std::array<int, 3> counts{a, b, order - a - b};
      Point p{};
      double linear = 0;
      for (std::size_t v = 0; v < 3; ++v) {
        const double weight = static_cast<double>(counts[v]) / order;
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += weight * face.corners[v][axis];
        linear += weight * looked_at.field.values[face.vertices[v]];
      }
      if (!std::all_of(p.begin(), p.end(), [](double x) { return x >= 0 && x <= 1; })) continue;
      ++found.point_count;
      found.largest = std::max(found.largest, std::abs(trilinear(looked_at.corners, p) - linear));
    }
  return found;
}

TEST(CellPlane, bounds_a_single_face_as_brute_force_finds_it_and_at_most_four_times_as_high_on_the_mean) {
  std::mt19937_64 random(1);
  int compared = 0;
  double sum_of_ratios = 0;
  for (int i = 0; i < 3000; ++i) {
    const Case made = random_case(random);
    const Found found = search(made, 60);
    const double bound = CellPlane(made.corners).bound_on(made.face(), made.field, {0, 0, 0});
    ASSERT_LE(found.largest, bound) << i;
    if (found.point_count > 0) {
      EXPECT_TRUE(made.face().may_touch({0.5, 0.5, 0.5})) << i;
    }
    if (found.point_count < 100) continue;
    ++compared;
    sum_of_ratios += bound / found.largest;
  }
  EXPECT_GT(compared, 500);
  EXPECT_LE(sum_of_ratios / compared, 4);
}

TEST(CellPlane, is_at_rounding_where_both_fields_are_one_linear_function) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) {
    Case made = random_case(random);
    const auto plane = [](const Point& p) { return 3 * p[0] - 2 * p[1] + 0.5 * p[2] + 7; };
    std::array<double, 4> values;
    for (std::size_t v = 0; v < 4; ++v) values[v] = plane(made.points[v]);
    for (std::size_t c = 0; c < 8; ++c)
      made.corners[c] =
          plane({static_cast<double>(c & 1), static_cast<double>(c >> 1 & 1), static_cast<double>(c >> 2)});
    made.field.values.assign(values.begin(), values.end());
    made.field.gradients = {gradient_of(made.points, values)};
    EXPECT_LE(CellPlane(made.corners).bound_on(made.face(), made.field, {0, 0, 0}), 1e-9);
  }
}

TEST(CellPlane, bounds_nothing_where_the_cell_has_no_gradient) {
  std::mt19937_64 random(3);
  Case made = random_case(random);
  made.field.gradients = {gradient_of(made.points, {0, 1, 2, std::nan("")})};
  EXPECT_FALSE(CellPlane(made.corners).bound_on(made.face(), made.field, {0, 0, 0}) < 1e300);
}

}  // namespace
}  // namespace rhoray::preprocess

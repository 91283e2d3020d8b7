#include "preprocess/mesh/inspect/orientation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

namespace rhoray::preprocess {
namespace {

using Point = std::array<double, 3>;
using Whole = std::array<std::int64_t, 3>;

__extension__ using Wide = __int128;

/// The same sign in integers: coordinates below 2^40 keep the determinant below 2^127.
int integer_orientation(const std::array<Whole, 4>& p) {
  Wide d[3][3];
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) d[v][axis] = p[v + 1][axis] - p[0][axis];
  const Wide determinant = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) +
                           d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
                           d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
  return (determinant > 0) - (determinant < 0);
}

int plain_orientation(const std::array<Point, 4>& p) {
  double d[3][3];
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) d[v][axis] = p[v + 1][axis] - p[0][axis];
  const double determinant = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) +
                             d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
                             d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
  return (determinant > 0) - (determinant < 0);
}

std::array<Point, 4> scaled(const std::array<Whole, 4>& p, double factor) {
  std::array<Point, 4> points;
  for (std::size_t v = 0; v < 4; ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) points[v][axis] = static_cast<double>(p[v][axis]) * factor;
  return points;
}

int orientation_of(const std::array<Point, 4>& p) {
  return orientation(p[0], p[1], p[2], p[3]);
}

TEST(Orientation, is_positive_where_the_first_face_runs_counter_clockwise_seen_from_the_last_vertex) {
  EXPECT_EQ(orientation({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
  EXPECT_EQ(orientation({0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}), -1);
  EXPECT_EQ(orientation({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 7, 0}), 0);
  EXPECT_EQ(orientation({1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}), 0);
}

TEST(Orientation, agrees_with_integers_on_points_at_most_one_step_out_of_a_plane) {
  std::mt19937_64 random(7);
  std::uniform_int_distribution<std::int64_t> place(-(std::int64_t{1} << 36), std::int64_t{1} << 36), times(-3, 3),
      step(-1, 1);
  int wrong = 0, wrong_plainly = 0, flat = 0;
  constexpr int trials = 20000;
  for (int trial = 0; trial < trials; ++trial) {
    std::array<Whole, 4> p;
    const std::int64_t a = times(random), b = times(random);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t v = 0; v < 3; ++v) p[v][axis] = place(random);
      p[3][axis] = p[0][axis] + a * (p[1][axis] - p[0][axis]) + b * (p[2][axis] - p[0][axis]) + step(random);
    }
    const int truth = integer_orientation(p);
    flat += truth == 0;
    for (const double factor : {1.0, 0x1p-60, 0x1p100}) wrong += orientation_of(scaled(p, factor)) != truth;
    wrong_plainly += plain_orientation(scaled(p, 1)) != truth;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(flat, trials / 100) << "are there still flat cells among the trials?";
  EXPECT_GT(wrong_plainly, trials / 100) << "plain doubles no longer fail here: is this case still the hard one?";
}

TEST(Orientation, changes_its_sign_with_each_exchange_of_two_points) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 2000; ++trial) {
    std::array<Point, 4> p;
    for (Point& point : p) point = {unit(random), unit(random), unit(random)};
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[3][axis] = (p[0][axis] + p[1][axis] + p[2][axis]) / 3;  // flat but for rounding
    const int sign = orientation_of(p);
    EXPECT_EQ(orientation(p[1], p[0], p[2], p[3]), -sign);
    EXPECT_EQ(orientation(p[0], p[1], p[3], p[2]), -sign);
    EXPECT_EQ(orientation(p[2], p[1], p[0], p[3]), -sign);
    EXPECT_EQ(orientation(p[1], p[2], p[0], p[3]), sign);
  }
}

}  // namespace
}  // namespace rhoray::preprocess

#include "render/cell/cubic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::Cubic;
using render::CubicMaximum;
using render::is_inside;

/// The numbers of the reference: 113 bits, so that its own rounding is 1e18 times smaller than the
/// errors under test.
using Quad = __float128;
using QuadCubic = std::array<Quad, 4>;

constexpr double u = 0x1p-53;

Quad magnitude(Quad x) {
  return x < 0 ? -x : x;
}

QuadCubic to_quad(const Cubic& c) {
  return {c.b[0], c.b[1], c.b[2], c.b[3]};
}

Quad value_at(const QuadCubic& b, Quad s) {
  const Quad r = 1 - s;
  return r * r * r * b[0] + 3 * r * r * s * b[1] + 3 * r * s * s * b[2] + s * s * s * b[3];
}

/// Returns the Bernstein coefficients on [from, to].
QuadCubic part_of(QuadCubic b, Quad from, Quad to) {
  const auto left_of = [](QuadCubic c, Quad s) {
    QuadCubic left;
    for (std::size_t n = 0; n < 4; ++n) {
      left[n] = c[0];
      for (std::size_t i = 0; i + n + 1 < 4; ++i) c[i] = (1 - s) * c[i] + s * c[i + 1];
    }
    return left;
  };
  b = left_of(b, to);
  std::reverse(b.begin(), b.end());
  b = left_of(b, to == 0 ? Quad(1) : 1 - from / to);
  std::reverse(b.begin(), b.end());
  return b;
}

/// True when the cubic falls below -band somewhere on [0, 1]; by subdivision of its convex hull.
bool falls_below(const QuadCubic& b, Quad band, int depth = 60) {
  if (b[0] < -band || b[3] < -band) return true;
  if (b[1] >= -band && b[2] >= -band) return false;
  return depth > 0 &&
         (falls_below(part_of(b, 0, 0.5), band, depth - 1) || falls_below(part_of(b, 0.5, 1), band, depth - 1));
}

QuadCubic negated(const QuadCubic& b) {
  return {-b[0], -b[1], -b[2], -b[3]};
}

double largest_coefficient(const Cubic& c) {
  return std::max({std::abs(c.b[0]), std::abs(c.b[1]), std::abs(c.b[2]), std::abs(c.b[3])});
}

/// k (s - r0)(s - r1)(s - r2), rounded to doubles last.
Cubic from_roots(Quad k, Quad r0, Quad r1, Quad r2) {
  const Quad e1 = r0 + r1 + r2, e2 = r0 * r1 + r1 * r2 + r2 * r0, e3 = r0 * r1 * r2;
  const std::array<Quad, 4> p{-e3, e2, -e1, 1};  // powers of s
  return {{static_cast<double>(k * p[0]), static_cast<double>(k * (p[0] + p[1] / 3)),
           static_cast<double>(k * (p[0] + 2 * p[1] / 3 + p[2] / 3)),
           static_cast<double>(k * (p[0] + p[1] + p[2] + p[3]))}};
}

/// Random cubics, and those that naive solvers get wrong, by the name of their difficulty.
std::vector<std::pair<std::string, std::function<Cubic(Dice&)>>> families() {
  const auto any = [](Dice& d) { return d.between(-1, 1); };
  const auto root = [](Dice& d) { return d.between(-0.2, 1.2); };
  return {
      {"any values",
       [=](Dice& d) {
         return Cubic{{any(d), any(d), any(d), any(d)}};
       }},
      {"three roots", [=](Dice& d) { return from_roots(any(d), root(d), root(d), root(d)); }},
      {"two near roots (R08)",
       [=](Dice& d) {
         const double r = root(d);
         return from_roots(any(d), r, r + std::pow(10, d.between(-16, -1)), root(d));
       }},
      {"double root (R06)",
       [=](Dice& d) {
         const double r = root(d);
         return from_roots(any(d), r, r, d.between(-4, 4));
       }},
      {"tangent just outside (R07)",
       [=](Dice& d) {
         const double r = root(d);
         Cubic c = from_roots(1, r, r, d.coin() ? -d.between(0.3, 3) : 1 + d.between(0.3, 3));
         const double gap = std::pow(10, d.between(-16, -5));
         for (double& b : c.b) b += gap;
         return c;
       }},
      {"triple root (R09)",
       [=](Dice& d) {
         const double r = root(d);
         return from_roots(any(d), r, r, r);
       }},
      {"leading coefficient zero (R02)",
       [=](Dice& d) {
         const double q0 = any(d), q1 = any(d), q2 = any(d);
         return Cubic{{q0, (q0 + 2 * q1) / 3, (2 * q1 + q2) / 3, q2}};
       }},
      {"leading coefficient nearly zero (R01)",
       [=](Dice& d) {
         const double q0 = any(d), q1 = any(d), q2 = any(d), tiny = std::pow(10, d.between(-18, -8));
         return Cubic{{q0, (q0 + 2 * q1) / 3, (2 * q1 + q2) / 3, q2 + tiny}};
       }},
      {"linear (R03)",
       [=](Dice& d) {
         const double a = any(d), b = any(d);
         return Cubic{{a, (2 * a + b) / 3, (a + 2 * b) / 3, b}};
       }},
      {"constant (R04, R05)",
       [=](Dice& d) {
         const double a = d.coin() ? any(d) : 0;
         return Cubic{{a, a, a, a}};
       }},
      {"whole numbers, many of them the isovalue (R19)",
       [=](Dice& d) {
         const auto whole = [&] { return static_cast<double>(d.below(5) - 2); };
         return Cubic{{whole(), whole(), whole(), whole()}};
       }},
      {"values one unit of rounding apart (D14)",
       [=](Dice& d) {
         const auto nearly = [&] { return static_cast<double>(d.below(5) - 2) * 0x1p-53; };
         return Cubic{{nearly(), nearly(), nearly(), nearly()}};
       }},
      {"magnitudes from 1e-300 to 1e300 (D04, D05)",
       [=](Dice& d) {
         const double scale = std::pow(10, d.between(-299, 299));
         return Cubic{{scale * any(d), scale * any(d), scale * any(d), scale * any(d)}};
       }},
      {"mixed magnitudes in one cell (D06)",
       [=](Dice& d) {
         const auto mixed = [&] { return any(d) * std::pow(10, d.between(-30, 30)); };
         return Cubic{{mixed(), mixed(), mixed(), mixed()}};
       }},
  };
}
constexpr int per_family = 8000;

TEST(Cubic, starts_and_ends_at_its_outer_coefficients_exactly) {
  Dice dice(1);
  for (const auto& [name, make] : families())
    for (int trial = 0; trial < 500; ++trial) {
      const Cubic c = make(dice);
      EXPECT_EQ(c.at(0).value, c.b[0]) << name;
      EXPECT_EQ(c.at(1).value, c.b[3]) << name;
    }
}

TEST(Cubic, values_and_slopes_are_exact_to_a_few_units_of_rounding) {
  Dice dice(2);
  for (const auto& [name, make] : families())
    for (int trial = 0; trial < 2000; ++trial) {
      const Cubic c = make(dice);
      const double s = dice.between(0, 1);
      const QuadCubic b = to_quad(c);
      const Quad slope = 3 * ((1 - Quad(s)) * (1 - Quad(s)) * (b[1] - b[0]) + 2 * s * (1 - Quad(s)) * (b[2] - b[1]) +
                              Quad(s) * s * (b[3] - b[2]));
      const double m = largest_coefficient(c);
      EXPECT_LE(static_cast<double>(magnitude(value_at(b, s) - c.at(s).value)), 8 * u * m + 1e-320) << name;
      EXPECT_LE(static_cast<double>(magnitude(slope - c.at(s).slope)), 32 * u * m + 1e-320) << name;
    }
}

TEST(Cubic, critical_points_are_where_the_slope_is_zero_and_none_is_missing) {
  Dice dice(3);
  int one = 0, two = 0, unclear = 0;
  for (const auto& [name, make] : families())
    for (int trial = 0; trial < per_family; ++trial) {
      const Cubic c = make(dice);
      const QuadCubic b = to_quad(c);
      const Quad d0 = b[1] - b[0], d1 = b[2] - b[1], d2 = b[3] - b[2];
      const Quad m = std::max({magnitude(d0), magnitude(d1), magnitude(d2)});
      const auto slope = [&](Quad s) { return (1 - s) * (1 - s) * d0 + 2 * s * (1 - s) * d1 + s * s * d2; };
      const Cubic::CriticalPoints found = c.critical_points();
      for (int i = 0; i < found.count; ++i) {
        const double s = found.s[static_cast<std::size_t>(i)];
        ASSERT_TRUE(s > 0 && s < 1) << name;
        if (i > 0) {
          EXPECT_GE(s, found.s[0]) << name;
        }
        // Differences of coefficients round relative to the coefficients.
        EXPECT_LE(static_cast<double>(magnitude(slope(s))),
                  static_cast<double>(16 * u * m) + 4 * u * largest_coefficient(c))
            << name;
      }
      if (m == 0) continue;
      // Their number is certain where the slope's ends and its extremum are away from zero.
      const Quad band = 64 * u * Quad(largest_coefficient(c));
      const Quad a = d0 - 2 * d1 + d2;
      const Quad s_extremum = a == 0 ? Quad(-1) : (d0 - d1) / a;
      const bool has_extremum = s_extremum > 0 && s_extremum < 1;
      if (magnitude(d0) < band || magnitude(d2) < band || (has_extremum && magnitude(slope(s_extremum)) < band)) {
        ++unclear;
        continue;
      }
      int expected = (d0 < 0) != (d2 < 0) ? 1 : 0;
      if (expected == 0 && has_extremum && (slope(s_extremum) < 0) != (d0 < 0)) expected = 2;
      EXPECT_EQ(found.count, expected) << name << ": " << c.b[0] << " " << c.b[1] << " " << c.b[2] << " " << c.b[3];
      one += expected == 1;
      two += expected == 2;
    }
  EXPECT_GT(one, 10000);
  EXPECT_GT(two, 8000);
  EXPECT_LT(unclear, 4 * per_family);
}

TEST(FirstChangeOfSide, is_found_whenever_the_sides_at_the_ends_differ) {
  Dice dice(4);
  int found = 0;
  for (const auto& [name, make] : families())
    for (int trial = 0; trial < per_family; ++trial) {
      const Cubic c = make(dice);
      for (const bool starts_inside : {false, true}) {
        if (is_inside(c.b[3]) == starts_inside) continue;
        ASSERT_TRUE(first_change_of_side(c, starts_inside)) << name;
        ++found;
      }
    }
  EXPECT_GT(found, 80000);
}

TEST(FirstChangeOfSide, is_zero_when_the_cubic_starts_on_the_other_side) {
  EXPECT_EQ(first_change_of_side(Cubic{{1, 2, 3, 4}}, false), 0.0);
  EXPECT_EQ(first_change_of_side(Cubic{{0, -1, -1, -1}}, false), 0.0);
  EXPECT_EQ(first_change_of_side(Cubic{{-1, 2, 3, 4}}, true), 0.0);
}

TEST(FirstChangeOfSide, counts_zero_as_inside) {
  EXPECT_NEAR(first_change_of_side(Cubic{{-3, -2, -1, 0}}, false).value(), 1, 1e-15);
  EXPECT_EQ(first_change_of_side(Cubic{{0, 0, 0, 0}}, true), std::nullopt);
  EXPECT_EQ(first_change_of_side(Cubic{{1, 1, 1, 0}}, true), std::nullopt);
  EXPECT_EQ(first_change_of_side(Cubic{{-0.0, 0, -0.0, 0}}, true), std::nullopt);
}

// The whole promise of cubic.h, within 16 units of rounding of the largest coefficient. The exact
// cubic is zero where a change is reported, and keeps its side before. Where none is reported, it
// keeps its side throughout.
TEST(FirstChangeOfSide, is_the_first_one_of_the_exact_cubic_up_to_rounding_of_its_values) {
  Dice dice(5);
  std::map<std::string, int> changes;
  for (const auto& [name, make] : families())
    for (int trial = 0; trial < per_family; ++trial) {
      const Cubic c = make(dice);
      const bool starts_inside = is_inside(c.b[0]);
      const QuadCubic b = starts_inside ? to_quad(c) : negated(to_quad(c));
      const Quad band = 16 * u * Quad(largest_coefficient(c));
      const std::optional<double> s = first_change_of_side(c, starts_inside);
      if (!s) {
        ASSERT_FALSE(falls_below(b, band)) << name;
        continue;
      }
      ASSERT_TRUE(*s >= 0 && *s <= 1) << name;
      ASSERT_LE(magnitude(value_at(b, *s)), band) << name << " at " << *s;
      ASSERT_FALSE(falls_below(part_of(b, 0, *s), band)) << name << " before " << *s;
      ++changes[name];
    }
  for (const auto& [name, make] : families()) {
    if (name.find("constant") == std::string::npos) {
      EXPECT_GT(changes[name], per_family / 10) << name;
    }
  }
}

TEST(FirstChangeOfSide, keeps_the_same_promise_in_float) {
  Dice dice(9);
  int changes = 0, most_iterations = 0;
  for (const auto& [name, make] : families()) {
    // Out of the range of float.
    if (name.find("1e300") != name.npos || name.find("mixed") != name.npos) continue;
    for (int trial = 0; trial < per_family; ++trial) {
      const Cubic c = make(dice);
      render::CubicOf<float> rounded;
      QuadCubic b;
      for (std::size_t i = 0; i < 4; ++i) rounded.b[i] = static_cast<float>(c.b[i]), b[i] = rounded.b[i];
      const bool starts_inside = is_inside(rounded.b[0]);
      if (!starts_inside) b = negated(b);
      const Quad band = 16 * Quad(0x1p-24) * Quad(largest_coefficient(c));
      const auto found = changes_of_side(rounded, starts_inside);
      most_iterations = std::max(most_iterations, found.iterations);
      if (found.count == 0) {
        ASSERT_FALSE(falls_below(b, band)) << name;
        continue;
      }
      ASSERT_TRUE(found.first >= 0 && found.first <= 1) << name;
      ASSERT_LE(magnitude(value_at(b, found.first)), band) << name << " at " << found.first;
      ASSERT_FALSE(falls_below(part_of(b, 0, found.first), band)) << name << " before " << found.first;
      ++changes;
    }
  }
  EXPECT_GT(changes, 30000);
  EXPECT_LE(most_iterations, 30);
}

TEST(FirstChangeOfSide, has_a_small_error_where_the_root_is_simple) {
  Dice dice(6);
  int simple = 0;
  for (const auto& [name, make] : families())
    for (int trial = 0; trial < per_family; ++trial) {
      const Cubic c = make(dice);
      const bool starts_inside = is_inside(c.b[0]);
      const std::optional<double> s = first_change_of_side(c, starts_inside);
      if (!s || *s == 0) continue;
      const double m = largest_coefficient(c), slope = std::abs(c.at(*s).slope);
      if (!(slope > 1e-3 * m)) continue;
      // Between s - error and s + error the exact cubic changes side.
      const double error = 4 * u + 16 * u * m / slope;
      const Quad before = value_at(to_quad(c), std::max(Quad(0), Quad(*s) - error));
      const Quad after = value_at(to_quad(c), std::min(Quad(1), Quad(*s) + error));
      ASSERT_NE(before < 0, after < 0) << name << " at " << *s;
      ++simple;
    }
  EXPECT_GT(simple, 30000);
}

TEST(FirstChangeOfSide, takes_the_first_of_three_roots) {
  const Cubic c = from_roots(1, 0.25, 0.5, 0.75);
  EXPECT_NEAR(first_change_of_side(c, false).value(), 0.25, 1e-15);
  EXPECT_NEAR(first_change_of_side(from_roots(-1, 0.25, 0.5, 0.75), true).value(), 0.25, 1e-15);
}

// Squares of these values leave the range of doubles; the two roots in the middle were then lost.
TEST(FirstChangeOfSide, finds_two_roots_between_ends_on_one_side_at_any_magnitude) {
  for (const double scale : {1.0, 1e-200, 1e-290, 1e200, 1e300}) {
    const std::optional<double> s =
        first_change_of_side(Cubic{{0.3 * scale, -0.4 * scale, -0.4 * scale, 0.3 * scale}}, true);
    ASSERT_TRUE(s) << scale;
    EXPECT_NEAR(*s, first_change_of_side(Cubic{{0.3, -0.4, -0.4, 0.3}}, true).value(), 1e-14) << scale;
  }
}

TEST(FirstChangeOfSide, does_not_depend_on_a_power_of_two_in_the_values) {
  Dice dice(7);
  const auto make = families()[0].second;
  for (int trial = 0; trial < 5000; ++trial) {
    const Cubic c = make(dice);
    Cubic scaled = c;
    const int power = static_cast<int>(dice.below(400)) - 200;
    for (double& b : scaled.b) b = std::ldexp(b, power);
    EXPECT_EQ(first_change_of_side(c, is_inside(c.b[0])), first_change_of_side(scaled, is_inside(c.b[0])));
  }
}

TEST(LargestValue, is_that_of_the_exact_cubic_up_to_rounding_and_is_reached_at_s) {
  Dice dice(8);
  int in_the_middle = 0;
  for (const auto& [name, make] : families())
    for (int trial = 0; trial < per_family / 2; ++trial) {
      const Cubic c = make(dice);
      const CubicMaximum best = largest_value(c);
      const double band = 16 * u * largest_coefficient(c);
      EXPECT_EQ(c.at(best.s).value, best.value) << name;
      for (int i = 0; i <= 64; ++i) EXPECT_LE(c.at(i / 64.0).value, best.value + band) << name;
      // No point of the exact cubic is above: best - cubic does not fall below -band.
      QuadCubic below;
      for (std::size_t i = 0; i < 4; ++i) below[i] = Quad(best.value) - c.b[i];
      ASSERT_FALSE(falls_below(below, band)) << name;
      in_the_middle += best.s > 0 && best.s < 1;
    }
  EXPECT_GT(in_the_middle, 10000);
}

TEST(LargestValue, takes_the_smallest_s_among_equals) {
  EXPECT_EQ(largest_value(Cubic{{3, 3, 3, 3}}).s, 0);
  EXPECT_EQ(largest_value(Cubic{{1, 0, 0, 1}}).s, 0);
  EXPECT_EQ(largest_value(Cubic{{0.1, 0.1, 0.1, 0.1}}).value, 0.1);
  EXPECT_EQ(largest_value(Cubic{{-3, -2, -1, -0.5}}).s, 1);
}

}  // namespace
}  // namespace rhoray::tests

#include "render/cell/certified_crossing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "tests/render/support/exact_chord.h"
#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::certain_side;
using render::CertifiedCrossing;
using render::CertifiedMaximum;
using render::certify_crossing;
using render::certify_largest_value;
using render::Decision;
using render::TrilinearCell;

struct Chord {
  TrilinearCell cell;
  Vec3 in, out;
  double isovalue;
};

/// The exact truth for the claims of a certified result: quadruple precision where it is
/// sufficient, rational numbers elsewhere.
struct Judge {
  const Chord& chord;
  bool starts_inside;

  std::optional<bool> keeps_side_until(double s) const {
    const auto quick = of<Quad>().keeps_side_until(s);
    return quick ? quick : of<Rational>().keeps_side_until(s);
  }

  bool confirms(const CertifiedCrossing& found) const {
    if (found.decision == Decision::unknown) return true;
    if (found.decision == Decision::none) return keeps_side_until(1) == true;
    if (!(found.s >= 0 && found.s <= 1 && found.s_error >= 0)) return false;
    const double before = found.s - found.s_error;
    return (before <= 0 || keeps_side_until(before) == true) && keeps_side_until(found.s + found.s_error) == false;
  }

  template <class Number>
  ExactChord<Number> of() const {
    return {chord.cell, chord.in, chord.out, chord.isovalue, starts_inside};
  }
};

bool exactly_starts_inside(const Chord& chord) {
  const auto quick = Judge{chord, true}.of<Quad>().starts_on_its_side();
  return quick ? *quick : Judge{chord, true}.of<Rational>().starts_on_its_side().value();
}

/// Returns points on two planes of a cell.
std::pair<Vec3, Vec3> any_way(Dice& dice) {
  Vec3 in = dice.point({0, 0, 0}, {1, 1, 1}), out = dice.point({0, 0, 0}, {1, 1, 1});
  in[static_cast<int>(dice.below(3))] = dice.coin() ? 0 : 1;
  out[static_cast<int>(dice.below(3))] = dice.coin() ? 0 : 1;
  return {in, out};
}

Chord any_chord(Dice& dice, double offset = 0, double scale = 1) {
  Chord chord;
  for (double& f : chord.cell.corner) f = offset + scale * dice.between(-1, 1);
  std::tie(chord.in, chord.out) = any_way(dice);
  chord.isovalue = offset + scale * dice.between(-0.6, 0.6);
  return chord;
}

/// With the isovalue at an extremum of the field along the chord, times 1 + gap.
Chord nearly_tangent_chord(Dice& dice, double gap) {
  for (;;) {
    Chord chord = any_chord(dice);
    const render::Cubic cubic = chord.cell.along(chord.in, chord.out, 0);
    const auto critical = cubic.critical_points();
    if (critical.count == 0) continue;
    chord.isovalue = cubic.at(critical.s[0]).value * (1 + gap);
    return chord;
  }
}

struct Family {
  std::string name;
  std::function<Chord(Dice&)> make;
  double unknown_float, unknown_double;  ///< maximum share of unknown decisions
  bool is_undecidable = false;           ///< for floating point of any width
};

std::vector<Family> hard_families() {
  const auto whole = [](Dice& d) { return static_cast<double>(d.below(4)); };
  return {
      {"tangent up to rounding of double", [](Dice& d) { return nearly_tangent_chord(d, 0); }, 1, 1, true},
      {"tangent up to rounding of float", [](Dice& d) { return nearly_tangent_chord(d, d.between(-3e-7, 3e-7)); }, 1,
       0},
      {"nearly tangent", [](Dice& d) { return nearly_tangent_chord(d, std::pow(10, d.between(-17, -2))); }, 0.9, 0.25},
      {"exactly tangent (R06)",
       [](Dice& d) {  // (x - 1/2) (y - 1/2) along x = y, or with the opposite sign
         Chord c;
         const double sign = d.coin() ? 1 : -1;
         for (std::size_t k = 0; k < 8; ++k) c.cell.corner[k] = sign * ((k & 1) == ((k >> 1) & 1) ? 0.25 : -0.25);
         c.in = {0, 0, d.between(0, 1)}, c.out = {1, 1, d.between(0, 1)}, c.isovalue = 0;
         return c;
       },
       1, 1, true},
      {"whole numbers, many of them the isovalue (R19, R20)",
       [=](Dice& d) {
         Chord c;
         for (double& f : c.cell.corner) f = whole(d);
         std::tie(c.in, c.out) = any_way(d);
         c.isovalue = whole(d);
         return c;
       },
       0.02, 0.02},
      {"along edges and diagonals (R15, R16, R17)",
       [=](Dice& d) {
         Chord c;
         for (double& f : c.cell.corner) f = whole(d) + (d.coin() ? d.between(0, 1) : 0);
         const auto end = [&] { return static_cast<double>(d.below(3)) / 2; };
         c.in = {end(), end(), end()}, c.out = {end(), end(), end()};
         c.isovalue = whole(d);
         return c;
       },
       0.07, 0.07},
      {"the isovalue on the face of entry (R12)",
       [](Dice& d) {
         Chord c = any_chord(d);
         for (const std::size_t k : {0U, 2U, 4U, 6U}) c.cell.corner[k] = c.isovalue;
         c.in.x = 0, c.out.x = 1;
         return c;
       },
       0.01, 0},
      {"the isovalue on the face of exit (R13)",
       [](Dice& d) {
         Chord c = any_chord(d);
         for (const std::size_t k : {1U, 3U, 5U, 7U}) c.cell.corner[k] = c.isovalue;
         c.in.x = 0, c.out.x = 1;
         return c;
       },
       0.8, 0.8},
      {"a constant cell (R04, R05)",
       [](Dice& d) {
         Chord c = any_chord(d);
         c.cell.corner.fill(d.coin() ? c.isovalue : std::nextafter(c.isovalue, d.coin() ? 9 : -9));
         return c;
       },
       0, 0},
      {"short chords (R25)",
       [](Dice& d) {
         Chord c = any_chord(d);
         c.out = c.in + std::pow(10, d.between(-17, -3)) * (c.out - c.in);
         c.isovalue = c.cell.along(c.in, c.out, 0).at(d.between(0, 1)).value;
         return c;
       },
       0.95, 0.3},
      {"values of a million and differences of one (R27)", [](Dice& d) { return any_chord(d, 1e6, 1); }, 0.001, 0},
      {"whole numbers of 32 bits (D03)",
       [](Dice& d) {
         Chord c = any_chord(d);
         c.isovalue = static_cast<double>(d.below(4294967295));
         for (double& f : c.cell.corner) f = c.isovalue + static_cast<double>(d.below(5) - 2);
         return c;
       },
       0.01, 0.01},
      {"mixed magnitudes (D06)",
       [](Dice& d) {
         Chord c = any_chord(d);
         for (double& f : c.cell.corner) f *= std::pow(10, d.between(-30, 30));
         c.isovalue = 0;
         return c;
       },
       0.35, 0.2},
      {"any magnitude (D04, D05)", [](Dice& d) { return any_chord(d, 0, std::pow(10, d.between(-305, 305))); }, 0.001,
       0},
      {"denormal values (D05)", [](Dice& d) { return any_chord(d, 0, std::pow(10, d.between(-322, -308))); }, 0.001, 0},
      {"values one unit of rounding apart (D14)",
       [](Dice& d) {
         Chord c = any_chord(d);
         c.isovalue = 1 + static_cast<double>(d.below(3) - 1) * 0x1p-52;
         for (double& f : c.cell.corner) f = 1 + static_cast<double>(d.below(5) - 2) * 0x1p-52;
         return c;
       },
       0.01, 0.01},
  };
}

struct Tally {
  int none = 0, crosses = 0, unknown = 0;
  double largest_error = 0;
  void count(const CertifiedCrossing& found) {
    none += found.decision == Decision::none, crosses += found.decision == Decision::crosses;
    unknown += found.decision == Decision::unknown;
    if (found.decision == Decision::crosses) largest_error = std::max(largest_error, found.s_error);
  }
};

template <class Real>
class CertifiedCrossings : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(CertifiedCrossings, Reals);

TYPED_TEST(CertifiedCrossings, are_never_wrong_and_rarely_unknown_in_ordinary_cells) {
  constexpr bool is_float = std::is_same_v<TypeParam, float>;
  Dice dice(1);
  for (const double offset : {0.0, 1e6}) {
    Tally tally;
    constexpr int trials = 50000;
    for (int trial = 0; trial < trials; ++trial) {
      const Chord chord = any_chord(dice, offset);
      const bool starts_inside = exactly_starts_inside(chord);
      const auto found = certify_crossing<TypeParam>(chord.cell, chord.in, chord.out, 0, chord.isovalue, starts_inside);
      ASSERT_TRUE((Judge{chord, starts_inside}.confirms(found))) << offset << " trial " << trial;
      tally.count(found);
    }
    EXPECT_GT(tally.crosses, trials / 5);
    EXPECT_GT(tally.none, trials / 5);
    EXPECT_LE(tally.unknown, is_float ? trials / 10000 : 0);
    EXPECT_LT(tally.largest_error, is_float ? 2e-3 : 4e-12);
  }
}

TYPED_TEST(CertifiedCrossings, are_never_wrong_in_hard_cells_and_decide_what_can_be_decided) {
  constexpr bool is_float = std::is_same_v<TypeParam, float>;
  constexpr int trials = 3000;
  for (const Family& family : hard_families()) {
    Dice dice(2);
    Tally tally;
    for (int trial = 0; trial < trials; ++trial) {
      const Chord chord = family.make(dice);
      const bool starts_inside = exactly_starts_inside(chord);
      const auto found = certify_crossing<TypeParam>(chord.cell, chord.in, chord.out, 0, chord.isovalue, starts_inside);
      ASSERT_TRUE((Judge{chord, starts_inside}.confirms(found))) << family.name << " trial " << trial;
      tally.count(found);
    }
    const double unknown = static_cast<double>(tally.unknown) / trials;
    EXPECT_LE(unknown, is_float ? family.unknown_float : family.unknown_double) << family.name;
    if (family.is_undecidable) {
      EXPECT_EQ(unknown, 1) << family.name << ": is it still the hard case?";
    }
  }
}

TYPED_TEST(CertifiedCrossings, hold_for_every_segment_within_the_point_error) {
  Dice dice(3);
  for (const double point_error : {1e-3, 1e-5, 1e-7, 1e-10, 1e-14}) {
    Tally tally;
    int would_be_wrong = 0;
    for (int trial = 0; trial < 4000; ++trial) {
      const Chord given =
          trial % 2 == 0 ? any_chord(dice) : nearly_tangent_chord(dice, 20 * dice.between(-1, 1) * point_error);
      Chord exact = given;
      const auto off = [&] {
        return dice.below(3) == 0 ? (dice.coin() ? point_error : -point_error) : point_error * dice.between(-1, 1);
      };
      for (int axis = 0; axis < 3; ++axis) {
        exact.in[axis] = given.in[axis] + 0.999 * off();
        exact.out[axis] = given.out[axis] + 0.999 * off();
      }
      const bool starts_inside = exactly_starts_inside(exact);
      const auto certify = [&](double error) {
        return certify_crossing<TypeParam>(given.cell, given.in, given.out, error, given.isovalue, starts_inside);
      };
      const CertifiedCrossing found = certify(point_error);
      ASSERT_TRUE((Judge{exact, starts_inside}.confirms(found))) << point_error << " trial " << trial;
      tally.count(found);
      would_be_wrong += !Judge{exact, starts_inside}.confirms(certify(0));
    }
    EXPECT_GT(tally.none + tally.crosses, 1800) << point_error;
    if (std::is_same_v<TypeParam, double> || point_error > 1e-6) {
      EXPECT_GT(would_be_wrong, 100) << "answers for the given points alone hold too: is this still the hard case?";
    }
  }
}

TYPED_TEST(CertifiedCrossings, take_a_piece_as_clear_or_as_rising_only_where_it_is_so_throughout) {
  using Way = render::StartSideUp<TypeParam>;
  const TypeParam margin = TypeParam(0.125);
  EXPECT_TRUE((Way{{{1, 1, 2, 1}}, margin}.is_clear(0, 1)));
  EXPECT_FALSE((Way{{{1, -3, -3, 1}}, margin}.is_clear(0, 1))) << "below zero between its ends";
  EXPECT_FALSE((Way{{{1, -3, 1, 1}}, margin}.is_clear(0, 1))) << "one coefficient alone takes it below zero";
  EXPECT_FALSE((Way{{{1, 1, -3, 1}}, margin}.is_clear(0, 1))) << "one coefficient alone takes it below zero";
  EXPECT_TRUE((Way{{{1, -3, -3, 1}}, margin}.is_clear(0, TypeParam(0.03125))));
  EXPECT_FALSE((Way{{{TypeParam(0.0625), 1, 1, 1}}, margin}.is_clear(0, 1))) << "starts within the margin";
  EXPECT_TRUE((Way{{{0, 1, 2, 3}}, margin}.rises_until(1)));
  EXPECT_FALSE((Way{{{0, 1, TypeParam(1.5), -3}}, margin}.rises_until(1))) << "falls at its end";
  EXPECT_TRUE((Way{{{0, 1, TypeParam(1.5), -3}}, margin}.rises_until(TypeParam(0.0625))));
  EXPECT_FALSE((Way{{{0, 1, -1, 1}}, margin}.rises_until(1))) << "falls between its ends";
  EXPECT_FALSE((Way{{{0, TypeParam(0.25), 1, 2}}, margin}.rises_until(1))) << "rises no more than the margins allow";
}

TYPED_TEST(CertifiedCrossings, change_at_the_start_when_the_ray_is_known_to_come_from_the_other_side) {
  const TrilinearCell cell{{1, 2, 1, 2, 1, 2, 1, 2}};
  const auto found = certify_crossing<TypeParam>(cell, {0, 0.5, 0.5}, {1, 0.5, 0.5}, 0, 0.5, false);
  EXPECT_EQ(found.decision, Decision::crosses);
  EXPECT_EQ(found.s, 0);
  EXPECT_EQ(found.s_error, 0);
  const TrilinearCell plateau{{0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5}};
  EXPECT_EQ(certify_crossing<TypeParam>(plateau, {0, 0, 0}, {1, 1, 1}, 0, 0.5, false).s, 0);
  EXPECT_EQ(certify_crossing<TypeParam>(plateau, {0, 0, 0}, {1, 1, 1}, 0, 0.5, false).decision, Decision::crosses);
  EXPECT_EQ(certify_crossing<TypeParam>(plateau, {0, 0, 0}, {1, 1, 1}, 0, 0.5, true).decision, Decision::none);
}

TYPED_TEST(CertifiedCrossings, are_narrow_where_the_surface_is_left_along_a_tangent) {
  // The cubic starts at its double root: the slope there does not tell how far the root's bound
  // must extend.
  const Chord chords[] = {{{{34, 38, 36, 38, 38, 38, 35, 35}}, {1, 0, 1}, {0.195077, 0, 0.395308}, 38},
                          {{{207, 207, 208, 207, 207, 208, 207, 205}}, {1, 0, 0}, {1, 1, 1}, 207}};
  for (const Chord& chord : chords) {
    const CertifiedCrossing found =
        certify_crossing<TypeParam>(chord.cell, chord.in, chord.out, 0, chord.isovalue, true);
    ASSERT_EQ(found.decision, Decision::crosses);
    EXPECT_TRUE((Judge{chord, true}.confirms(found)));
    constexpr bool is_float = std::is_same_v<TypeParam, float>;
    EXPECT_LT(found.s_error, is_float ? 1e-2 : 1e-6);  // about the root of the margin
  }
}

TYPED_TEST(CertifiedCrossings, are_unknown_when_points_or_values_say_nothing) {
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const TrilinearCell cell{{0, 1, 0, 1, 0, 1, 0, 1}}, huge{{-1.7e308, 1.7e308, 0, 1, 0, 1, 0, 1}};
  const Vec3 in(0, 0.5, 0.5), out(1, 0.5, 0.5);
  for (const double point_error : {0.01, infinity, nan})
    EXPECT_EQ(certify_crossing<TypeParam>(cell, in, out, point_error, 0.5, false).decision, Decision::unknown);
  EXPECT_EQ(certify_crossing<TypeParam>(cell, in, {nan, 0.5, 0.5}, 0, 0.5, false).decision, Decision::unknown);
  EXPECT_EQ(certify_crossing<TypeParam>(huge, in, out, 0, 1.7e308, false).decision, Decision::unknown);
  EXPECT_EQ(certify_crossing<TypeParam>(cell, in, out, 0, nan, false).decision, Decision::unknown);
  EXPECT_EQ(certain_side<TypeParam>(cell, {nan, 0, 0}, 0, 0.5), std::nullopt);
  EXPECT_FALSE(std::isfinite(certify_largest_value<TypeParam>(cell, in, out, infinity).value_error));
}

TYPED_TEST(CertifiedCrossings, know_the_side_of_a_point_unless_it_lies_on_the_surface) {
  Dice dice(4);
  int inside = 0, unknown = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    Chord chord = any_chord(dice);
    chord.out = chord.in;
    if (trial % 4 == 0) chord.isovalue = chord.cell.at(chord.in);
    const std::optional<bool> side = certain_side<TypeParam>(chord.cell, chord.in, 0, chord.isovalue);
    if (side) {
      ASSERT_EQ(*side, exactly_starts_inside(chord));
      inside += *side;
    } else {
      ++unknown;
    }
  }
  EXPECT_GT(inside, 5000);
  EXPECT_GE(unknown, 5000);
  EXPECT_LT(unknown, 5010);
}

TYPED_TEST(CertifiedCrossings, enclose_the_exact_maximum) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Dice dice(5);
  int in_the_middle = 0;
  double largest_error = 0;
  std::vector<Family> families = hard_families();
  families.push_back({"any values", [](Dice& d) { return any_chord(d); }, 0, 0, false});
  for (const Family& family : families)
    for (int trial = 0; trial < 150; ++trial) {
      const Chord given = family.make(dice);
      const double point_error = trial % 2 == 0 ? 0 : std::pow(10, dice.between(-15, -3));
      const CertifiedMaximum found = certify_largest_value<TypeParam>(given.cell, given.in, given.out, point_error);
      ASSERT_TRUE(std::isfinite(found.value_error)) << family.name;
      Chord chord = given;
      for (int axis = 0; axis < 3; ++axis) {
        chord.in[axis] += 0.99 * point_error * dice.between(-1, 1);
        chord.out[axis] += 0.99 * point_error * dice.between(-1, 1);
      }
      chord.isovalue = std::nextafter(found.value + found.value_error, infinity);
      ASSERT_EQ((Judge{chord, false}.keeps_side_until(1)), true) << family.name << " trial " << trial;
      chord.isovalue = std::nextafter(found.value - found.value_error, -infinity);
      ASSERT_GE((Judge{chord, true}.of<Rational>().value_at(found.s)), 0) << family.name << " trial " << trial;
      in_the_middle += found.s > 0 && found.s < 1;
      const double range = given.cell.largest() - given.cell.smallest();
      if (point_error == 0 && range > 1e-6 && range < 1e6)
        largest_error = std::max(largest_error, (found.value_error - 0x1p-53 * std::abs(found.value)) / range);
    }
  EXPECT_GT(in_the_middle, 400);
  constexpr bool is_float = std::is_same_v<TypeParam, float>;
  EXPECT_LT(largest_error, is_float ? 3e-6 : 6e-15);
}

}  // namespace
}  // namespace rhoray::tests

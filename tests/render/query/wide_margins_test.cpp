#include <gtest/gtest.h>

#include <hwy/highway.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <utility>

#include "formats/brick_layout.h"
#include "render/cell/certified_crossing.h"
#include "render/grid/isosurface/cell_walk-inl.h"
#include "render/grid/isosurface/margins-inl.h"
#include "render/grid/isosurface/parts.h"
#include "render/grid/largest/state-inl.h"
#include "tests/render/support/rays.h"

/// Compares error bounds of certified crossings with the errors in cells that were searched for
/// large ones. No error may exceed its bound. The largest error is more than a tenth of the bound,
/// so a bound that is ten times too small fails. Wide code is compiled for the test's own machine;
/// every machine does the same operations.
namespace rhoray::tests {
namespace {

namespace wide = render::wide::HWY_NAMESPACE;
namespace hn = hwy::HWY_NAMESPACE;

/// Its rounding error is 2^-40 of that of a float, and 2^-11 of that of a double.
using Exact = long double;
using Point = std::array<Exact, 3>;
using Bernstein = std::array<Exact, 4>;

struct Way {
  std::array<float, 8> corner;
  std::array<float, 3> in, out;
};

Exact value_at(const std::array<float, 8>& corner, const Exact x, const Exact y, const Exact z) {
  Exact value = 0;
  for (unsigned k = 0; k < 8; ++k) value += corner[k] * (k & 1 ? x : 1 - x) * (k & 2 ? y : 1 - y) * (k & 4 ? z : 1 - z);
  return value;
}

Bernstein exact_cubic(const std::array<float, 8>& corner, const Point& in, const Point& out) {
  const auto mixed = [&](bool x, bool y, bool z) {
    return value_at(corner, x ? out[0] : in[0], y ? out[1] : in[1], z ? out[2] : in[2]);
  };
  return {mixed(false, false, false),
          (mixed(true, false, false) + mixed(false, true, false) + mixed(false, false, true)) / 3,
          (mixed(true, true, false) + mixed(true, false, true) + mixed(false, true, true)) / 3,
          mixed(true, true, true)};
}

/// The polar form: the value of the cubic at s, s, s, and its Bernstein coefficients on parts of
/// the chord.
Exact polar(Bernstein b, const std::array<Exact, 3>& s) {
  for (std::size_t level = 0; level < 3; ++level)
    for (std::size_t i = 0; i + level < 3; ++i) b[i] += s[level] * (b[i + 1] - b[i]);
  return b[0];
}

Exact largest_difference(const std::array<double, 4>& computed, const Bernstein& exact) {
  Exact largest = 0;
  for (std::size_t i = 0; i < 4; ++i) largest = std::max(largest, std::abs(computed[i] - exact[i]));
  return largest;
}

Bernstein part(const Bernstein& b, Exact from, Exact to) {
  return {polar(b, {from, from, from}), polar(b, {from, from, to}), polar(b, {from, to, to}), polar(b, {to, to, to})};
}

std::array<double, 4> in_lane_0(const wide::CubicLanes& cubic) {
  std::array<double, 4> b;
  for (std::size_t i = 0; i < 4; ++i) b[i] = hn::GetLane(cubic.b[i]);
  return b;
}

wide::VecF in_all_lanes(float x) {
  return hn::Set(wide::floats, x);
}

struct Computed {
  std::array<double, 4> whole, before, after;
  double margin, margin_in_block;
};

Computed computed_by_lanes(const Way& way, float split, float way_error) {
  wide::Corners corners;
  for (std::size_t k = 0; k < 8; ++k) corners.f[k] = in_all_lanes(way.corner[k]);
  wide::VecF in[3], out[3];
  for (std::size_t a = 0; a < 3; ++a) in[a] = in_all_lanes(way.in[a]), out[a] = in_all_lanes(way.out[a]);
  const wide::CubicLanes cubic = along(corners, in, out);
  const wide::Parts parts = parts_at(cubic, in_all_lanes(split));
  const auto [least, largest] = std::minmax_element(way.corner.begin(), way.corner.end());
  const float range = std::max(*largest, 0.0f) - std::min(*least, 0.0f);
  return {in_lane_0(cubic), in_lane_0(parts.before), in_lane_0(parts.after),
          hn::GetLane(wide::margin_of(corners, in_all_lanes(way_error))),
          hn::GetLane(wide::margin_in_block(in_all_lanes(range), in_all_lanes(way_error)))};
}

Point point_of(const std::array<float, 3>& p, Exact error = 0, unsigned signs = 0) {
  Point point;
  for (std::size_t a = 0; a < 3; ++a) point[a] = p[a] + (signs >> a & 1 ? error : -error);
  return point;
}

/// Values of similar size, so that the rounding error is large compared with their differences.
Way way_through_large_values(Dice& dice) {
  Way way;
  const double base = dice.between(1, 2), spread = std::pow(2, dice.between(-24, -1));
  for (float& f : way.corner) f = static_cast<float>(base * (1 + spread * dice.between(0, 1)));
  for (std::size_t a = 0; a < 3; ++a) {
    way.in[a] = static_cast<float>(dice.between(0, 1));
    way.out[a] = static_cast<float>(dice.between(0, 1));
  }
  return way;
}

/// From a corner, at which the field rises along all axes as steeply as it does anywhere, to the
/// opposite one.
Way way_from_a_steep_corner(Dice& dice) {
  Way way;
  const unsigned at = static_cast<unsigned>(dice.below(8));
  for (unsigned k = 0; k < 8; ++k) way.corner[k] = k == at ? -1.0f : 1.0f;
  for (unsigned a = 0; a < 3; ++a) {
    way.in[a] = at >> a & 1 ? 1.0f : 0.0f;
    way.out[a] = 1 - way.in[a];
  }
  return way;
}

constexpr int trials = 20000;

TEST(WideMargins, of_a_cell_hold_what_rounding_does_and_not_ten_times_as_much) {
  Dice dice(1);
  Exact largest_share = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const Way way = way_through_large_values(dice);
    const float split = static_cast<float>(dice.between(0, 1));
    const Computed computed = computed_by_lanes(way, split, 0);
    const Bernstein exact = exact_cubic(way.corner, point_of(way.in), point_of(way.out));
    Exact error = largest_difference(computed.whole, exact);
    error = std::max(error, largest_difference(computed.before, part(exact, 0, split)));
    error = std::max(error, largest_difference(computed.after, part(exact, split, 1)));
    ASSERT_LE(error, computed.margin) << "trial " << trial;
    const auto [least, largest] = std::minmax_element(way.corner.begin(), way.corner.end());
    if (*largest - *least < 0x1p-6f) largest_share = std::max(largest_share, error / computed.margin);
  }
  // 0.1, plus the points' part of the bound where values differ by a 64th.
  EXPECT_GT(largest_share, 0.13);
}

TEST(WideMargins, of_points_hold_what_their_errors_do_and_not_ten_times_as_much) {
  Dice dice(2);
  Exact largest_share = 0;
  for (const float way_error : {0x1p-11f, 0x1p-14f, 0x1p-17f})
    for (int trial = 0; trial < trials / 100; ++trial) {
      const Way way = trial % 2 == 0 ? way_from_a_steep_corner(dice) : way_through_large_values(dice);
      const Computed computed = computed_by_lanes(way, 0.5f, way_error);
      for (unsigned signs = 0; signs < 64; ++signs) {
        const Bernstein exact =
            exact_cubic(way.corner, point_of(way.in, way_error, signs & 7), point_of(way.out, way_error, signs >> 3));
        const Exact error = largest_difference(computed.whole, exact);
        ASSERT_LE(error, computed.margin) << "trial " << trial << ", signs " << signs;
        largest_share = std::max(largest_share, error / computed.margin);
      }
    }
  EXPECT_GT(largest_share, 0.85);  // three axes of 3.2, less rounding
}

TEST(WideMargins, of_a_block_are_at_least_those_of_its_cells) {
  Dice dice(3);
  for (int trial = 0; trial < trials; ++trial) {
    Way way = way_through_large_values(dice);
    if (dice.coin())
      for (float& f : way.corner) f = dice.coin() ? f : -f;
    const float way_error = dice.coin() ? 0 : static_cast<float>(std::pow(2, dice.between(-24, -10)));
    const Computed computed = computed_by_lanes(way, 0.5f, way_error);
    ASSERT_GE(computed.margin_in_block, computed.margin) << "trial " << trial;
  }
}

TEST(WideMargins, are_infinite_where_points_are_known_too_badly) {
  Dice dice(4);
  const Computed computed = computed_by_lanes(way_from_a_steep_corner(dice), 0.5f, 2e-3f);
  EXPECT_EQ(computed.margin, std::numeric_limits<double>::infinity());
  EXPECT_EQ(computed.margin_in_block, std::numeric_limits<double>::infinity());
}

TEST(WideMargins, of_ways_hold_what_rounding_does_and_not_ten_times_as_much) {
  const auto scratch = std::make_unique<render::wide::IsosurfaceScratch>();
  const auto float_of = [](double x) { return in_all_lanes(static_cast<float>(x)); };
  Dice dice(7);
  double largest_share = 0;
  for (int trial = 0; trial < trials; ++trial) {
    // The ray enters a block of 4 x 4 x 4 cells.
    std::array<double, 3> entry, slope{1, dice.between(1.0 / wide::slow_from, 1), 0};
    slope[2] = dice.coin() ? slope[1] : dice.between(1.0 / wide::slow_from, 1);
    wide::Lanes lanes{};
    wide::BlockEntry at{};
    float steepest = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      entry[a] = dice.between(0, 4);
      const float inverse = static_cast<float>(1 / slope[a]);
      lanes.entry[a] = at.entry[a] = float_of(entry[a]), lanes.slope[a] = float_of(slope[a]);
      lanes.inverse_slope[a] = in_all_lanes(inverse), at.last[a] = lanes.last[a] = in_all_lanes(3);
      steepest = std::max(steepest, inverse);
    }
    lanes.end = in_all_lanes(4);
    std::fill(std::begin(scratch->position_error), std::end(scratch->position_error), 0.0f);
    std::fill(std::begin(scratch->steepest), std::end(scratch->steepest), steepest);
    const double bound = hn::GetLane(error_of_ways(*scratch, at, lanes, 0));

    std::array<double, 3> computed, exact;
    for (std::size_t a = 0; a < 3; ++a) {
      const double plane = std::ceil(entry[a]);
      computed[a] = hn::GetLane(way_to_plane(lanes, static_cast<int>(a), float_of(plane)));
      exact[a] = (plane - entry[a]) / slope[a];
    }
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3;
      if (exact[a] > 4 || exact[b] > 4) continue;
      const double error = std::abs((computed[a] - computed[b]) - (exact[a] - exact[b]));
      ASSERT_LE(error, bound) << "trial " << trial;
      largest_share = std::max(largest_share, error / bound);
    }
  }
  // Two lengths of 2 u times the same inverse slope each, compared with 4.25, and 26 u in addition.
  EXPECT_GT(largest_share, 0.5);
}

/// A ray that moves up along z through a block, and very little along x and y.
wide::Lanes ray_along_z(const std::array<float, 2>& entry, const std::array<float, 2>& slope) {
  wide::Lanes lanes{};
  for (std::size_t a = 0; a < 2; ++a) {
    lanes.entry[a] = in_all_lanes(entry[a]), lanes.slope[a] = in_all_lanes(slope[a]);
    lanes.inverse_slope[a] = in_all_lanes(1 / slope[a]);
  }
  lanes.entry[2] = in_all_lanes(0), lanes.slope[2] = lanes.inverse_slope[2] = in_all_lanes(1);
  for (wide::VecF& last : lanes.last) last = in_all_lanes(3);
  lanes.end = in_all_lanes(4);
  lanes.way_error = in_all_lanes(0);
  lanes.walking = hn::Eq(in_all_lanes(0), in_all_lanes(0));
  return lanes;
}

TEST(WideMargins, of_points_find_cells_that_a_ray_hardly_passes) {
  constexpr float little = 0x1p-14f;
  for (const unsigned axis : {0u, 1u})
    for (const float plane : {1.0f, 2.0f, 3.0f}) {
      // The ray crosses the plane in the middle of the block and is then in the next cell by at
      // most `little`.
      std::array<float, 2> entry{0.5f, 0.5f}, slope{little / 8, little / 8};
      entry[axis] = plane - little, slope[axis] = little / 2;
      wide::Lanes lanes = ray_along_z(entry, slope);
      find_cells(lanes, in_all_lanes(0), in_all_lanes(4));
      const std::uint32_t layers[2] = {static_cast<std::uint32_t>(hn::GetLane(lanes.left[0])),
                                       static_cast<std::uint32_t>(hn::GetLane(lanes.left[1]))};
      const unsigned below = static_cast<unsigned>(plane) - 1, stride = axis == 0 ? 1 : 4;
      EXPECT_TRUE(layers[0] >> (below * stride) & 1) << "first layer, below plane " << plane << " of axis " << axis;
      EXPECT_TRUE(layers[1] >> (16 + (below + 1) * stride) & 1)
          << "last layer, above plane " << plane << " of axis " << axis;
    }
}

/// Rays of one octant through a lattice of 1024 cells on each axis, with major axis w.
void fill_with_rays(render::wide::SearchedRays& rays, unsigned octant, std::size_t w, Dice& dice) {
  constexpr double extent = 1024;
  rays.count = 64, rays.octant = octant;
  std::fill(std::begin(rays.inside), std::end(rays.inside), ~std::uint64_t{0});
  for (std::size_t r = 0; r < rays.count; ++r) {
    rays.t_in[r] = 0, rays.t_out[r] = extent;
    for (std::size_t a = 0; a < 3; ++a) {
      const double speed = a == w ? 1 : dice.between(0, 1);
      rays.origin[a][r] = dice.between(0, extent), rays.direction[a][r] = octant >> a & 1 ? -speed : speed;
    }
  }
}

TEST(WideMargins, of_places_in_a_search_for_largest_values_hold_what_rounding_does_and_not_ten_times_as_much) {
  constexpr std::array<int, 3> nodes{64, 64, 64};
  const auto scratch = std::make_unique<render::wide::MaximumScratch>();
  const Index3 samples(4, 4, 4);  // their values are not used
  const formats::AxisTables tables(formats::BrickLayout{.sample_count = samples});
  const render::wide::MaximumField field{.source = {formats::ElementType::U8, nullptr, tables, samples},
                                         .type = {},
                                         .sample_bytes = 1,
                                         .leaf_count = {},
                                         .node_count = nodes,
                                         .blocks = {},
                                         .nodes = {},
                                         .range = 0,
                                         .has_gaps = false,
                                         .has_squares = false,
                                         .has_bricks = false,
                                         .time_phases = false,
                                         .look_closely = {},
                                         .context = nullptr};
  const render::wide::RayArrays no_rays{};
  const render::wide::SearchedRays& rays = scratch->rays;
  Dice dice(8);
  Exact largest_share = 0;
  for (int trial = 0; trial < trials / 100; ++trial) {
    const auto octant = static_cast<unsigned>(dice.below(8));
    const int w = static_cast<int>(dice.below(3));
    fill_with_rays(scratch->rays, octant, static_cast<std::size_t>(w), dice);
    const render::wide::MirroredLattice lattice(octant, nodes);
    const render::wide::Frustum frustum{
        .major = w, .minor = {w == 0 ? 1 : 0, w == 2 ? 1 : 2}, .first = 0, .last = 1024, .low = {}, .high = {}};
    const wide::SearchState state(field, no_rays, *scratch, lattice, frustum);
    for (std::size_t r = 0; r < rays.count; ++r)
      for (int m = 0; m < 2; ++m) {
        const int u = frustum.minor[m];
        const auto origin = [&](int a) {
          return lattice.is_mirrored(a) ? 1024 - rays.origin[a][r] : rays.origin[a][r];
        };
        const float at = static_cast<float>(dice.between(0, 1024));
        const Exact slope = Exact{std::abs(rays.direction[u][r])} / std::abs(rays.direction[w][r]);
        const Exact exact = origin(u) + (at - Exact{origin(w)}) * slope;
        if (exact < 0 || exact > 1024) continue;  // outside the lattice
        const Exact error = std::abs(std::fma(scratch->lines.slope[m][r], at, scratch->lines.start[m][r]) - exact);
        ASSERT_LE(error, state.margin) << "trial " << trial;
        largest_share = std::max(largest_share, error / state.margin);
      }
  }
  EXPECT_GT(largest_share, 0.1);
}

template <class Real>
class CertifiedMargins : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(CertifiedMargins, Reals);

template <class Real>
std::pair<std::array<double, 4>, double> enclosed(const Way& way, double point_error) {
  render::TrilinearCell cell;
  for (std::size_t k = 0; k < 8; ++k) cell.corner[k] = way.corner[k];
  const auto enclosed = render::enclosed_along<Real>(cell, Vec3(way.in[0], way.in[1], way.in[2]),
                                                     Vec3(way.out[0], way.out[1], way.out[2]), point_error, 0);
  std::array<double, 4> b;
  for (std::size_t i = 0; i < 4; ++i) b[i] = enclosed.unit * static_cast<double>(enclosed.cubic.b[i]);
  return {b, enclosed.unit * static_cast<double>(enclosed.margin)};
}

TYPED_TEST(CertifiedMargins, of_a_cell_hold_what_rounding_does_and_not_ten_times_as_much) {
  Dice dice(5);
  Exact largest_share = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const Way way = way_through_large_values(dice);
    const auto [b, margin] = enclosed<TypeParam>(way, 0);
    const Exact error = largest_difference(b, exact_cubic(way.corner, point_of(way.in), point_of(way.out)));
    ASSERT_LE(error, margin) << "trial " << trial;
    largest_share = std::max(largest_share, error / margin);
  }
  EXPECT_GT(largest_share, 0.1);
}

TYPED_TEST(CertifiedMargins, of_points_hold_what_their_errors_do_and_not_ten_times_as_much) {
  Dice dice(6);
  Exact largest_share = 0;
  for (const double point_error : {0x1p-11, 0x1p-14, 0x1p-17})
    for (int trial = 0; trial < trials / 100; ++trial) {
      const Way way = trial % 2 == 0 ? way_from_a_steep_corner(dice) : way_through_large_values(dice);
      const auto [b, margin] = enclosed<TypeParam>(way, point_error);
      for (unsigned signs = 0; signs < 64; ++signs) {
        const Exact error = largest_difference(b, exact_cubic(way.corner, point_of(way.in, point_error, signs & 7),
                                                              point_of(way.out, point_error, signs >> 3)));
        ASSERT_LE(error, margin) << "trial " << trial << ", signs " << signs;
        largest_share = std::max(largest_share, error / margin);
      }
    }
  EXPECT_GT(largest_share, 0.9);  // three axes of 3.1
}

/// Returns the zero of a decreasing cubic that is above 0 at 0 and below 0 at 1.
Exact root_of(const Bernstein& b) {
  Exact lo = 0, hi = 1;
  for (int i = 0; i < 80; ++i) {
    const Exact middle = (lo + hi) / 2;
    (polar(b, {middle, middle, middle}) > 0 ? lo : hi) = middle;
  }
  return lo;
}

TYPED_TEST(CertifiedMargins, of_a_root_reach_to_the_roots_of_all_cubics_within_the_margin) {
  Dice dice(9);
  Exact largest_share = 0;
  for (int trial = 0; trial < trials; ++trial) {
    // Falls steeply, then slowly, or the reverse: the roots are farther away on one side.
    const double little = std::pow(2, dice.between(-12, 0)), margin = little * std::pow(2, dice.between(-12, -1));
    std::array<double, 4> b{1, little * dice.between(-1, 1), little * dice.between(-1, 1), -little};
    std::sort(b.begin(), b.end(), std::greater<>());
    if (dice.coin()) b = {-b[3], -b[2], -b[1], -b[0]};
    render::StartSideUp<TypeParam> way{};
    way.margin = static_cast<TypeParam>(margin);
    for (std::size_t i = 0; i < 4; ++i) way.cubic.b[i] = static_cast<TypeParam>(b[i]);
    const render::CertifiedCrossing found = way.enclosed_change(0, 1);
    for (const double sign : {-1.0, 1.0}) {
      Bernstein exact;
      for (std::size_t i = 0; i < 4; ++i) exact[i] = Exact{way.cubic.b[i]} + sign * 0.99 * Exact{way.margin};
      const Exact error = std::abs(root_of(exact) - found.s);
      ASSERT_LE(error, found.s_error) << "trial " << trial;
      largest_share = std::max(largest_share, error / found.s_error);
    }
  }
  EXPECT_GT(largest_share, 0.7);
}

}  // namespace
}  // namespace rhoray::tests

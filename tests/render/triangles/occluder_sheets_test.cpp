#include "render/triangles/shadow/occluder_sheets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace rhoray::tests {
namespace {

using render::FacetBlock;
using render::FacetField;
using render::FacetNeighbours;
using render::Machine;
using render::wide::FacetHeights;
using render::wide::SeenFromLight;
using render::wide::Squares;

/// A flat facet with its corners in order around it; a triangle repeats its last one.
using FacetCorners = std::array<std::array<float, 3>, 4>;

constexpr float unknown = -std::numeric_limits<float>::infinity();
constexpr double margin = 0x1p-18;
constexpr int edge = 32;
const Squares squares{.count = {edge, edge}, .first = {-1, -1}, .per_length = edge / 2.0};

/// A sheet over [-0.5, 0.5]^2 of n x n quadrilaterals, split into triangles if `cut`, alternately
/// clockwise and counter-clockwise.
std::vector<FacetCorners> sheet(int n, float height, bool cut) {
  std::vector<FacetCorners> facets;
  const auto at = [&](int i, int j) -> std::array<float, 3> {
    return {static_cast<float>(i) / static_cast<float>(n) - 0.5F, static_cast<float>(j) / static_cast<float>(n) - 0.5F,
            height + 0.01F * static_cast<float>(i % 3)};
  };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const auto a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      if (cut) {
        facets.push_back({a, b, c, c});
        facets.push_back({d, c, a, a});
      } else {
        facets.push_back((i + j) % 2 == 0 ? FacetCorners{a, b, c, d} : FacetCorners{d, c, b, a});
      }
    }
  return facets;
}

/// Facets in the kernels' form. All are marked as certainly facing the light with the same side:
/// their field rises towards it. From index `falls_from` on that is not true.
struct Surface {
  std::vector<FacetBlock> blocks;
  std::vector<FacetField> fields;
  std::vector<std::uint32_t> sources;
  std::vector<std::uint16_t> sure;

  Surface(const std::vector<FacetCorners>& facets, const Vec3& towards, std::size_t falls_from)
      : blocks((facets.size() + 15) / 16), fields(facets.size()), sources(facets.size()), sure(blocks.size(), 0xffff) {
    for (std::size_t f = 0; f < blocks.size() * 16; ++f)
      for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t a = 0; a < 3; ++a)
          blocks[f / 16].corner[c][a][f % 16] = facets[std::min(f, facets.size() - 1)][c][a];
    for (std::size_t f = 0; f < facets.size(); ++f) {
      for (int a = 0; a < 3; ++a) fields[f].gradient[a] = f < falls_from ? towards[a] : -towards[a];
      sources[f] = static_cast<std::uint32_t>(f);
    }
  }
};

FacetHeights heights_on(Machine machine, const std::vector<FacetCorners>& facets, const Vec3& towards,
                        std::size_t falls_from) {
  const Surface surface(facets, towards, falls_from);
  const auto count = static_cast<std::uint32_t>(facets.size());
  const FacetNeighbours neighbours(surface.blocks.data(), surface.fields.data(), count);
  const render::wide::FrontFacing seen_facets(machine, SeenFromLight(towards), margin, surface.blocks.data(), count);
  return heights_of_sheets(
      machine, squares, margin,
      {.seen = seen_facets, .sources = surface.sources.data(), .sure = surface.sure.data(), .rises = true}, neighbours);
}

/// Expects the same on all machines.
std::vector<float> heights_of(const std::vector<FacetCorners>& facets, const Vec3& towards = {0, 0, 1},
                              std::size_t falls_from = ~std::size_t{0}) {
  const FacetHeights heights = heights_on(Machine::baseline, facets, towards, falls_from);
  for (const Machine machine : {Machine::avx2, Machine::avx512})
    if (has_machine(machine)) {
      const FacetHeights others = heights_on(machine, facets, towards, falls_from);
      EXPECT_EQ(others.above, heights.above);
      EXPECT_EQ(others.below, heights.below);
    }
  return heights.below;
}

/// Returns the square that contains a position.
std::size_t square_at(double x, double y) {
  return static_cast<std::size_t>((y + 1) * edge / 2) * edge + static_cast<std::size_t>((x + 1) * edge / 2);
}

TEST(OccluderSheets, cover_what_lies_within_their_rims) {
  for (const bool cut : {false, true})
    for (const int n : {1, 3, 5, 40}) {
      const std::vector<float> heights = heights_of(sheet(n, 0.25F, cut));
      std::size_t known = 0;
      for (int y = 0; y < edge; ++y)
        for (int x = 0; x < edge; ++x) {
          const float height = heights[static_cast<std::size_t>(y * edge + x)];
          if (height == unknown) continue;
          ++known;
          EXPECT_TRUE(x >= 8 && x < 24 && y >= 8 && y < 24) << x << ' ' << y << " of " << n;
          EXPECT_GE(height, 0.25F);
          EXPECT_LE(height, n == 1 ? 0.25F : 0.27F) << "the lowest of all that touch the square";
        }
      // Squares that touch the rim are not known: 16 x 16 minus their border remain, at least.
      EXPECT_EQ(known, 14U * 14) << n;
      EXPECT_EQ(heights.size(), squares.size() + 1);
      EXPECT_EQ(heights.back(), unknown);
    }
}

TEST(OccluderSheets, end_at_holes) {
  std::vector<FacetCorners> facets = sheet(8, 0, false);
  facets.erase(facets.begin() + 8 * 3 + 4);  // x from 0 to 0.125, y from -0.125 to 0
  const std::vector<float> heights = heights_of(facets);
  EXPECT_EQ(heights[square_at(0.06, -0.06)], unknown);
  EXPECT_EQ(heights[square_at(0.01, -0.06)], unknown);
  EXPECT_NE(heights[square_at(0.3, -0.3)], unknown);
}

// Rays may pass between two halves at different heights, because they are apart: seen from the
// light there is no gap.
TEST(OccluderSheets, end_where_their_facets_only_seem_to_meet) {
  std::vector<FacetCorners> facets = sheet(8, 0, false);
  for (FacetCorners& facet : facets) {
    float middle = 0;
    for (const auto& corner : facet) middle += corner[0];
    if (middle > 0)
      for (auto& corner : facet) corner[2] += 0.125F;
  }
  const std::vector<float> heights = heights_of(facets);
  for (double y = -0.9; y < 0.9; y += 0.03) EXPECT_EQ(heights[square_at(0.01, y)], unknown);
  EXPECT_GE(heights[square_at(0.3, 0.1)], 0.125F);
  EXPECT_GE(heights[square_at(-0.3, 0.1)], 0.0F);
}

// Where two sheets overlap, what is below both is in shadow; where one has a rim, nothing is known.
TEST(OccluderSheets, of_two_the_lowest_counts) {
  std::vector<FacetCorners> facets = sheet(6, 0.5F, true);
  for (FacetCorners& facet : facets)
    // Moved to x from 0 to 0.5.
    for (auto& corner : facet) corner[0] = 0.5F * corner[0] + 0.25F;
  const std::vector<FacetCorners> below = sheet(4, -0.5F, false);
  facets.insert(facets.end(), below.begin(), below.end());
  const std::vector<float> heights = heights_of(facets);
  for (const double x : {-0.3, -0.1, 0.1, 0.2}) {
    EXPECT_GE(heights[square_at(x, 0.1)], -0.5F);
    EXPECT_LE(heights[square_at(x, 0.1)], -0.47F);
  }
  EXPECT_EQ(heights[square_at(0.001, 0.1)], unknown);
}

// Three facets at an edge, or two that pass it in the same direction, form no sheet there.
TEST(OccluderSheets, end_at_edges_of_more_than_two_facets) {
  std::vector<FacetCorners> facets = sheet(8, 0, false);
  facets.push_back({facets[27][0], facets[27][1], {0.03F, 0.1F, 0.2F}, {0.03F, 0.1F, 0.2F}});
  const std::vector<float> heights = heights_of(facets);
  const auto& corner = facets[27][0];
  EXPECT_EQ(heights[square_at(static_cast<double>(corner[0]), static_cast<double>(corner[1]))], unknown);
  EXPECT_NE(heights[square_at(-0.3, -0.3)], unknown);
}

TEST(OccluderSheets, have_no_facets_that_are_no_numbers) {
  std::vector<FacetCorners> facets = sheet(8, 0, false);
  facets[27][1][0] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> heights = heights_of(facets);
  EXPECT_EQ(heights[square_at(-0.06, -0.06)], unknown);
  EXPECT_NE(heights[square_at(-0.3, -0.3)], unknown);
  // Half a square, and one of these facets beyond its diagonal.
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr std::array<float, 3> a{-0.5F, -0.5F, 0}, b{0.5F, -0.5F, 0}, c{-0.5F, 0.5F, 0}, none{nan, 0.5F, 0};
  EXPECT_EQ(heights_of({{a, b, c, c}, {b, none, c, c}})[square_at(0.3, 0.3)], unknown);
  EXPECT_TRUE(heights_of({}).empty());
}

// A sheet that folds back under itself, with facets that also face the light: light passes beside
// the fold.
TEST(OccluderSheets, end_where_they_are_folded) {
  std::vector<FacetCorners> facets = sheet(8, 0.25F, false);
  for (FacetCorners& facet : facets)
    for (auto& p : facet) p[0] = 0.53F * (p[0] - 0.5F) + 0.03F;  // up to x = 0.03, inside a square
  std::vector<FacetCorners> back = facets;
  for (FacetCorners& facet : back)
    for (auto& p : facet)
      if (p[0] < 0.02F) p[2] -= 0.5F;
  facets.insert(facets.end(), back.begin(), back.end());
  const std::vector<float> heights = heights_of(facets);
  for (double y = -0.45; y < 0.45; y += 0.05) EXPECT_EQ(heights[square_at(0.031, y)], unknown);
  EXPECT_LE(heights[square_at(-0.2, 0.1)], -0.2F);
  EXPECT_GE(heights[square_at(-0.2, 0.1)], -0.25F);
}

// Half a square, and a narrow facet along its diagonal, whose own rims bend there. Squares in the
// other half are beside the sheet, although no rim touches them and they are in the box around the
// first facet.
TEST(OccluderSheets, end_at_rims_that_bend) {
  constexpr std::array<float, 3> a{-0.5F, -0.5F, 0}, b{0.5F, -0.5F, 0}, c{-0.5F, 0.5F, 0}, bend{0.05F, 0.05F, 0};
  const std::vector<float> heights = heights_of({{a, b, c, c}, {b, bend, c, c}});
  EXPECT_EQ(heights[square_at(-0.3, -0.3)], 0.0F);
  for (const double at : {0.15, 0.3, 0.45}) EXPECT_EQ(heights[square_at(at, at)], unknown);
}

// Rows of facets so thin that rounding hides their orientation, or that are seen from behind by as
// little: light passes neither through them nor through their neighbours.
TEST(OccluderSheets, go_on_through_thin_facets) {
  for (const float thickness : {1e-3F, 1e-6F, 1e-7F, -1e-7F, -1e-6F}) {
    std::vector<FacetCorners> facets = sheet(8, 0.25F, false);
    const std::size_t count = facets.size();
    for (std::size_t f = 0; f < count; ++f) {
      // Between the rows from y = 0 on and those below, which end lower by the thickness.
      const bool is_below = f / 8 < 4;
      for (auto& p : facets[f])
        if (is_below && p[1] == 0) p[1] = -thickness;
      if (!is_below || f / 8 < 3) continue;
      const float from = static_cast<float>(f % 8) / 8 - 0.5F, to = from + 0.125F;
      const float height_from = 0.25F + 0.01F * static_cast<float>(f % 8 % 3),
                  height_to = 0.25F + 0.01F * static_cast<float>((f % 8 + 1) % 3);
      facets.push_back(
          {{{from, -thickness, height_from}, {to, -thickness, height_to}, {to, 0, height_to}, {from, 0, height_from}}});
    }
    const std::vector<float> heights = heights_of(facets);
    for (double x = -0.4; x < 0.4; x += 0.05)
      for (const double y : {-0.2, -0.01, 0.01, 0.2}) EXPECT_GE(heights[square_at(x, y)], 0.25F) << thickness;
  }
}

// A pocket: an upper sheet and a lower one that share all their rims, seen from opposite sides.
// They form one sheet that covers each place once and minus once. The mark that they all face the
// light is not trusted.
TEST(OccluderSheets, are_not_told_by_facets_that_are_seen_from_behind) {
  std::vector<FacetCorners> facets = sheet(8, 0, true);
  const std::size_t count = facets.size();
  for (std::size_t f = 0; f < count; ++f) {
    FacetCorners below = facets[f];
    for (auto& p : below)
      if (std::abs(p[0]) < 0.49F && std::abs(p[1]) < 0.49F) p[2] -= 0.5F;
    facets.push_back(below);
  }
  for (const float height : heights_of(facets, {0, 0, 1}, count)) EXPECT_EQ(height, unknown);
}

// Light from the side, along another axis: what is in front of a position there is below it as seen
// from the light.
TEST(OccluderSheets, are_seen_from_wherever_the_light_stands) {
  std::vector<FacetCorners> facets = sheet(6, 0, false);
  for (FacetCorners& facet : facets)
    // Perpendicular to the x axis, at about -0.3.
    for (auto& p : facet) p = {0.1F * p[0] - 0.3F, p[1], p[0]};
  const std::vector<float> heights = heights_of(facets, {-2, 0.4, 0.6});
  // The place of its middle: y + 0.2 x, z + 0.3 x.
  const float height = heights[square_at(-0.06, -0.09)];
  ASSERT_NE(height, unknown);
  EXPECT_NEAR(height, 0.3F, 0.06F);
}

}  // namespace
}  // namespace rhoray::tests

#include "render/kernels/wide/blocker_sheets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace rhoray::tests {
namespace {

using render::wide::FacetCorners;
using render::wide::SeenFromLight;
using render::wide::Squares;

constexpr float unknown = -std::numeric_limits<float>::infinity();
constexpr double margin = 0x1p-18;
constexpr int edge = 32;
const Squares squares{.count = {edge, edge}, .first = {-1, -1}, .per_length = edge / 2.0};
const SeenFromLight seen(Vec3(0, 0, 1));  // places are x, y

/// A sheet over [-0.5, 0.5]^2 of n x n quadrilaterals, cut in two where `cut`, in turns clockwise and
/// counter-clockwise.
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

std::vector<float> heights_of(const std::vector<FacetCorners>& facets) {
  return heights_below_sheets(seen, squares, margin, facets);
}

/// The square that holds a place.
std::size_t square_at(double x, double y) {
  return static_cast<std::size_t>((y + 1) * edge / 2) * edge + static_cast<std::size_t>((x + 1) * edge / 2);
}

TEST(BlockerSheets, cover_what_lies_within_their_rims) {
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
          EXPECT_LE(height, 0.27F);
        }
      // Squares that touch the rim are not known: 16 x 16 less their border, at least.
      EXPECT_EQ(known, 14U * 14) << n;
      EXPECT_EQ(heights.size(), squares.size() + 1);
      EXPECT_EQ(heights.back(), unknown);
    }
}

TEST(BlockerSheets, end_at_holes) {
  std::vector<FacetCorners> facets = sheet(8, 0, false);
  facets.erase(facets.begin() + 8 * 3 + 4);  // x from 0 to 0.125, y from -0.125 to 0
  const std::vector<float> heights = heights_of(facets);
  EXPECT_EQ(heights[square_at(0.06, -0.06)], unknown);
  EXPECT_EQ(heights[square_at(0.01, -0.06)], unknown);
  EXPECT_NE(heights[square_at(0.3, -0.3)], unknown);
}

// Between two halves at different heights rays may pass, as they stand apart: seen from the light there is no hole.
TEST(BlockerSheets, end_where_their_facets_only_seem_to_meet) {
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

// What lies below the upper one of two sheets lies in shadow, and beyond its rim what lies below the lower one.
TEST(BlockerSheets, of_two_the_highest_counts) {
  std::vector<FacetCorners> facets = sheet(6, 0.5F, true);
  for (FacetCorners& facet : facets)
    for (auto& corner : facet) corner[0] = 0.5F * corner[0] + 0.25F;  // from the middle on
  const std::vector<FacetCorners> below = sheet(4, -0.5F, false);
  facets.insert(facets.end(), below.begin(), below.end());
  const std::vector<float> heights = heights_of(facets);
  EXPECT_GE(heights[square_at(0.2, 0.1)], 0.5F);
  for (const double x : {-0.3, -0.03, 0.03}) {
    EXPECT_GE(heights[square_at(x, 0.1)], -0.5F);
    EXPECT_LE(heights[square_at(x, 0.1)], -0.47F);
  }
}

// Three facets at an edge, or two that pass it the same way, make no sheet there.
TEST(BlockerSheets, end_at_edges_of_more_than_two_facets) {
  std::vector<FacetCorners> facets = sheet(8, 0, false);
  facets.push_back({facets[27][0], facets[27][1], {0.03F, 0.1F, 0.2F}, {0.03F, 0.1F, 0.2F}});
  const std::vector<float> heights = heights_of(facets);
  const auto& corner = facets[27][0];
  EXPECT_EQ(heights[square_at(static_cast<double>(corner[0]), static_cast<double>(corner[1]))], unknown);
  EXPECT_NE(heights[square_at(-0.3, -0.3)], unknown);
}

TEST(BlockerSheets, have_no_facets_that_are_seen_edge_on_or_are_no_numbers) {
  std::vector<FacetCorners> facets = sheet(8, 0, false);
  for (auto& corner : facets[27]) corner[1] = facets[27][0][1] + 1e-7F * corner[0];
  const auto without = heights_of(facets);
  EXPECT_EQ(without[square_at(-0.06, -0.06)], unknown);
  facets = sheet(8, 0, false);
  facets[27][1][0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(heights_of(facets)[square_at(-0.06, -0.06)], unknown);
  EXPECT_EQ(heights_of({})[square_at(0, 0)], unknown);
}

// Light from the side, along an axis that is turned: what stands before a place there is below it as the light sees it.
TEST(BlockerSheets, are_seen_from_wherever_the_light_stands) {
  const SeenFromLight from_left(Vec3(-2, 0.4, 0.6));
  std::vector<FacetCorners> facets = sheet(6, 0, false);
  for (FacetCorners& facet : facets)
    for (auto& p : facet) p = {0.1F * p[0] - 0.3F, p[1], p[0]};  // across the x axis, at about -0.3
  const std::vector<float> heights = heights_below_sheets(from_left, squares, margin, facets);
  // Its middle's place: y + 0.2 x, z + 0.3 x.
  const float height = heights[square_at(-0.06, -0.09)];
  ASSERT_NE(height, unknown);
  EXPECT_NEAR(height, 0.3F, 0.06F);
}

}  // namespace
}  // namespace rhoray::tests

#include "formats/brick_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/text.h"

namespace rhoray::formats {
namespace {

/// The address by definition: sample in brick, brick in superbrick, superbrick in array, each x
/// fastest.
std::uint64_t address_by_definition(const BrickLayout& layout, const Index3& p) {
  const std::int64_t n = layout.brick_edge;
  const Index3 m = layout.superbrick_edge, count = layout.superbrick_count();
  const auto x_fastest = [](const Index3& at, const Index3& size) { return (at.z * size.y + at.y) * size.x + at.x; };
  const Index3 brick = p / n, super = brick / m;
  const Index3 in_brick = p - brick * n, in_super = brick - super * m;
  return static_cast<std::uint64_t>((x_fastest(super, count) * volume(m) + x_fastest(in_super, m)) * n * n * n +
                                    x_fastest(in_brick, {n, n, n}));
}

TEST(BrickLayout, addresses_are_a_bijection_onto_the_padded_array) {
  for (const Index3& size : {Index3(2, 2, 2), Index3(5, 6, 7), Index3(16, 3, 9), Index3(37, 8, 21), Index3(2, 40, 13)})
    for (const std::int64_t n : {1, 2, 3, 4, 8})
      for (const std::int64_t largest : {1, 3, 8}) {
        const BrickLayout layout = BrickLayout::bricked(size, n, largest);
        const AxisTables tables(layout);
        const Index3 padded = layout.padded_count();
        std::vector<int> hits(static_cast<std::size_t>(volume(padded)));
        for (std::int64_t k = 0; k < padded.z; ++k)
          for (std::int64_t j = 0; j < padded.y; ++j)
            for (std::int64_t i = 0; i < padded.x; ++i) {
              const std::uint64_t address = tables.address(i, j, k);
              ASSERT_LT(address, hits.size());
              ASSERT_EQ(address, address_by_definition(layout, {i, j, k}));
              ++hits[address];
            }
        EXPECT_THAT(hits, testing::Each(1)) << concat(size.x, "x", size.y, "x", size.z, ", n ", n, ", m to ", largest);
        std::uint64_t elements = 1;
        for (const std::uint64_t extent : layout.shape()) elements *= extent;
        EXPECT_EQ(elements, hits.size());
      }
}

TEST(BrickLayout, linear_is_x_fastest) {
  const BrickLayout layout = BrickLayout::linear({5, 6, 7});
  const AxisTables tables(layout);
  EXPECT_TRUE(layout.is_linear());
  EXPECT_EQ(layout.padded_count(), Index3(5, 6, 7));
  EXPECT_THAT(layout.shape(), testing::ElementsAre(7, 6, 5));
  for (int k = 0; k < 7; ++k)
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 5; ++i) ASSERT_EQ(tables.address(i, j, k), static_cast<std::uint64_t>((k * 6 + j) * 5 + i));
}

TEST(BrickLayout, superbricks_add_at_most_a_share_of_1_5_percent_and_are_as_large_as_that_allows) {
  for (std::int64_t size = 2; size < 3000; size = size * 9 / 8 + 1)
    for (const std::int64_t n : {1, 4, 8}) {
      const std::int64_t bricks = (size + n - 1) / n;
      const std::int64_t m = BrickLayout::bricked({size, 2, 2}, n, 8).superbrick_edge.x;
      const auto added = [&](std::int64_t edge) { return (bricks + edge - 1) / edge * edge - bricks; };
      EXPECT_LE(static_cast<double>(added(m)), 0.015 * static_cast<double>(bricks)) << size;
      EXPECT_LE(m, bricks);
      for (std::int64_t larger = m + 1; larger <= std::min<std::int64_t>(8, bricks); ++larger)
        EXPECT_GT(static_cast<double>(added(larger)), 0.015 * static_cast<double>(bricks)) << size;
    }
}

TEST(BrickLayout, real_sizes_are_packed_with_little_padding) {
  // z: 434 bricks, padded by 6
  EXPECT_EQ(BrickLayout::bricked({512, 512, 1734}).superbrick_edge, Index3(8, 8, 8));
  EXPECT_EQ(BrickLayout::bricked({512, 512, 1734}).padded_count(), Index3(512, 512, 1760));
  // z: 28 bricks
  EXPECT_EQ(BrickLayout::bricked({256, 256, 109}).superbrick_edge, Index3(8, 8, 7));
  // z: 43 bricks, a prime
  EXPECT_EQ(BrickLayout::bricked({256, 256, 172}).superbrick_edge, Index3(8, 8, 1));
}

}  // namespace
}  // namespace rhoray::formats

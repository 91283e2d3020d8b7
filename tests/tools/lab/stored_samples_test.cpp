#include "tools/lab/stored_samples.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/tools/lab/small_grid.h"

namespace rhoray::study {
namespace {

TEST(StoredSamples, rounds_to_half_as_binary16_does) {
  // By hand: 11 significant bits, ties to even, steps of 2^-24 below 2^-14, nothing beyond 65504.
  EXPECT_EQ(rounded_to_half(0), 0);
  EXPECT_EQ(rounded_to_half(1), 1);
  EXPECT_EQ(rounded_to_half(-2047), -2047);
  EXPECT_EQ(rounded_to_half(2049), 2048);  // a tie between 2048 and 2050
  EXPECT_EQ(rounded_to_half(2051), 2052);
  EXPECT_EQ(rounded_to_half(0.1), 0.0999755859375);
  EXPECT_EQ(rounded_to_half(0x1p-24), 0x1p-24);
  EXPECT_EQ(rounded_to_half(0x1p-26), 0);
  EXPECT_EQ(rounded_to_half(65504), 65504);
  EXPECT_EQ(rounded_to_half(65519), 65504);
  EXPECT_EQ(rounded_to_half(65520), std::numeric_limits<double>::infinity());
  EXPECT_EQ(rounded_to_half(-1e9), -std::numeric_limits<double>::infinity());
}

TEST(StoredSamples, leaves_out_storages_that_hold_every_value) {
  const preprocess::NeutralVolume grid = tests::ball_grid(8);  // 16-bit
  std::vector<std::string> made;
  for (const Storage& storage : storages())
    if (stored_as(storage, grid, {0, 1000})) made.emplace_back(storage.name);
  EXPECT_THAT(made, testing::ElementsAre("half", "12 bits", "10 bits", "8 bits"));
}

TEST(StoredSamples, keeps_values_to_half_a_step) {
  const preprocess::NeutralVolume grid = tests::ball_grid(8);
  const Storage& eight = storages().back();
  ASSERT_EQ(eight.bits, 8);
  const StoredSamples stored = stored_as(eight, grid, {0, 1000}).value();
  const auto* const was = reinterpret_cast<const std::uint16_t*>(grid.samples.data());
  const auto* const is = reinterpret_cast<const std::uint8_t*>(stored.volume.samples.data());
  for (std::size_t s = 0; s < 512; ++s)
    EXPECT_LE(std::abs(is[s] / stored.scale + stored.offset - was[s]), 0.5 / stored.scale + 1e-9);
  EXPECT_EQ(stored.own(0), 0);
  EXPECT_EQ(stored.own(1000), 255);
}

}  // namespace
}  // namespace rhoray::study

#include "tools/lab/structures/hilbert_curve.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <map>
#include <random>

namespace rhoray::study {
namespace {

using Cube = std::array<std::uint32_t, 3>;

/// The cubes of edge^3 of a block, by their positions along the curve.
std::map<std::uint64_t, Cube> block_along_curve(const Cube& low, std::uint32_t edge, std::uint32_t spacing) {
  std::map<std::uint64_t, Cube> block;
  for (std::uint32_t z = 0; z < edge; ++z)
    for (std::uint32_t y = 0; y < edge; ++y)
      for (std::uint32_t x = 0; x < edge; ++x) {
        const Cube cube{low[0] + x * spacing, low[1] + y * spacing, low[2] + z * spacing};
        block[hilbert_position(cube[0], cube[1], cube[2])] = cube;
      }
  return block;
}

std::uint32_t steps_between(const Cube& a, const Cube& b) {
  std::uint32_t steps = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) steps += a[axis] > b[axis] ? a[axis] - b[axis] : b[axis] - a[axis];
  return steps;
}

TEST(HilbertCurve, passes_every_cube_of_a_block_from_face_to_face_before_it_leaves_it) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 50; ++round) {
    Cube low;
    for (std::uint32_t& l : low) l = static_cast<std::uint32_t>(random() % (1 << 21)) & ~7U;
    const auto block = block_along_curve(low, 8, 1);
    ASSERT_EQ(block.size(), 512U);
    EXPECT_EQ(block.begin()->first % 512, 0U);
    EXPECT_EQ(block.rbegin()->first, block.begin()->first + 511);
    for (auto at = block.begin(), next = std::next(at); next != block.end(); at = next++)
      ASSERT_EQ(steps_between(at->second, next->second), 1U);
  }
}

TEST(HilbertCurve, leads_from_block_to_neighbouring_block) {
  for (const std::uint32_t spacing : {1U << 18, 1U << 17}) {
    const auto blocks = block_along_curve({0, 0, 0}, 8, spacing);
    ASSERT_EQ(blocks.size(), 512U);
    for (auto at = blocks.begin(), next = std::next(at); next != blocks.end(); at = next++)
      ASSERT_EQ(steps_between(at->second, next->second), spacing);
  }
}

TEST(HilbertCurve, has_its_ends_in_corners_of_one_edge) {
  constexpr std::uint32_t last = (1 << 21) - 1;
  EXPECT_EQ(hilbert_position(0, 0, 0), 0U);
  int ends = 0;
  for (const Cube& corner : {Cube{last, 0, 0}, Cube{0, last, 0}, Cube{0, 0, last}})
    ends += hilbert_position(corner[0], corner[1], corner[2]) == (std::uint64_t{1} << 63) - 1;
  EXPECT_EQ(ends, 1);
}

}  // namespace
}  // namespace rhoray::study

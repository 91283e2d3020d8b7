#include "data/recipes/test_volumes.h"

#include <gmock/gmock.h>

#include <cstring>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/parallel.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using recipes::TestVolume;

std::vector<std::uint16_t> samples_of(TestVolume which, std::int64_t size) {
  const TemporaryFolder folder;
  recipes::write_test_volume(folder / "v.nhdr", {.which = which, .size = size});
  const std::string raw = read_file(folder / "v.raw");
  std::vector<std::uint16_t> samples(raw.size() / 2);
  std::memcpy(samples.data(), raw.data(), raw.size());
  EXPECT_EQ(samples.size(), static_cast<std::size_t>(size * size * size));
  return samples;
}

TEST(TestVolumes, smooth_is_a_body_that_stays_off_the_border_and_has_an_inner_structure) {
  constexpr std::int64_t n = 64;
  const std::vector<std::uint16_t> samples = samples_of(TestVolume::smooth, n);
  const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return samples[static_cast<std::size_t>((k * n + j) * n + i)];
  };
  std::int64_t in_body = 0, in_structure = 0, largest_step = 0;
  for (std::int64_t k = 0; k < n; ++k)
    for (std::int64_t j = 0; j < n; ++j)
      for (std::int64_t i = 0; i < n; ++i) {
        in_body += at(i, j, k) > 600;
        in_structure += at(i, j, k) > 2200;
        if (i > 0) largest_step = std::max<std::int64_t>(largest_step, std::abs(at(i, j, k) - at(i - 1, j, k)));
        const auto is_near_border = [&](std::int64_t p) { return p < 3 || p >= n - 3; };
        if (is_near_border(i) || is_near_border(j) || is_near_border(k)) {
          EXPECT_LT(at(i, j, k), 600);
        }
      }
  const double share = 1.0 / static_cast<double>(n * n * n);
  EXPECT_GT(static_cast<double>(in_body) * share, 0.2);
  EXPECT_LT(static_cast<double>(in_body) * share, 0.5);
  EXPECT_GT(in_structure, in_body / 20);
  EXPECT_LT(in_structure, in_body / 2);
  EXPECT_LT(largest_step, 1200);
}

TEST(TestVolumes, turbulent_crosses_its_middle_everywhere) {
  constexpr std::size_t n = 64, block = 16;
  const std::vector<std::uint16_t> samples = samples_of(TestVolume::turbulent, n);
  int crossed = 0;
  for (std::size_t b = 0; b < 64; ++b) {
    std::uint16_t smallest = 65535, largest = 0;
    for (std::size_t s = 0; s < block * block * block; ++s) {
      const std::size_t i = b % 4 * block + s % block, j = b / 4 % 4 * block + s / block % block,
                        k = b / 16 * block + s / (block * block);
      smallest = std::min(smallest, samples[(k * n + j) * n + i]);
      largest = std::max(largest, samples[(k * n + j) * n + i]);
    }
    crossed += smallest < 2048 && largest > 2048;
  }
  EXPECT_GE(crossed, 60);
}

TEST(TestVolumes, are_the_same_for_any_number_of_threads) {
  for (const TestVolume which : {TestVolume::smooth, TestVolume::turbulent}) {
    const std::vector<std::uint16_t> samples = samples_of(which, 33);
    const ThreadLimit one(1);
    EXPECT_EQ(samples_of(which, 33), samples);
  }
}

TEST(TestVolumes, refuse_sizes_without_sense) {
  const TemporaryFolder folder;
  for (const std::int64_t size : {1, 4097})
    EXPECT_THROW(recipes::write_test_volume(folder / "v.nhdr", {.size = size}), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace rhoray::tests

#include "data/recipes/marschner_lobb.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "formats/base/error.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

TEST(MarschnerLobb, has_the_values_that_follow_from_the_paper_by_hand) {
  // In the middle: cos(12 pi) = 1, so (1 - 0 + 1/4 * 2) / (5/2) = 0.6. At z = 1 and -1 the sine is
  // 1 and -1.
  EXPECT_NEAR(recipes::marschner_lobb({0, 0, 0}), 0.6, 1e-15);
  EXPECT_NEAR(recipes::marschner_lobb({0, 0, 1}), 0.2, 1e-15);
  EXPECT_NEAR(recipes::marschner_lobb({0, 0, -1}), 1.0, 1e-15);
  // At r = 1 the inner cosine is 0 and the outer one 1 again.
  EXPECT_NEAR(recipes::marschner_lobb({0.6, 0.8, 0}), 0.6, 1e-15);
  // Where cos(pi r / 2) = 1/12 the outer cosine is -1: (1 + 0) / 2.5.
  EXPECT_NEAR(recipes::marschner_lobb({std::acos(1.0 / 12) * 2 / std::numbers::pi, 0, 0}), 0.4, 1e-12);
}

TEST(MarschnerLobb, is_written_x_fastest_from_corner_to_corner) {
  const TemporaryFolder folder;
  recipes::write_marschner_lobb(folder / "ml.nhdr", {.size = 5});
  EXPECT_THAT(read_file(folder / "ml.nhdr"),
              testing::AllOf(testing::StartsWith("NRRD0005\n"), testing::HasSubstr("type: float\n"),
                             testing::HasSubstr("sizes: 5 5 5\n"), testing::HasSubstr("space origin: (-1,-1,-1)\n"),
                             testing::HasSubstr("space directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)\n"),
                             testing::HasSubstr("data file: ml.raw\n")));
  const std::string raw = read_file(folder / "ml.raw");
  ASSERT_EQ(raw.size(), 5u * 5 * 5 * sizeof(float));
  for (std::size_t i = 0; i < 125; ++i) {
    float sample = 0;
    std::memcpy(&sample, raw.data() + i * sizeof sample, sizeof sample);
    const auto at = [](std::size_t step) { return -1 + 0.5 * static_cast<double>(step); };
    EXPECT_EQ(sample, static_cast<float>(recipes::marschner_lobb({at(i % 5), at(i / 5 % 5), at(i / 25)})));
  }
}

TEST(MarschnerLobb, is_rounded_to_bytes) {
  const TemporaryFolder folder;
  recipes::write_marschner_lobb(folder / "ml.nhdr", {.size = 3, .as_bytes = true});
  const std::string raw = read_file(folder / "ml.raw");
  ASSERT_EQ(raw.size(), 27u);
  EXPECT_EQ(static_cast<unsigned char>(raw[13]), 153);  // 0.6 * 255
  EXPECT_EQ(static_cast<unsigned char>(raw[4]), 255);
  EXPECT_EQ(static_cast<unsigned char>(raw[22]), 51);
}

TEST(MarschnerLobb, leaves_files_that_exist_alone) {
  const TemporaryFolder folder;
  write_file(folder / "ml.raw", "mine");
  EXPECT_THROW(recipes::write_marschner_lobb(folder / "ml.nhdr", {.size = 3}), Error);
  EXPECT_EQ(read_file(folder / "ml.raw"), "mine");
  EXPECT_FALSE(std::filesystem::exists(folder / "ml.nhdr"));
  recipes::write_marschner_lobb(folder / "ml.nhdr", {.size = 3, .replace_existing = true});
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
}

TEST(MarschnerLobb, refuses_names_and_sizes_without_sense) {
  const TemporaryFolder folder;
  EXPECT_THROW(recipes::write_marschner_lobb(folder / "ml.nrrd", {.size = 3}), Error);
  EXPECT_THROW(recipes::write_marschner_lobb(folder / "ml.nhdr", {.size = 1}), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace rhoray::tests

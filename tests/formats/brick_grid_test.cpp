#include "formats/brick_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/expect_error.h"
#include "tests/support/packed_samples.h"
#include "tests/support/resealed.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::formats {
namespace {

using tests::expect_error;
using tests::TemporaryFolder;

template <class T>
T hash_value(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<T>((i * 31 + j * 57 + k * 101) % 113);
}

template <class T>
class BrickGridOf : public testing::Test {};
using GridTypes =
    testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, float, double>;
TYPED_TEST_SUITE(BrickGridOf, GridTypes);

TYPED_TEST(BrickGridOf, samples_come_back_at_their_addresses_in_both_layouts) {
  const Index3 size(9, 14, 6);
  for (const BrickLayout& layout : {BrickLayout::linear(size), BrickLayout::bricked(size)}) {
    const TemporaryFolder folder;
    const BrickGrid grid = packed(tests::sample_grid<TypeParam>(layout, hash_value<TypeParam>), folder / "g.rho");
    const std::span<const TypeParam> samples = grid.samples<TypeParam>();
    for (int k = 0; k < size.z; ++k)
      for (int j = 0; j < size.y; ++j)
        for (int i = 0; i < size.x; ++i)
          ASSERT_EQ(samples[grid.tables().address(i, j, k)], hash_value<TypeParam>(i, j, k));
    EXPECT_EQ(grid.macro_levels<TypeParam>().range(2, 0, 0, 0).contains(hash_value<TypeParam>(1, 1, 1)), true);
    EXPECT_THAT(deep_findings(grid), testing::IsEmpty());
  }
}

TEST(BrickGrid, description_comes_back_to_the_last_bit) {
  auto sample = tests::sample_grid<float>(BrickLayout::bricked({5, 6, 7}), hash_value<float>);
  GridDescription& d = sample.description;
  d.world_from_grid = {
      {0.1, 1.0 / 3, -0.0}, {-2e-300, 0.7, 1e-17}, {0, 5e-324, -1234567.89012345678}, {1e200, -0.1, 3}};
  d.length_unit = "\xc2\xb5m";
  d.space = Space::lps;
  d.fields[0].name = "a \"quoted\" name\\";
  d.fields[0].unit = "HU";
  d.fields[0].range = {-0.1, 1.7976931348623157e308};
  d.fields[0].no_data_count = 3;
  d.fields[0].histogram = {1, 2, 18446744073709551615U};
  d.provenance = {"head.nrrd", "0123abcd", "rhoray pack head.nrrd -o 'a b.rho'"};
  const TemporaryFolder folder;
  const GridDescription back = packed(sample, folder / "g.rho").description();
  EXPECT_EQ(back.layout, d.layout);
  EXPECT_EQ(back.world_from_grid, d.world_from_grid);
  EXPECT_TRUE(std::signbit(back.world_from_grid.x_axis.z));
  EXPECT_EQ(back.length_unit, d.length_unit);
  EXPECT_EQ(back.space, Space::lps);
  EXPECT_EQ(back.fields[0].name, d.fields[0].name);
  EXPECT_EQ(back.fields[0].unit, d.fields[0].unit);
  EXPECT_EQ(back.fields[0].type, ElementType::F32);
  EXPECT_EQ(back.fields[0].range, d.fields[0].range);
  EXPECT_EQ(back.fields[0].no_data_count, 3U);
  EXPECT_EQ(back.fields[0].histogram, d.fields[0].histogram);
  EXPECT_EQ(back.macro, d.macro);
  EXPECT_EQ(back.provenance.source_name, d.provenance.source_name);
  EXPECT_EQ(back.provenance.source_checksum, d.provenance.source_checksum);
  EXPECT_EQ(back.provenance.command, d.provenance.command);
}

TEST(BrickGrid, numbers_that_are_not_finite_do_not_get_into_the_description) {
  auto sample = tests::sample_grid<float>(BrickLayout::linear({2, 2, 2}), hash_value<float>);
  sample.description.world_from_grid.origin.y = std::numeric_limits<double>::quiet_NaN();
  expect_error(ErrorCode::invalid, "world_from_grid: found nan", [&] { describe(sample.description); });
  sample.description.world_from_grid.origin.y = 0;
  sample.description.fields[0].range.hi = std::numeric_limits<double>::infinity();
  expect_error(ErrorCode::invalid, "range of field 'density': found inf", [&] { describe(sample.description); });
  sample.description.fields[0].range = {};
  EXPECT_THAT(describe(sample.description).details, testing::HasSubstr(R"("range":null)"));
}

TEST(BrickGrid, a_file_of_another_kind_is_refused_by_its_kind) {
  const TemporaryFolder folder;
  PackedFileWriter(folder / "t.rho", {.kind = "tets"}, {}).commit();
  expect_error(ErrorCode::invalid, "found 'tets'; expected 'grid'",
               [&] { BrickGrid(PackedFile::open(folder / "t.rho")); });
}

TEST(BrickGrid, cells_that_touch_a_sample_without_data_are_absent_from_the_levels) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const TemporaryFolder folder;
  const auto sample = tests::sample_grid<float>(
      BrickLayout::bricked({9, 5, 5}),
      [&](std::int64_t i, std::int64_t j, std::int64_t k) { return i == 1 ? nan : hash_value<float>(i, j, k); },
      {.factor = 2, .level_count = 2});
  const BrickGrid grid = packed(sample, folder / "g.rho");
  EXPECT_EQ(grid.description().fields[0].no_data_count, 25U);
  EXPECT_TRUE(grid.macro_levels<float>().range(1, 0, 0, 0).is_empty()) << "its leaf cells 0 and 1 both touch sample 1";
  EXPECT_FALSE(grid.macro_levels<float>().range(1, 1, 0, 0).is_empty());
  EXPECT_THAT(deep_findings(grid), testing::IsEmpty());
}

// ---- deep findings ------------------------------------------------------------------------------

using Sample = tests::GridSample<std::int16_t>;

std::vector<std::string> findings_after(const std::function<void(Sample&)>& spoil) {
  Sample sample = tests::sample_grid<std::int16_t>(BrickLayout::bricked({9, 10, 11}), hash_value<std::int16_t>);
  spoil(sample);
  const TemporaryFolder folder;
  return deep_findings(packed(sample, folder / "g.rho"));
}

TEST(BrickGridDeepFindings, name_each_kind_of_lie) {
  using testing::ElementsAre, testing::HasSubstr;
  EXPECT_THAT(findings_after([](Sample&) {}), testing::IsEmpty());
  EXPECT_THAT(findings_after([](Sample& s) { ++s.levels[0][2]; }),
              ElementsAre(HasSubstr("lacks a value of its macrocell: (1, 0, 0) of level 1 has [")));
  EXPECT_THAT(findings_after([](Sample& s) { --s.levels[1][1]; }),
              ElementsAre(HasSubstr("does not match the level below: (0, 0, 0) of level 2")));
  EXPECT_THAT(findings_after([](Sample& s) { s.description.fields[0].range.hi += 1; }),
              testing::Contains(HasSubstr("the range of field 'density' is wrong: the values give [0, 112]")));
  EXPECT_THAT(findings_after([](Sample& s) { s.description.fields[0].no_data_count = 4; }),
              ElementsAre(HasSubstr("the count without data of field 'density' is wrong: the values give 0")));
  EXPECT_THAT(findings_after([](Sample& s) { s.description.fields[0].histogram[3] += 500; }),
              ElementsAre(HasSubstr("the histogram of field"), HasSubstr("the histogram's sum")));
  EXPECT_THAT(findings_after([](Sample& s) {
                const AxisTables tables(s.description.layout);
                ++s.samples[tables.address(9, 0, 0)];
              }),
              ElementsAre(HasSubstr("padding that is no copy of the last sample: sample (9, 0, 0)")));
  EXPECT_THAT(findings_after([](Sample& s) {
                for (std::size_t i = 0; i < s.levels[0].size(); i += 2) std::swap(s.levels[0][i], s.levels[0][i + 1]);
              }),
              testing::Contains(HasSubstr(" in all)")));
}

}  // namespace
}  // namespace rhoray::formats

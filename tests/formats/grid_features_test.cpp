#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/expect_error.h"
#include "tests/support/made_grid.h"
#include "tests/support/resealed.h"

// Features of grids since version 1.1: positions along axes, bricks that are not stored, several
// fields, certificates.
namespace rhoray::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using tests::expect_error;
using tests::made_grid;
using tests::MadeField;
using tests::MadeGrid;
using tests::opened;
using tests::with_header_change;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

float ramp(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<float>(i + 10 * j + 100 * k);
}
/// No data in the first four layers of i, nor in one other sample.
float half(std::int64_t i, std::int64_t j, std::int64_t k) {
  return i < 4 || (i == 6 && j == 2 && k == 1) ? nan : ramp(i, j, k);
}
float nothing(std::int64_t, std::int64_t, std::int64_t) {
  return nan;
}

const std::array<std::vector<double>, 3> two_tables{{{-1, 0, 0.5, 0.5625, 2, 3, 4, 5, 1000}, {}, {0, 1e-3, 1, 2, 3}}};

MadeGrid rectilinear() {
  return made_grid({.axes = two_tables}, {{"density", ramp}});
}
MadeGrid sparse() {
  return made_grid({.is_sparse = true}, {{"density", half}});
}
MadeGrid certified() {
  return made_grid({}, {{"density", ramp}, {"pressure", half, true}});
}

template <class T>
void set(std::string& bytes, std::size_t element, T value) {
  std::memcpy(bytes.data() + element * sizeof(T), &value, sizeof(T));
}

/// Expects this message for a grid with one changed element.
template <class T>
void expect_refused(MadeGrid grid, const std::string& array, std::size_t element, T value, const std::string& words) {
  set(grid.arrays.at(array), element, value);
  expect_error(ErrorCode::invalid, words, [&] { opened(grid.file()); });
}

std::vector<std::string> findings_after(MadeGrid grid, const std::function<void(MadeGrid&)>& spoil) {
  spoil(grid);
  return deep_findings(opened(grid.file()));
}

TEST(GridVersion, is_the_first_that_has_all_that_a_file_uses) {
  const auto version = [](const MadeGrid& grid) { return opened(grid.file()).file().version(); };
  EXPECT_EQ(version(made_grid({}, {{"density", ramp}})), "1.0");
  for (const MadeGrid& grid : {rectilinear(), sparse(), certified()}) EXPECT_EQ(version(grid), "1.1");
}

TEST(GridVersion, what_would_be_misread_without_is_named_as_required) {
  const auto required = [](const MadeGrid& grid) { return describe(grid.description).required; };
  EXPECT_THAT(required(rectilinear()), ElementsAre("axis-tables"));
  EXPECT_THAT(required(sparse()), ElementsAre("sparse-bricks"));
  EXPECT_THAT(required(certified()), IsEmpty()) << "a reader of version 1.0 reads the first field";
}

TEST(AxisTables, come_back_and_stand_for_whole_numbers_where_there_are_none) {
  const BrickGrid grid = opened(rectilinear().file());
  EXPECT_EQ(grid.description().axes, two_tables);
  EXPECT_TRUE(grid.description().is_rectilinear());
  EXPECT_EQ(grid.description().position(0, 3), 0.5625);
  EXPECT_EQ(grid.description().position(1, 3), 3);
  EXPECT_EQ(grid.description().position(2, 1), 1e-3);
  EXPECT_THAT(deep_findings(grid), IsEmpty());
}

TEST(AxisTables, are_other_peoples_arrays_where_no_feature_names_them) {
  const std::string file = with_header_change(rectilinear().file(), R"("requires":"axis-tables")", R"("requires":"")");
  EXPECT_FALSE(opened(file).description().is_rectilinear());
}

TEST(AxisTables, that_do_not_rise_or_are_not_finite_are_refused_at_their_element) {
  constexpr double nan_position = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinite = std::numeric_limits<double>::infinity();
  expect_refused(rectilinear(), "axis.0", 2, -0.5,
                 "array 'axis.0', element 2: found -0.5; expected a finite number above 0");
  expect_refused(rectilinear(), "axis.0", 4, 0.5625, "element 4: found 0.5625; expected a finite number above 0.5625");
  expect_refused(rectilinear(), "axis.0", 0, nan_position, "element 0: found nan; expected a finite number");
  expect_refused(rectilinear(), "axis.2", 3, nan_position, "array 'axis.2', element 3: found nan");
  expect_refused(rectilinear(), "axis.2", 4, infinite, "element 4: found inf");
  MadeGrid endless = rectilinear();
  set(endless.arrays["axis.0"], 0, -1.7e308);
  set(endless.arrays["axis.0"], 8, 1.7e308);
  expect_error(ErrorCode::invalid, "expected an axis of finite length", [&] { opened(endless.file()); });
}

TEST(AxisTables, of_another_length_or_type_are_refused) {
  const std::string file = rectilinear().file();
  const auto refused = [&](const char* from, const char* to, const char* words) {
    expect_error(ErrorCode::invalid, words, [&] { opened(with_header_change(file, from, to)); });
  };
  refused(R"("axis.2")", R"("axis.1")", "array 'axis.1': found F64 [5]; expected F64 [6]");
  refused(R"("axis.0":{"dtype":"F64","shape":[9])", R"("axis.0":{"dtype":"F64","shape":[3,3])", "found F64 [3, 3]");
  refused(R"("axis.0":{"dtype":"F64")", R"("axis.0":{"dtype":"I64")", "found I64 [9]; expected F64 [9]");
}

TEST(SparseGrid, has_its_samples_where_the_slots_say_and_none_elsewhere) {
  const MadeGrid made = sparse();
  const BrickGrid grid = opened(made.file());
  const BrickLayout& layout = grid.description().layout;
  EXPECT_EQ(layout, BrickLayout::sparse({9, 6, 5}, 8, 4)) << "8 of 3 x 2 x 2 bricks hold data";
  EXPECT_THAT(layout.shape(), ElementsAre(8, 4, 4, 4));
  EXPECT_EQ(layout.brick_count(), Index3(3, 2, 2));
  const SparseAddress address(layout, grid.tables(), grid.brick_slots());
  const std::span<const float> samples = grid.samples<float>();
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 9; ++i) {
        const std::uint64_t at = address(i, j, k);
        ASSERT_EQ(at == SparseAddress::no_sample, i < 4);
        if (i < 4 || std::isnan(half(i, j, k))) continue;
        ASSERT_EQ(samples[at], half(i, j, k));
      }
  EXPECT_EQ(grid.description().fields[0].no_data_count, 4U * 6 * 5 + 1);
  EXPECT_THAT(deep_findings(grid), IsEmpty());
}

TEST(SparseGrid, may_store_no_brick_at_all) {
  const BrickGrid grid = opened(made_grid({.is_sparse = true}, {{"density", nothing}}).file());
  EXPECT_EQ(grid.description().layout.stored_brick_count, 0U);
  EXPECT_THAT(grid.samples<float>(), IsEmpty());
  EXPECT_THAT(deep_findings(grid), IsEmpty());
}

TEST(SparseGrid, with_a_table_of_slots_that_is_no_bijection_is_refused) {
  constexpr std::uint32_t none = BrickGrid::no_brick;
  // Bricks 1, 2, 4, 5, 7, 8, 10, 11 have the slots 7, 6, ..., 0.
  expect_refused<std::uint32_t>(sparse(), "bricks", 1, 8,
                                "array 'bricks', element 1: found 8; expected 4294967295 or a slot below 8");
  expect_refused<std::uint32_t>(sparse(), "bricks", 1, none - 1, "element 1: found 4294967294");
  expect_refused<std::uint32_t>(sparse(), "bricks", 5, 7,
                                "element 5: found 7; expected a slot that no other brick has");
  expect_refused<std::uint32_t>(sparse(), "bricks", 0, 7, "expected a slot that no other brick has");
  expect_refused<std::uint32_t>(sparse(), "bricks", 5, none, "found 7 bricks with a slot; expected 8 of them");
}

TEST(SparseGrid, with_a_layout_that_none_has_is_refused_by_name) {
  const std::string file = sparse().file();
  const auto refused = [&](const char* from, const char* to, const char* words) {
    expect_error(ErrorCode::invalid, words, [&] { opened(with_header_change(file, from, to)); });
  };
  refused(R"(brick_edge\":4)", R"(brick_edge\":3)", "brick_edge: found 3; expected 2, 4, 8, 16, 32 or 64");
  refused(R"(brick_edge\":4)", R"(brick_edge\":1)", "brick_edge: found 1; expected 2, 4, 8, 16, 32 or 64");
  refused(R"(brick_edge\":4)", R"(brick_edge\":2)", "array 'samples': found F32 [8, 4, 4, 4]");
  refused(R"(superbrick_edge\":[1,1,1])", R"(superbrick_edge\":[1,2,1])", "superbrick_edge: found [1,2,1]");
  refused(R"(stored_brick_count\":8)", R"(stored_brick_count\":9)", "array 'samples': found F32 [8, 4, 4, 4]");
  refused(R"(stored_brick_count\":8)", R"(stored_brick_count\":0)", "array 'samples': found 512 samples");
  refused(R"(stored_brick_count\":8)", R"(stored_brick_count\":4294967296)", "stored_brick_count: found 4294967296");
  refused(R"(stored_brick_count\")", R"(_stored_brick_count\")", "stored_brick_count: found nothing");
  refused(R"(type\":\"F32\")", R"(type\":\"I32\")", "field.type: found \"I32\"; expected F32 or F64 in a sparse grid");
  refused(R"(sample_count\":[9,6,5])", R"(sample_count\":[9,6,9])", "array 'macro.1'");
  refused(R"("bricks")", R"("mortar")", "array 'bricks': found nothing");
  refused(R"("requires":"sparse-bricks")", R"("requires":"")", "array 'samples': found F32 [8, 4, 4, 4]");
}

TEST(SparseGrid, of_a_lattice_far_longer_than_its_data_is_sound) {
  // Only the brick table and the levels take space.
  const MadeGrid made = made_grid(
      {.sample_count = {1 << 16, 2, 2}, .brick_edge = 8, .is_sparse = true, .macro = {.factor = 32, .level_count = 1}},
      {{"density", [](std::int64_t i, std::int64_t, std::int64_t) { return i < 65000 ? nan : 1.0F; }}});
  EXPECT_EQ(made.description.layout.stored_brick_count, 67U);
  EXPECT_THAT(deep_findings(opened(made.file())), IsEmpty());
}

TEST(SparseGrid, deep_findings_name_each_kind_of_lie) {
  EXPECT_THAT(findings_after(sparse(), [](MadeGrid&) {}), IsEmpty());
  // Slot 0 holds brick 11, samples (8, 4, 4) to (11, 7, 7). Of its 4 x 4 x 4 samples, only (8, 4,
  // 4) and (8, 5, 4) are inside the grid.
  EXPECT_THAT(findings_after(sparse(), [](MadeGrid& g) { set(g.arrays["samples"], 1, 7.0F); }),
              ElementsAre("padding of a sparse grid that is not NaN: sample (9, 4, 4)"));
  EXPECT_THAT(findings_after(sparse(), [](MadeGrid& g) { g.description.fields[0].no_data_count = 1; }),
              ElementsAre(HasSubstr("the count without data of field 'density' is wrong: the values give 121")));
  EXPECT_THAT(findings_after(sparse(),
                             [](MadeGrid& g) {
                               set(g.arrays["macro.1"], 0, 1.0F);
                               set(g.arrays["macro.1"], 1, 2.0F);
                             }),
              testing::Contains(HasSubstr("lacks a value of its macrocell: (0, 0, 0) of level 1 has [1, 2], its "
                                          "samples need empty")));
}

TEST(GridFields, come_back_each_with_its_own_samples_and_levels) {
  const MadeGrid made = certified();
  const BrickGrid grid = opened(made.file());
  ASSERT_EQ(grid.description().fields.size(), 2U);
  EXPECT_EQ(grid.description().fields[1].name, "pressure");
  EXPECT_EQ(grid.find_field("density"), 0U);
  EXPECT_EQ(grid.find_field("pressure"), 1U);
  EXPECT_EQ(grid.find_field("velocity"), std::nullopt);
  EXPECT_EQ(grid.samples<float>(0)[grid.tables().address(8, 5, 4)], ramp(8, 5, 4));
  EXPECT_TRUE(std::isnan(grid.samples<float>(1)[grid.tables().address(3, 5, 4)]));
  EXPECT_EQ(grid.macro_levels<float>(0).range(1, 0, 0, 0).lo, 0);
  EXPECT_EQ(grid.macro_levels<float>(1).range(1, 2, 0, 0).lo, 4);
  EXPECT_TRUE(grid.macro_levels<float>(1).range(1, 0, 0, 0).is_empty());
  EXPECT_THAT(deep_findings(grid), IsEmpty());
}

TEST(GridFields, are_named_in_findings_and_refused_when_two_share_a_name) {
  EXPECT_THAT(findings_after(certified(), [](MadeGrid& g) { set(g.arrays["field.1.macro.1"], 4, 999.0F); }),
              ElementsAre(HasSubstr("an interval of field 'pressure' that lacks a value")));
  EXPECT_THAT(findings_after(certified(), [](MadeGrid& g) { set(g.arrays["field.1.macro.1"], 5, 999.0F); }),
              ElementsAre(HasSubstr("macro levels of field 'pressure': a macrocell does not match")));
  const std::string file = certified().file();
  expect_error(ErrorCode::invalid, "more_fields[0].name: found \"density\"; expected a name that no other field has",
               [&] { opened(with_header_change(file, R"(name\":\"pressure\")", R"(name\":\"density\")")); });
  expect_error(ErrorCode::invalid, "array 'field.1.samples': found nothing",
               [&] { opened(with_header_change(file, R"("field.1.samples")", R"("field.2.samples")")); });
  expect_error(ErrorCode::invalid, "more_fields: found 7; expected a list of objects",
               [&] { opened(with_header_change(file, R"(more_fields\":[)", R"(more_fields\":7,\"m\":[)")); });
}

TEST(Certificate, comes_back_with_the_errors_of_every_brick) {
  const MadeGrid made = certified();
  const BrickGrid grid = opened(made.file());
  EXPECT_EQ(grid.description().certificates, made.description.certificates);
  EXPECT_FALSE(grid.description().certificates.contains(0));
  const std::span<const float> largest = grid.errors<float>(1, "max");
  EXPECT_EQ(largest.size(), 12U);
  EXPECT_EQ(largest[1], 0.5F);
  EXPECT_EQ(grid.errors<float>(1, "rms")[0], 0.0625F);
}

TEST(Certificate, tells_since_1_5_how_much_is_covered_and_what_was_asked_for) {
  MadeGrid made = certified();
  EXPECT_TRUE(made.description.certificates[1].meets_request()) << "nothing was asked for";
  made.description.certificates[1].coverage = 0.25;
  made.description.certificates[1].requested_error = 0.5;
  const BrickGrid grid = opened(made.file());
  EXPECT_EQ(grid.file().version(), "1.5");
  EXPECT_EQ(grid.description().certificates, made.description.certificates);
  EXPECT_FALSE(grid.description().certificates.at(1).meets_request()) << "the error is reached in a quarter";
  made.description.certificates[1].coverage = 1;
  EXPECT_TRUE(made.description.certificates[1].meets_request());
  made.description.certificates[1].requested_error = 0.49;
  EXPECT_FALSE(made.description.certificates[1].meets_request());
  const std::string file = made.file();
  expect_error(ErrorCode::invalid, "certificate.coverage: found 1.5; expected 0 to 1",
               [&] { opened(with_header_change(file, R"(coverage\":1.0)", R"(coverage\":1.5)")); });
  expect_error(ErrorCode::invalid, "certificate.requested_error: found -0.49",
               [&] { opened(with_header_change(file, R"(requested_error\":0.49)", R"(requested_error\":-0.49)")); });
}

TEST(Certificate, of_another_shape_or_out_of_its_limits_is_refused) {
  const std::string file = certified().file();
  const auto refused = [&](const char* from, const char* to, const char* words) {
    expect_error(ErrorCode::invalid, words, [&] { opened(with_header_change(file, from, to)); });
  };
  refused(R"("error.1.rms")", R"("error.0.rms")", "array 'error.1.rms': found nothing");
  refused(R"("error.1.max":{"dtype":"F32","shape":[2,2,3])", R"("error.1.max":{"dtype":"F32","shape":[3,2,2])",
          "array 'error.1.max': found F32 [3, 2, 2]; expected F32 [2, 2, 3]");
  refused(R"(max_error\":0.5)", R"(max_error\":-0.5)", "certificate.max_error: found -0.5");
  refused(R"(rms_error\":0.1)", R"(rms_error\":null)", "certificate.rms_error: found null");
  refused(R"(point_count\":12345)", R"(point_count\":1.5)", "certificate.point_count: found 1.5");
  refused(R"(certificate\":{\"type\":\"F32\")", R"(certificate\":{\"type\":\"U8\")", "certificate.type: found \"U8\"");
  refused(R"(certificate\":{)", R"(certificate\":7,\"c\":{)", "certificate: found 7; expected an object");
}

TEST(Certificate, deep_findings_name_errors_that_cannot_be) {
  const auto after = [](const char* array, std::size_t brick, float value) {
    return findings_after(certified(), [&](MadeGrid& g) { set(g.arrays[array], brick, value); });
  };
  EXPECT_THAT(after("error.1.rms", 5, -1),
              ElementsAre("an error of field 'pressure' that is negative or not finite: brick (2, 1, 0) has max 0.25, "
                          "rms -1"));
  EXPECT_THAT(after("error.1.max", 5, nan), ElementsAre(HasSubstr("negative or not finite: brick (2, 1, 0)")));
  EXPECT_THAT(after("error.1.rms", 0, 0.375F),
              ElementsAre(HasSubstr("a mean error of field 'pressure' above the largest: brick (0, 0, 0)")));
  EXPECT_THAT(after("error.1.max", 1, 0.375F),
              ElementsAre(HasSubstr("the largest error of field 'pressure' is wrong: its bricks give 0.375, the file "
                                    "says 0.5")));
  EXPECT_THAT(findings_after(certified(), [](MadeGrid& g) { g.description.certificates[1].rms_error = 0.25; }),
              ElementsAre(HasSubstr("the mean error of field 'pressure' is wrong")));
}

}  // namespace
}  // namespace rhoray::formats

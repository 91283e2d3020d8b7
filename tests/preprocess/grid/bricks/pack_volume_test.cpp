#include "preprocess/pack_volume.h"
#include "formats/base/parallel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "formats/base/error.h"
#include "tests/support/fields.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using formats::BrickGrid;
using formats::ElementType;
using formats::PackedFile;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using tests::TemporaryFolder;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

/// Values over the whole range of the type.
template <class T>
NeutralVolume random_volume(const Index3& count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return tests::volume_of<T>(count, [&](const Index3&) {
    if constexpr (std::is_integral_v<T>)
      return static_cast<T>(random());
    else
      return static_cast<T>(std::ldexp(static_cast<double>(random()), -50) - 8000);
  });
}

template <class T>
T source_sample(const NeutralVolume& volume, std::int64_t i, std::int64_t j, std::int64_t k) {
  T value;
  const auto at = static_cast<std::size_t>((k * volume.sample_count.y + j) * volume.sample_count.x + i);
  std::memcpy(&value, volume.samples.data() + at * sizeof(T), sizeof(T));
  return value;
}

/// Every sample that a reader finds has the bits of the source's.
template <class T>
void expect_same_samples(const BrickGrid& grid, const NeutralVolume& volume) {
  const std::span<const T> samples = grid.samples<T>();
  const Index3 n = volume.sample_count;
  std::int64_t different = 0;
  for (std::int64_t k = 0; k < n.z; ++k)
    for (std::int64_t j = 0; j < n.y; ++j)
      for (std::int64_t i = 0; i < n.x; ++i) {
        const T expected = source_sample<T>(volume, i, j, k);
        different += std::memcmp(&samples[grid.tables().address(i, j, k)], &expected, sizeof(T)) != 0;
      }
  EXPECT_EQ(different, 0);
}

/// The levels against a loop over leaf cells, straight from the definition.
template <class T>
void expect_true_levels(const BrickGrid& grid, const NeutralVolume& volume) {
  const auto levels = grid.macro_levels<T>();
  const formats::MacroShape& shape = levels.shape;
  for (int level = 1; level <= shape.level_count; ++level) {
    std::vector<Interval<T>> expected(static_cast<std::size_t>(rhoray::volume(shape.count(level))));
    const Index3 count = shape.count(level);
    for (std::int64_t k = 0; k < shape.leaf_count.z; ++k)
      for (std::int64_t j = 0; j < shape.leaf_count.y; ++j)
        for (std::int64_t i = 0; i < shape.leaf_count.x; ++i) {
          Interval<T> cell;
          bool is_absent = false;
          for (int c = 0; c < 8; ++c) {
            const T value = source_sample<T>(volume, i + (c & 1), j + (c / 2 & 1), k + c / 4);
            is_absent = is_absent || !std::isfinite(static_cast<double>(value));
            cell.include(value);
          }
          const std::int64_t edge = shape.cell_edge(level);
          if (!is_absent)
            expected[static_cast<std::size_t>((k / edge * count.y + j / edge) * count.x + i / edge)].include(cell);
        }
    std::int64_t different = 0;
    for (std::int64_t k = 0; k < count.z; ++k)
      for (std::int64_t j = 0; j < count.y; ++j)
        for (std::int64_t i = 0; i < count.x; ++i) {
          const Interval<T>& wanted = expected[static_cast<std::size_t>((k * count.y + j) * count.x + i)];
          const Interval<T> found = levels.range(level, i, j, k);
          different += wanted.is_empty() ? !found.is_empty() : found != wanted;
        }
    EXPECT_EQ(different, 0) << "level " << level;
  }
}

template <class T>
formats::GridDescription expect_faithful(const NeutralVolume& volume, const PackVolumeOptions& options = {}) {
  const TemporaryFolder folder;
  const PackVolumeReport report = pack_volume(volume, folder / "v.rho", options);
  EXPECT_EQ(report.file_bytes, std::filesystem::file_size(folder / "v.rho"));
  const BrickGrid grid(PackedFile::open(folder / "v.rho"));
  expect_same_samples<T>(grid, volume);
  expect_true_levels<T>(grid, volume);
  EXPECT_THAT(formats::deep_findings(grid), IsEmpty());
  EXPECT_THAT(grid.file().damaged_blocks(), IsEmpty());
  EXPECT_EQ(grid.description().layout, report.description.layout);
  return grid.description();
}

Error refusal(const NeutralVolume& volume, const PackVolumeOptions& options = {}) {
  const TemporaryFolder folder;
  try {
    pack_volume(volume, folder / "v.rho", options);
  } catch (const Error& error) {
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "something was left behind";
    return error;
  }
  return Error(ErrorCode::internal, "accepted");
}

template <class T>
class PackVolumeOf : public ::testing::Test {};
using StoredTypes = ::testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t,
                                     std::int32_t, float, double>;
TYPED_TEST_SUITE(PackVolumeOf, StoredTypes);

TYPED_TEST(PackVolumeOf, this_type_keeps_every_sample_in_bricks_and_in_the_linear_order) {
  for (const Index3& count : {Index3(2, 2, 2), Index3(3, 5, 7), Index3(65, 33, 17)})
    for (const SampleOrder order : {SampleOrder::bricks, SampleOrder::linear})
      expect_faithful<TypeParam>(random_volume<TypeParam>(count, 5), {.order = order});
}

TEST(PackVolume, keeps_every_sample_for_any_edge_of_bricks_and_any_hierarchy) {
  const auto volume = random_volume<std::uint16_t>({37, 18, 21}, 6);
  for (const std::int64_t edge : {2, 3, 4, 7, 8, 64}) expect_faithful<std::uint16_t>(volume, {.brick_edge = edge});
  for (const std::int64_t superbrick : {1, 3, 64})
    expect_faithful<std::uint16_t>(volume, {.largest_superbrick = superbrick});
  for (const std::int64_t factor : {2, 3, 5, 32})
    for (const int levels : {1, 2, 5})
      expect_faithful<std::uint16_t>(volume, {.macro_factor = factor, .macro_level_count = levels});
}

TEST(PackVolume, keeps_more_samples_than_one_piece_of_work_holds) {
  expect_faithful<float>(random_volume<float>({130, 121, 97}, 7));
  expect_faithful<float>(random_volume<float>({130, 121, 97}, 7), {.order = SampleOrder::linear});
}

TEST(PackVolume, has_absent_cells_where_samples_lack_data_and_intervals_without_them) {
  const auto lacks_data = [](const Index3& p) { return p.x >= 8 && p.x < 21 && p.y >= 3 && p.z >= 4 && p.z < 17; };
  const auto volume = tests::volume_of<float>({40, 22, 30}, [&](const Index3& p) {
    if (p == Index3(1, 1, 1)) return infinity;
    if (p == Index3(39, 21, 29)) return -infinity;
    return lacks_data(p) ? nan : static_cast<float>(p.x + 100 * p.y - 50 * p.z);
  });
  const auto grid = expect_faithful<float>(volume);
  EXPECT_EQ(grid.fields[0].no_data_count, 13u * 19 * 13 + 2);
  EXPECT_EQ(grid.fields[0].range, (Interval<double>{-1450, 2139}));
}

TEST(PackVolume, packs_a_volume_without_any_data_with_empty_range_and_intervals) {
  const auto grid =
      expect_faithful<double>(tests::volume_of<double>({9, 9, 9}, [](const Index3&) { return double{nan}; }));
  EXPECT_TRUE(grid.fields[0].range.is_empty());
  EXPECT_EQ(grid.fields[0].no_data_count, 729u);
  EXPECT_THAT(grid.fields[0].histogram, IsEmpty());
}

TEST(PackVolume, packs_a_constant_volume_with_one_bin) {
  const auto whole = expect_faithful<std::int16_t>(
      tests::volume_of<std::int16_t>({9, 8, 7}, [](const Index3&) { return std::int16_t{-3}; }));
  EXPECT_EQ(whole.fields[0].range, (Interval<double>{-3, -3}));
  EXPECT_THAT(whole.fields[0].histogram, ::testing::ElementsAre(504));
  const auto real = expect_faithful<float>(tests::volume_of<float>({9, 8, 7}, [](const Index3&) { return 0.1f; }));
  EXPECT_THAT(real.fields[0].histogram, ::testing::ElementsAre(504));
}

TEST(PackVolume, takes_the_whole_range_of_16_bit_and_of_double) {
  const auto whole = tests::volume_of<std::int16_t>(
      {4, 4, 4}, [](const Index3& p) { return static_cast<std::int16_t>(p.x % 2 ? 32767 : -32768); });
  EXPECT_EQ(expect_faithful<std::int16_t>(whole).fields[0].range, (Interval<double>{-32768, 32767}));
  constexpr double largest = std::numeric_limits<double>::max();
  const auto real = tests::volume_of<double>({4, 4, 4}, [](const Index3& p) { return p.x % 2 ? largest : -largest; });
  const auto field = expect_faithful<double>(real).fields[0];
  EXPECT_EQ(field.range, (Interval<double>{-largest, largest}));
  EXPECT_EQ(field.histogram.front(), 32u);
  EXPECT_EQ(field.histogram.back(), 32u);
}

TEST(PackVolume, gives_each_integer_of_a_small_range_a_bin_of_its_own) {
  const auto volume =
      tests::volume_of<std::int16_t>({10, 10, 10}, [](const Index3& p) { return static_cast<std::int16_t>(p.x - 4); });
  EXPECT_EQ(expect_faithful<std::int16_t>(volume).fields[0].histogram, std::vector<std::uint64_t>(10, 100));
  const auto bytes = tests::volume_of<std::uint8_t>(
      {16, 16, 2}, [](const Index3& p) { return static_cast<std::uint8_t>(16 * p.y + p.x); });
  EXPECT_EQ(expect_faithful<std::uint8_t>(bytes).fields[0].histogram, std::vector<std::uint64_t>(256, 2));
}

TEST(PackVolume, makes_a_histogram_from_which_otsu_parts_two_classes) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> low(200, 20), high(1100, 60);
  const auto value = [&](const Index3& p) { return p.x < 16 ? low(random) : high(random); };
  const auto whole = tests::volume_of<std::uint16_t>(
      {32, 32, 32}, [&](const Index3& p) { return static_cast<std::uint16_t>(value(p)); });
  const auto real =
      tests::volume_of<float>({32, 32, 32}, [&](const Index3& p) { return static_cast<float>(value(p)); });
  for (const auto& field : {expect_faithful<std::uint16_t>(whole).fields[0], expect_faithful<float>(real).fields[0]}) {
    EXPECT_EQ(field.histogram.size(), 256u);
    EXPECT_EQ(std::accumulate(field.histogram.begin(), field.histogram.end(), std::uint64_t{0}), 32u * 32 * 32);
    EXPECT_NEAR(formats::otsu_threshold(field).value_or(0), 650, 250);
  }
}

TEST(PackVolume, keeps_frame_units_and_names) {
  auto volume = random_volume<std::uint8_t>({4, 5, 6}, 8);
  volume.world_from_grid = {{0, 0, -2}, {0.5, 0, 0}, {0, 3, 0.1}, {1, 2, 3}};  // rotated, mirrored, sheared
  volume.length_unit = "mm";
  volume.field_name = "density";
  volume.field_unit = "HU";
  const auto grid = expect_faithful<std::uint8_t>(volume, {.command = "rhoray pack x", .source_name = "x.nrrd"});
  EXPECT_EQ(grid.world_from_grid, volume.world_from_grid);
  EXPECT_EQ(grid.length_unit, "mm");
  EXPECT_EQ(grid.fields[0].name, "density");
  EXPECT_EQ(grid.fields[0].unit, "HU");
  EXPECT_EQ(grid.provenance.command, "rhoray pack x");
  EXPECT_EQ(grid.provenance.source_name, "x.nrrd");
}

TEST(PackVolume, gives_a_field_without_name_one) {
  auto volume = random_volume<std::uint8_t>({2, 2, 2}, 8);
  volume.field_name.clear();
  EXPECT_EQ(expect_faithful<std::uint8_t>(volume).fields[0].name, "value");
}

TEST(PackVolume, writes_the_same_bytes_on_any_number_of_threads) {
  const TemporaryFolder folder;
  auto volume = random_volume<float>({97, 83, 71}, 9);
  float* const samples = reinterpret_cast<float*>(volume.owned_samples.data());
  samples[1000] = nan;
  std::vector<std::string> files;
  for (const unsigned threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    pack_volume(volume, folder / "v.rho", {.replace_existing = true});
    files.push_back(tests::read_file(folder / "v.rho"));
  }
  EXPECT_TRUE(files[0] == files[1]);
  EXPECT_TRUE(files[0] == files[2]);
}

TEST(PackVolume, stores_another_type_where_every_value_survives) {
  const TemporaryFolder folder;
  const auto count = Index3(5, 6, 7);
  const auto value = [](const Index3& p) { return static_cast<double>(p.x + 10 * p.y - 40); };
  const auto source = tests::volume_of<double>(count, value);
  const auto expect_values = [&]<class T>(T, ElementType type) {
    pack_volume(source, folder / "v.rho", {.type = type, .replace_existing = true});
    const BrickGrid grid(PackedFile::open(folder / "v.rho"));
    expect_same_samples<T>(grid, tests::volume_of<T>(count, [&](const Index3& p) { return static_cast<T>(value(p)); }));
  };
  expect_values(std::int8_t{}, ElementType::I8);
  expect_values(std::int16_t{}, ElementType::I16);
  expect_values(std::int32_t{}, ElementType::I32);
  expect_values(float{}, ElementType::F32);
  EXPECT_THAT(refusal(source, {.type = ElementType::U8}).what(),
              HasSubstr("sample (0, 0, 0): found -40; expected a number that U8 holds"));
}

TEST(PackVolume, refuses_a_type_that_changes_a_value_and_names_the_first_sample) {
  const auto one_value = [](auto value) {
    return tests::volume_of<decltype(value)>(
        {4, 4, 4}, [=](const Index3& p) { return p == Index3(3, 2, 1) ? value : decltype(value){1}; });
  };
  const auto expect_refused = [](const NeutralVolume& volume, ElementType type) {
    const Error error = refusal(volume, {.type = type});
    EXPECT_EQ(error.code(), ErrorCode::invalid);
    EXPECT_THAT(error.what(), HasSubstr("sample (3, 2, 1): found "));
  };
  expect_refused(one_value(0.5), ElementType::I32);
  expect_refused(one_value(0.1), ElementType::F32);
  expect_refused(one_value(1e39), ElementType::F32);
  expect_refused(one_value(nan), ElementType::U16);
  expect_refused(one_value(infinity), ElementType::I32);
  expect_refused(one_value(2147483648.0), ElementType::I32);
  expect_refused(one_value(std::int32_t{16777217}), ElementType::F32);
  expect_refused(one_value(std::uint16_t{256}), ElementType::U8);
  expect_refused(one_value(std::int16_t{-1}), ElementType::U32);
  EXPECT_EQ(refusal(one_value(nan), {.type = ElementType::F64}).code(), ErrorCode::internal) << "NaN stays NaN";
  EXPECT_EQ(refusal(one_value(-2147483648.0), {.type = ElementType::I32}).code(), ErrorCode::internal);
}

TEST(PackVolume, stores_64_bit_integers_as_doubles_where_these_hold_them) {
  const TemporaryFolder folder;
  const auto volume =
      tests::volume_of<std::int64_t>({3, 3, 3}, [](const Index3& p) { return (std::int64_t{1} << 60) - 512 * p.x; });
  pack_volume(volume, folder / "v.rho");
  const BrickGrid grid(PackedFile::open(folder / "v.rho"));
  expect_same_samples<double>(grid, tests::volume_of<double>({3, 3, 3}, [](const Index3& p) {
                                return 0x1p60 - 512.0 * static_cast<double>(p.x);
                              }));

  const auto odd =
      tests::volume_of<std::uint64_t>({3, 3, 3}, [](const Index3& p) { return p.z == 2 ? ~std::uint64_t{0} : 7; });
  EXPECT_THAT(refusal(odd).what(),
              HasSubstr("sample (0, 0, 2): found 18446744073709551615; expected a number that F64 holds"));
  EXPECT_EQ(refusal(volume, {.type = ElementType::I64}).code(), ErrorCode::usage);
}

TEST(PackVolume, reads_samples_that_do_not_start_at_a_multiple_of_their_size) {
  const auto source = random_volume<std::uint32_t>({7, 6, 5}, 10);
  std::vector<std::byte> shifted(source.samples.size() + 1);
  std::copy(source.samples.begin(), source.samples.end(), shifted.begin() + 1);
  auto volume = random_volume<std::uint32_t>({7, 6, 5}, 11);
  volume.samples = std::span<const std::byte>(shifted).subspan(1);
  expect_faithful<std::uint32_t>(volume);
}

TEST(PackVolume, refuses_what_is_no_volume) {
  auto thin = random_volume<std::uint8_t>({5, 1, 5}, 1);
  EXPECT_THAT(refusal(thin, {.source_name = "slice.nrrd"}).what(),
              HasSubstr("slice.nrrd: found 5 x 1 x 5 samples; expected 2 to"));
  auto cut = random_volume<std::uint16_t>({5, 5, 5}, 1);
  cut.samples = cut.samples.first(249);
  EXPECT_THAT(refusal(cut).what(), HasSubstr("found 249 bytes of samples; expected 5 x 5 x 5 of U16"));
  auto huge = random_volume<std::uint8_t>({2, 2, 2}, 1);
  huge.sample_count = {1 << 20, 1 << 20, 1 << 24};
  EXPECT_EQ(refusal(huge).code(), ErrorCode::invalid);
  auto flat = random_volume<std::uint8_t>({5, 5, 5}, 1);
  flat.world_from_grid.z_axis = {2, 0, 0};
  EXPECT_THAT(refusal(flat).what(), HasSubstr("found grid axes that span a volume of 0"));
  flat.world_from_grid.z_axis = {0, 0, 1e-320};
  EXPECT_THAT(refusal(flat).what(), HasSubstr("not too small to be inverted"));
  flat.world_from_grid.z_axis = {0, 0, double{nan}};
  EXPECT_EQ(refusal(flat).code(), ErrorCode::invalid);
}

TEST(PackVolume, refuses_options_that_make_no_sense) {
  const auto volume = random_volume<std::uint8_t>({5, 5, 5}, 1);
  for (const std::int64_t edge : {-1, 0, 1, 65})
    EXPECT_EQ(refusal(volume, {.brick_edge = edge}).code(), ErrorCode::usage);
  for (const std::int64_t superbrick : {-1, 0, 65})
    EXPECT_EQ(refusal(volume, {.largest_superbrick = superbrick}).code(), ErrorCode::usage);
  for (const std::int64_t factor : {0, 1, 33})
    EXPECT_EQ(refusal(volume, {.macro_factor = factor}).code(), ErrorCode::usage);
  for (const int levels : {-1, 0, 13})
    EXPECT_EQ(refusal(volume, {.macro_level_count = levels}).code(), ErrorCode::usage);
}

TEST(PackVolume, leaves_an_existing_file_alone_unless_told) {
  const TemporaryFolder folder;
  const auto volume = random_volume<std::uint8_t>({5, 5, 5}, 1);
  tests::write_file(folder / "v.rho", "precious");
  EXPECT_THROW(pack_volume(volume, folder / "v.rho"), Error);
  EXPECT_EQ(tests::read_file(folder / "v.rho"), "precious");
  pack_volume(volume, folder / "v.rho", {.replace_existing = true});
  EXPECT_TRUE(PackedFile::looks_packed(folder / "v.rho"));
}

TEST(PackVolume, reports_progress_that_only_grows_and_can_be_stopped_by_it) {
  const TemporaryFolder folder;
  const auto volume = random_volume<float>({130, 121, 97}, 7);
  std::string phase;
  std::uint64_t last = 0, total = 0;
  std::vector<std::string> phases;
  pack_volume(volume, folder / "v.rho", {}, [&](std::string_view of, std::uint64_t done, std::uint64_t all) {
    if (phase != of) {
      EXPECT_EQ(last, total) << phase << " did not end";
      phases.emplace_back(phase = of);
      last = 0;
    }
    EXPECT_GE(done, last);
    EXPECT_LE(done, all);
    last = done;
    total = all;
  });
  EXPECT_THAT(phases, ::testing::ElementsAre("finding value ranges (values)", "making the histogram (values)",
                                             "finding ranges of macrocells (macrocells)", "writing samples (bytes)",
                                             "sealing"));

  struct Stopped {};
  const auto stop = [](std::string_view of, std::uint64_t done, std::uint64_t all) {
    if (of == "writing samples (bytes)" && done > all / 3) throw Stopped();
  };
  std::filesystem::remove(folder / "v.rho");
  EXPECT_THROW(pack_volume(volume, folder / "v.rho", {}, stop), Stopped);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(PackVolume, adds_at_most_a_tenth_to_the_raw_bytes_of_a_volume_of_common_size) {
  const TemporaryFolder folder;
  for (const Index3& count : {Index3(128, 128, 69), Index3(103, 94, 161), Index3(130, 130, 68)}) {
    const auto volume = random_volume<std::uint16_t>(count, 2);
    const auto report = pack_volume(volume, folder / "v.rho", {.replace_existing = true});
    EXPECT_LT(static_cast<double>(report.file_bytes) / static_cast<double>(volume.samples.size()), 1.1);
  }
}

// ---- several fields, positions along axes, bricks with data -------------------------------------

TEST(PackGrid, keeps_every_sample_of_every_field) {
  std::vector<NeutralVolume> fields;
  fields.reserve(2);
  fields.push_back(random_volume<std::uint16_t>({17, 9, 12}, 31));
  fields.push_back(random_volume<double>({17, 9, 12}, 32));
  fields[0].field_name = "density";
  fields[1].field_unit = "Pa";
  const TemporaryFolder folder;
  const PackVolumeReport report = pack_grid(fields, folder / "v.rho");
  EXPECT_EQ(report.file_bytes, std::filesystem::file_size(folder / "v.rho"));
  const BrickGrid grid(PackedFile::open(folder / "v.rho"));
  ASSERT_EQ(grid.description().fields.size(), 2U);
  EXPECT_EQ(grid.description().fields[0].name, "density");
  EXPECT_EQ(grid.description().fields[1].unit, "Pa");
  EXPECT_THAT(formats::deep_findings(grid), IsEmpty());
  for (std::int64_t k = 0; k < 12; ++k)
    for (std::int64_t j = 0; j < 9; ++j)
      for (std::int64_t i = 0; i < 17; ++i) {
        const std::uint64_t at = grid.tables().address(i, j, k);
        ASSERT_EQ(grid.samples<std::uint16_t>(0)[at], source_sample<std::uint16_t>(fields[0], i, j, k));
        ASSERT_EQ(grid.samples<double>(1)[at], source_sample<double>(fields[1], i, j, k));
      }
}

TEST(PackGrid, refuses_fields_of_different_lattices_or_of_one_name) {
  const auto refusal_of = [](const std::function<void(NeutralVolume&)>& spoil) {
    std::vector<NeutralVolume> fields;
    fields.reserve(2);
    for (const char* name : {"a", "b"}) {
      fields.push_back(random_volume<float>({5, 6, 7}, 1));
      fields.back().field_name = name;
    }
    spoil(fields[1]);
    const TemporaryFolder folder;
    try {
      pack_grid(fields, folder / "v.rho", {.source_name = "two.vti"});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::invalid);
      EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal_of([](NeutralVolume&) {}), "accepted");
  EXPECT_EQ(refusal_of([](NeutralVolume& b) { b.field_name = "a"; }),
            "two.vti: found two fields 'a'; expected names that differ");
  for (const auto& spoil : std::vector<std::function<void(NeutralVolume&)>>{
           [](NeutralVolume& b) {
             b.sample_count = {7, 6, 5};
           },
           [](NeutralVolume& b) { b.world_from_grid.origin.x = 1; },
           [](NeutralVolume& b) { b.axes[2] = {0, 1, 2, 3, 4, 5, 7}; }, [](NeutralVolume& b) { b.length_unit = "m"; }})
    EXPECT_EQ(refusal_of(spoil), "two.vti, field 'b': found a different lattice; expected that of 'a'");
}

TEST(PackVolume, keeps_positions_along_axes_and_takes_uniform_ones_into_the_map) {
  auto volume = random_volume<float>({4, 3, 3}, 8);
  volume.world_from_grid = {{2, 0, 0}, {0, 3, 0}, {0, 0, 5}, {100, 200, 300}};
  volume.axes = {{{0, 1, 3, 4}, {-1, -0.5, 0}, {}}};
  const auto grid = expect_faithful<float>(volume);
  EXPECT_THAT(grid.axes[0], ::testing::ElementsAre(0, 1, 3, 4));
  EXPECT_THAT(grid.axes[1], IsEmpty());
  EXPECT_THAT(grid.axes[2], IsEmpty());
  EXPECT_EQ(grid.world_from_grid, (Affine{{2, 0, 0}, {0, 1.5, 0}, {0, 0, 5}, {100, 197, 300}}));
}

TEST(PackVolume, refuses_positions_that_do_not_rise) {
  const auto words = [](std::vector<double> positions) {
    auto volume = random_volume<float>({4, 3, 3}, 8);
    volume.axes[0] = std::move(positions);
    const Error error = refusal(volume, {.source_name = "v.vtr"});
    EXPECT_EQ(error.code(), ErrorCode::invalid);
    return std::string(error.what());
  };
  EXPECT_EQ(words({0, 1, 1, 2}), "v.vtr, positions along x, sample 2: found 1; expected a finite number above 1");
  EXPECT_EQ(words({3, 2, 1, 0}), "v.vtr, positions along x, sample 1: found 2; expected a finite number above 3");
  EXPECT_EQ(words({0, 1, nan, 2}), "v.vtr, positions along x, sample 2: found nan; expected a finite number above 1");
  EXPECT_EQ(words({-infinity, 1, 2, 3}), "v.vtr, positions along x, sample 0: found -inf; expected a finite number");
  EXPECT_EQ(words({0, 1, 2}), "v.vtr, positions along x: found 3 of them; expected 4");
  EXPECT_THAT(words({-1.7e308, 0, 1, 1.7e308}), HasSubstr("expected an axis of finite length"));
}

TEST(PackVolume, stores_only_bricks_with_data_where_that_is_asked_for) {
  const auto volume = tests::volume_of<float>({19, 9, 10}, [](const Index3& p) {
    if (p.x == 17 && p.y == 8 && p.z == 9) return infinity;  // no data either
    return p.x < 8 && p.y > 2 && (p.z + p.x) % 3 != 0 ? static_cast<float>(p.x + p.y) : nan;
  });
  const TemporaryFolder folder;
  pack_volume(volume, folder / "v.rho", {.order = SampleOrder::sparse, .brick_edge = 4});
  const BrickGrid grid(PackedFile::open(folder / "v.rho"));
  EXPECT_EQ(grid.description().layout, formats::BrickLayout::sparse({19, 9, 10}, 2 * 3 * 3, 4));
  EXPECT_THAT(formats::deep_findings(grid), IsEmpty());
  expect_true_levels<float>(grid, volume);
  const formats::SparseAddress address(grid.description().layout, grid.tables(), grid.brick_slots());
  for (std::int64_t k = 0; k < 10; ++k)
    for (std::int64_t j = 0; j < 9; ++j)
      for (std::int64_t i = 0; i < 19; ++i) {
        const std::uint64_t at = address(i, j, k);
        ASSERT_EQ(at == formats::SparseAddress::no_sample, i >= 8);
        const float source = source_sample<float>(volume, i, j, k);
        if (i >= 8) continue;
        ASSERT_EQ(std::memcmp(&grid.samples<float>()[at], &source, sizeof source), 0);
      }
}

TEST(PackVolume, refuses_a_sparse_order_for_integers_and_for_bricks_that_it_does_not_have) {
  const auto whole = random_volume<std::int16_t>({4, 4, 4}, 1);
  EXPECT_THAT(refusal(whole, {.order = SampleOrder::sparse}).what(),
              HasSubstr("found samples of type I16; expected F32 or F64"));
  const auto real = random_volume<float>({4, 4, 4}, 1);
  for (const std::int64_t edge : {0, 1, 3, 128})
    EXPECT_EQ(refusal(real, {.order = SampleOrder::sparse, .brick_edge = edge}).code(), ErrorCode::usage);
}

}  // namespace
}  // namespace rhoray::preprocess

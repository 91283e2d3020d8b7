#include "preprocess/export_grid.h"

#include <nanovdb/util/IO.h>

#include <limits>

#include "preprocess/pack_volume.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/workers/vdb/support.h"
#include "tests/support/fields.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

const Affine turned{{0, 2, 0}, {3, 0, 0.1}, {0, 0, -0.7}, {10, 20, 30}};
constexpr float no_data = std::numeric_limits<float>::quiet_NaN();

float gappy_sample(const Index3& s) {
  if ((s.x + s.y + s.z) % 7 == 0) return no_data;
  return s.x < 8 ? 2.5F : static_cast<float>(s.x) - 0.1F * static_cast<float>(s.y * s.z);
}

/// A packed grid of 19 x 17 x 11 samples, some without data, and its copy as OpenVDB or NanoVDB.
class VdbExport : public Vdb {
 protected:
  VdbExport() {
    NeutralVolume volume = volume_of<float>({19, 17, 11}, gappy_sample, turned);
    volume.length_unit = "mm";
    volume.field_unit = "HU";
    volume.field_name = "density";
    pack_volume(volume, folder_ / "a.rho");
  }
  template <class Act>
  static void for_each_sample(Act&& act) {
    for (std::int64_t k = 0; k < 11; ++k)
      for (std::int64_t j = 0; j < 17; ++j)
        for (std::int64_t i = 0; i < 19; ++i) act(Index3(i, j, k), gappy_sample({i, j, k}));
  }
};

TEST_F(VdbExport, is_read_by_openvdb_with_the_same_values_and_map) {
  const ExportReport report = export_vdb(folder_ / "a.rho", folder_ / "a.vdb");
  EXPECT_EQ(report.file_bytes, std::filesystem::file_size(folder_ / "a.vdb"));
  EXPECT_THAT(report.notes, testing::ElementsAre(testing::HasSubstr("without data")));
  openvdb::io::File file((folder_ / "a.vdb").string());
  file.open();
  const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density"));
  ASSERT_TRUE(grid);
  std::uint64_t active = 0;
  for_each_sample([&](const Index3& s, float value) {
    const openvdb::Coord at(static_cast<int>(s.x), static_cast<int>(s.y), static_cast<int>(s.z));
    ASSERT_EQ(grid->tree().isValueOn(at), !std::isnan(value));
    if (std::isnan(value)) return;
    ASSERT_EQ(grid->tree().getValue(at), value);
    ++active;
  });
  EXPECT_EQ(grid->activeVoxelCount(), active);
  const openvdb::Vec3d world = grid->indexToWorld(openvdb::Vec3d(1, 2, 3));
  expect_near({world.x(), world.y(), world.z()}, turned.point({1, 2, 3}));
}

TEST_F(VdbExport, comes_back_through_the_importer_bit_for_bit) {
  export_vdb(folder_ / "a.rho", folder_ / "a.vdb");
  const NeutralVolume volume = import_volume(folder_ / "a.vdb");
  EXPECT_EQ(volume.sample_count, Index3(19, 17, 11));
  EXPECT_EQ(volume.world_from_grid, turned);
  EXPECT_EQ(volume.length_unit, "mm");
  EXPECT_EQ(volume.field_unit, "HU");
  const std::vector<double> values = values_of(volume);
  std::size_t n = 0;
  for_each_sample([&](const Index3&, float value) {
    const double found = values[n++];
    ASSERT_EQ(std::isnan(found), std::isnan(value));
    ASSERT_TRUE(std::isnan(found) || found == static_cast<double>(value));
  });
}

TEST_F(VdbExport, is_read_by_nanovdb_with_the_same_values) {
  export_vdb(folder_ / "a.rho", folder_ / "a.nvdb");
  const auto handle = nanovdb::io::readGrid((folder_ / "a.nvdb").string());
  const auto* grid = handle.grid<float>();
  ASSERT_NE(grid, nullptr);
  EXPECT_STREQ(grid->gridName(), "density");
  for_each_sample([&](const Index3& s, float value) {
    const nanovdb::Coord at(static_cast<int>(s.x), static_cast<int>(s.y), static_cast<int>(s.z));
    ASSERT_EQ(grid->tree().isActive(at), !std::isnan(value));
    if (std::isnan(value)) return;
    ASSERT_EQ(grid->tree().getValue(at), value);
  });
  const nanovdb::Vec3d world = grid->indexToWorld(nanovdb::Vec3d(1, 2, 3));
  expect_near({world[0], world[1], world[2]}, turned.point({1, 2, 3}));
}

TEST_F(VdbExport, keeps_integers_and_doubles_exactly) {
  const auto round_trip = [&]<class T>(T) {
    const auto sample = [](const Index3& s) { return static_cast<T>(16777217 + s.x + 10 * s.y + 100 * s.z); };
    pack_volume(volume_of<T>({3, 4, 5}, sample), folder_ / "b.rho", {.replace_existing = true});
    export_vdb(folder_ / "b.rho", folder_ / "b.vdb", {.replace_existing = true});
    std::vector<double> expected;
    for (std::int64_t k = 0; k < 5; ++k)
      for (std::int64_t j = 0; j < 4; ++j)
        for (std::int64_t i = 0; i < 3; ++i) expected.push_back(static_cast<double>(sample({i, j, k})));
    EXPECT_EQ(values_of(import_volume(folder_ / "b.vdb")), expected);
  };
  round_trip(std::uint8_t{});
  round_trip(std::int16_t{});
  round_trip(std::uint32_t{});
  round_trip(double{});
}

TEST_F(VdbExport, replaces_nothing_and_leaves_nothing_behind_when_it_is_refused) {
  write_file(folder_ / "a.vdb", "precious");
  expect_refusal([&] { export_vdb(folder_ / "a.rho", folder_ / "a.vdb"); }, ErrorCode::usage, {"a.vdb"});
  expect_refusal([&] { export_vdb(folder_ / "a.rho", folder_ / "b.vdb", {.field = "heat"}); }, ErrorCode::usage,
                 {"'heat'", "'density'"});
  expect_refusal([&] { export_vdb(folder_ / "a.rho", folder_ / "b.vti"); }, ErrorCode::usage, {".vti", ".vdb"});
  pack_volume(volume_of<float>({2, 2, 2}, [](const Index3&) { return no_data; }), folder_ / "empty.rho");
  expect_refusal([&] { export_vdb(folder_ / "empty.rho", folder_ / "b.vdb"); }, ErrorCode::invalid,
                 {"no finite value"});
  const Affine tiny{{1e-60, 0, 0}, {0, 1e-60, 0}, {0, 0, 1e-60}, {0, 0, 0}};
  pack_volume(volume_of<float>(
                  {2, 2, 2}, [](const Index3& s) { return static_cast<float>(s.x); }, tiny),
              folder_ / "tiny.rho");
  expect_refusal([&] { export_vdb(folder_ / "tiny.rho", folder_ / "b.vdb"); }, ErrorCode::unsupported,
                 {"b.vdb: the axes"});
  EXPECT_EQ(read_file(folder_ / "a.vdb"), "precious");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 4);
}

}  // namespace
}  // namespace rhoray::preprocess

#include <openvdb/points/PointDataGrid.h>

#include <cmath>
#include <numeric>

#include "formats/vdb_grid.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/workers/vdb/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;
using openvdb::Coord;
using testing::ElementsAre;

/// Values at a few voxels below and above zero, a tile, and a map that turns, stretches and
/// mirrors.
openvdb::FloatGrid::Ptr sparse_grid() {
  const auto grid = named_grid<openvdb::FloatGrid>("density", 0.25F);
  grid->tree().setValueOn(Coord(-3, 4, 5), 1.5F);
  grid->tree().setValueOn(Coord(2, 6, 5), -2.0F);
  const openvdb::Mat4R map(0., 2., 0., 0., 3., 0., 0., 0., 0., 0., -0.5, 0., 10., 20., 30., 1.);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(map));
  return grid;
}

TEST_F(Vdb, gives_the_background_where_nothing_is_active_and_one_voxel_around) {
  const NeutralVolume volume = import_volume(write("a.vdb", {sparse_grid()}));
  EXPECT_EQ(volume.sample_count, Index3(8, 5, 3));
  EXPECT_EQ(volume.type, ElementType::F32);
  EXPECT_EQ(volume.field_name, "density");
  std::vector<double> expected(8 * 5 * 3, 0.25);
  expected[(1 * 5 + 1) * 8 + 1] = 1.5;   // voxel (-3, 4, 5) in a box that begins at (-4, 3, 4)
  expected[(1 * 5 + 3) * 8 + 6] = -2.0;  // voxel (2, 6, 5)
  EXPECT_EQ(values_of(volume), expected);
  const Vec3 x(0, 2, 0), y(3, 0, 0), z(0, 0, -0.5);
  expect_map(volume.world_from_grid, {x, y, z, Vec3(10, 20, 30) - 4.0 * x + 3.0 * y + 4.0 * z});
}

TEST_F(Vdb, fills_tiles_as_if_they_were_voxels) {
  const auto grid = named_grid<openvdb::FloatGrid>("f", 0);
  grid->fill(openvdb::CoordBBox({0, 0, 0}, {15, 7, 7}), 3.0F, true);
  ASSERT_EQ(grid->tree().activeTileCount(), 2U) << "is this still stored as tiles?";
  const NeutralVolume volume = import_volume(write("a.vdb", {grid}));
  EXPECT_EQ(volume.sample_count, Index3(18, 10, 10));
  const std::vector<double> values = values_of(volume);
  EXPECT_EQ(std::count(values.begin(), values.end(), 3.0), 16 * 8 * 8);
  EXPECT_EQ(std::count(values.begin(), values.end(), 0.0), 18 * 10 * 10 - 16 * 8 * 8);
}

template <class Grid>
NeutralVolume imported_pair(const std::filesystem::path& path, typename Grid::ValueType a, typename Grid::ValueType b) {
  const auto grid = named_grid<Grid>("f", typename Grid::ValueType(0));
  grid->tree().setValueOn(Coord(0, 0, 0), a);
  grid->tree().setValueOn(Coord(1, 0, 0), b);
  openvdb::io::File(path.string()).write(openvdb::GridPtrVec{grid});
  return import_volume(path);
}

void expect_pair(const NeutralVolume& volume, ElementType type, double a, double b) {
  EXPECT_EQ(formats::element_name(volume.type), formats::element_name(type));
  const std::vector<double> values = values_of(volume);
  ASSERT_EQ(values.size(), 4U * 3 * 3);
  EXPECT_EQ(values[(1 * 3 + 1) * 4 + 1], a);
  EXPECT_EQ(values[(1 * 3 + 1) * 4 + 2], b);
}

TEST_F(Vdb, keeps_the_numbers_of_every_scalar_type) {
  const auto path = folder_ / "a.vdb";
  expect_pair(imported_pair<openvdb::DoubleGrid>(path, 0.1, 1e300), ElementType::F64, 0.1, 1e300);
  expect_pair(imported_pair<openvdb::Int32Grid>(path, -7, 2147483647), ElementType::I32, -7, 2147483647);
  expect_pair(imported_pair<openvdb::Int64Grid>(path, -7, std::int64_t{1} << 53), ElementType::F64, -7, std::exp2(53));
  const NeutralVolume bools = imported_pair<openvdb::BoolGrid>(path, false, true);
  expect_pair(bools, ElementType::U8, 0, 1);
  EXPECT_THAT(bools.notes, testing::Contains(testing::HasSubstr("1 and 0")));
  expect_refusal([&] { imported_pair<openvdb::Int64Grid>(path, 1, (std::int64_t{1} << 53) + 1); },
                 ErrorCode::unsupported, {"a.vdb", "9007199254740993"});
  const auto mask = named_grid<openvdb::MaskGrid>("f", false);
  mask->tree().setValueOn(Coord(0, 0, 0));
  mask->tree().setValueOn(Coord(1, 0, 0));
  expect_pair(import_volume(write("mask.vdb", {mask})), ElementType::U8, 1, 1);
}

TEST_F(Vdb, takes_a_grid_by_its_name_and_a_vector_by_its_component) {
  const auto vectors = named_grid<openvdb::Vec3SGrid>("v", openvdb::Vec3s(0));
  vectors->tree().setValueOn(Coord(0, 0, 0), openvdb::Vec3s(3, -4, 12));
  const auto first = named_grid<openvdb::FloatGrid>("a", 0), second = named_grid<openvdb::FloatGrid>("b", 0);
  first->tree().setValueOn(Coord(0, 0, 0), 1);
  second->tree().setValueOn(Coord(0, 0, 0), 2);
  const auto path = write("several.vdb", {vectors, second, first});
  const auto imported = [&](const std::string& field) {
    ImportVolumeOptions options;
    options.field = field;
    return import_volume(path, options);
  };
  const auto value = [&](const std::string& field) { return values_of(imported(field))[13]; };
  EXPECT_EQ(value(""), 1);  // the first scalar grid by name
  EXPECT_EQ(value("b"), 2);
  EXPECT_EQ(value("v.y"), -4);
  EXPECT_EQ(value("v.z"), 12);
  EXPECT_EQ(value("v.mag"), 13);
  EXPECT_THAT(imported("b").other_fields, ElementsAre("a", "v.mag", "v.x", "v.y", "v.z"));
  EXPECT_THAT(loaded(path, "v.mag").field_names(), ElementsAre("a", "b", "v.mag", "v.x", "v.y", "v.z"));
  expect_refusal([&] { open_vdb(path, "c"); }, ErrorCode::usage, {"several.vdb", "'c'", "'a'", "'v.mag'"});
  const NeutralVolume shown = import_volume(write("vectors.vdb", {vectors}));
  EXPECT_EQ(shown.field_name, "v.mag");
  EXPECT_EQ(values_of(shown)[13], 13);
  EXPECT_THAT(shown.notes, testing::Contains("using the magnitude of 3 components, 'v.mag'; choose another with "
                                             "--field: v.x, v.y, v.z"));
}

TEST_F(Vdb, says_what_is_in_a_file_that_holds_no_scalars) {
  const auto points = openvdb::points::PointDataGrid::create();
  points->tree().setValueOn(Coord(0, 0, 0));
  points->setName("dust");
  const auto path = write("points.vdb", {points});
  expect_refusal([&] { import_volume(path); }, ErrorCode::unsupported, {"points.vdb", "points in grid 'dust'"});
  const std::vector<VdbGridFacts> facts = inspect_vdb(path);
  ASSERT_EQ(facts.size(), 1U);
  EXPECT_EQ(facts[0].value_type, "ptdataidx32");
  EXPECT_FALSE(facts[0].field);
  expect_refusal([&] { open_vdb(write("empty.vdb", {}), ""); }, ErrorCode::unsupported, {"no grid"});
  expect_refusal([&] { open_vdb(write("void.vdb", {named_grid<openvdb::FloatGrid>("f", 0)}), ""); }, ErrorCode::invalid,
                 {"grid 'f'", "no active voxel"});
}

TEST_F(Vdb, refuses_a_frustum_and_a_box_that_is_too_large_when_dense) {
  const auto frustum = named_grid<openvdb::FloatGrid>("f", 0);
  frustum->tree().setValueOn(Coord(1, 1, 1), 1);
  frustum->setTransform(
      openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {10, 10, 10}), 0.5, 10, 0.1));
  expect_refusal([&] { open_vdb(write("frustum.vdb", {frustum}), ""); }, ErrorCode::unsupported,
                 {"frustum.vdb", "NonlinearFrustumMap"});
  const auto far = named_grid<openvdb::FloatGrid>("f", 0);
  far->tree().setValueOn(Coord(0, 0, 0), 1);
  far->tree().setValueOn(Coord(1197, 1197, 1197), 1);
  const auto path = write("far.vdb", {far});
  expect_refusal([&] { import_volume(path); }, ErrorCode::resource, {"far.vdb", "1200 x 1200 x 1200", "6912000000"});
  EXPECT_EQ(loaded(path).field().range, (Interval<double>{0, 1}));
}

TEST_F(Vdb, tells_the_facts_of_every_grid) {
  const auto grid = sparse_grid();
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->insertMeta("author", openvdb::StringMetadata("nobody"));
  const std::vector<VdbGridFacts> facts = inspect_vdb(write("a.vdb", {grid}));
  ASSERT_EQ(facts.size(), 1U);
  EXPECT_EQ(facts[0].name, "density");
  EXPECT_EQ(facts[0].value_type, "float");
  EXPECT_EQ(facts[0].grid_class, "fog volume");
  EXPECT_EQ(facts[0].active_voxel_count, 2U);
  EXPECT_EQ(facts[0].first_active, Index3(-3, 4, 5));
  EXPECT_EQ(facts[0].last_active, Index3(2, 6, 5));
  EXPECT_EQ(facts[0].background, 0.25);
  ASSERT_TRUE(facts[0].world_from_index);
  expect_map(*facts[0].world_from_index, {{0, 2, 0}, {3, 0, 0}, {0, 0, -0.5}, {10, 20, 30}});
  EXPECT_THAT(facts[0].metadata, testing::Contains(std::pair<std::string, std::string>("author", "nobody")));
  ASSERT_TRUE(facts[0].field);
  EXPECT_EQ(facts[0].field->range, (Interval<double>{-2, 1.5}));
  EXPECT_EQ(std::accumulate(facts[0].field->histogram.begin(), facts[0].field->histogram.end(), 0U), 2U);
}

TEST_F(Vdb, notes_when_rendering_rounds_values) {
  const auto grid = named_grid<openvdb::DoubleGrid>("f", 0.0);
  grid->tree().setValueOn(Coord(0, 0, 0), 0.1);
  grid->tree().setValueOn(Coord(1, 0, 0), 0.5);
  EXPECT_THAT(loaded(write("a.vdb", {grid})).notes(), ElementsAre(testing::HasSubstr("1 values")));
}

}  // namespace
}  // namespace rhoray::preprocess

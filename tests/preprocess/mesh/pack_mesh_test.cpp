#include "preprocess/pack_mesh.h"
#include "formats/base/parallel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stop_token>
#include <string>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/unpack_mesh.h"
#include "tests/support/expect_error.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using formats::PackedFile;
using formats::TetMesh;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using tests::TemporaryFolder;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Level 0 straight from the lists, the levels above straight from level 0.
template <class T>
void expect_true_ranges(const TetMesh& mesh, std::size_t field) {
  const auto levels = mesh.macro_levels<T>(field);
  const std::span<const T> values = mesh.values<T>(field);
  const formats::MacroShape& shape = levels.shape;
  const Index3 leaves = shape.leaf_count;
  for (int level = 0; level <= shape.level_count; ++level) {
    const Index3 count = shape.count(level);
    const std::int64_t edge = shape.cell_edge(level);
    std::vector<Interval<T>> expected(static_cast<std::size_t>(volume(count)));
    for (std::int64_t k = 0; k < leaves.z; ++k)
      for (std::int64_t j = 0; j < leaves.y; ++j)
        for (std::int64_t i = 0; i < leaves.x; ++i)
          for (const std::uint32_t cell :
               mesh.leaf_lists().list(static_cast<std::uint64_t>((k * leaves.y + j) * leaves.x + i))) {
            Interval<T> range;
            bool is_absent = false;
            for (const std::uint32_t vertex : mesh.cell(cell)) {
              is_absent = is_absent || !std::isfinite(values[vertex]);
              range.include(values[vertex]);
            }
            if (!is_absent)
              expected[static_cast<std::size_t>((k / edge * count.y + j / edge) * count.x + i / edge)].include(range);
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

/// Packs, opens, and checks what must hold of every packed mesh.
TetMesh packed(const NeutralMesh& mesh, const PackMeshOptions& options = {},
               std::vector<std::string>* notes = nullptr) {
  const TemporaryFolder folder;
  const PackMeshReport report = pack_mesh(mesh, folder / "m.rho", options);
  EXPECT_EQ(report.file_bytes, std::filesystem::file_size(folder / "m.rho"));
  if (notes != nullptr) *notes = report.notes;
  TetMesh opened(PackedFile::open(folder / "m.rho"));
  EXPECT_THAT(formats::deep_findings(opened), IsEmpty());
  EXPECT_THAT(opened.file().damaged_blocks(), IsEmpty());
  for (std::size_t f = 0; f < opened.description().fields.size() && !opened.has_clusters(); ++f) {
    if (opened.description().fields[f].type == formats::ElementType::F32)
      expect_true_ranges<float>(opened, f);
    else
      expect_true_ranges<double>(opened, f);
  }
  return opened;
}

std::vector<std::uint64_t> sorted_ids(const TetMesh& mesh) {
  std::vector<std::uint64_t> ids;
  for (std::uint64_t cell = 0; cell < mesh.description().cell_count; ++cell) ids.push_back(mesh.cell_id(cell));
  std::sort(ids.begin(), ids.end());
  return ids;
}

Error refusal(const NeutralMesh& mesh, const PackMeshOptions& options = {}) {
  const TemporaryFolder folder;
  try {
    pack_mesh(mesh, folder / "m.rho", options);
  } catch (const Error& error) {
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "something was left behind";
    return error;
  }
  return Error(ErrorCode::internal, "accepted");
}

TEST(PackMesh, keeps_points_cells_and_values) {
  const NeutralMesh mesh = tests::box_mesh({.cells = {7, 6, 5}, .box = {{1, 2, 3}, {3, 4, 4}}, .jitter = 0.15},
                                           tests::linear_field({1, -2, 0.5}, 7));
  const TetMesh opened = packed(mesh);
  const auto& description = opened.description();
  ASSERT_EQ(opened.points().size(), mesh.points.size());
  ASSERT_EQ(description.cell_count, mesh.cells.size());
  std::vector<bool> is_here(mesh.cells.size());
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const std::uint64_t id = opened.cell_id(c);
    ASSERT_LT(id, is_here.size());
    EXPECT_FALSE(is_here[id]);
    is_here[id] = true;
    for (std::size_t v = 0; v < 4; ++v) EXPECT_EQ(opened.point_rank(opened.cell(c)[v]), mesh.cells[id][v]);
  }
  const auto values = opened.values<double>(0);
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    const std::uint64_t rank = opened.point_rank(p);
    EXPECT_EQ(tests::to_array(description.origin + tests::to_vec3(opened.points()[p])), mesh.points[rank]);
    EXPECT_EQ(values[p], mesh.point_fields[0].values[rank]);
  }
  EXPECT_EQ(description.fields[0].range, (Interval<double>{7 + 1 - 8 + 1.5, 7 + 3 - 4 + 2}));
  EXPECT_EQ(description.fields[0].no_data_count, 0u);
}

TEST(PackMesh, holds_for_graded_aligned_far_and_strewn_meshes_and_any_hierarchy) {
  const tests::Field field = tests::distance_field({0.3, 0.4, 0.5});
  std::vector<NeutralMesh> meshes{
      tests::box_mesh({.cells = {9, 9, 9}, .grading = 60}, field), tests::box_mesh({.cells = {8, 8, 8}}, field, true),
      tests::box_mesh({.cells = {6, 6, 6}, .box = {{8e6, -3e6, 1e5}, {8e6 + 90, -3e6 + 80, 1e5 + 70}}, .jitter = 0.1},
                      field)};
  for (const double flatness : {1.0, 1e-9, 0.0}) {
    meshes.push_back(tests::strewn_mesh(500, 0.1, flatness, 4));
    tests::add_point_field(meshes.back(), "value", field);
  }
  for (const NeutralMesh& mesh : meshes) {
    packed(mesh);
    packed(mesh, {.cluster_size = 4});
    packed(mesh, {.structure = MeshStructure::leaves});
    packed(mesh, {.structure = MeshStructure::leaves,
                  .leaf_cells_per_tetrahedron = 0.05,
                  .macro_factor = 2,
                  .macro_level_count = 6});
  }
}

TEST(PackMesh, makes_about_as_many_leaf_cells_as_asked) {
  const NeutralMesh mesh = tests::box_mesh({.cells = {10, 10, 10}}, tests::product_field());
  const auto leaf_cells = [&](const PackMeshOptions& options) {
    return static_cast<double>(volume(packed(mesh, options).description().lattice.macro.leaf_count));
  };
  EXPECT_NEAR(leaf_cells({}), 6000, 600) << "clusters keep the lattice as a measure";
  EXPECT_NEAR(leaf_cells({.structure = MeshStructure::leaves}), 6000, 600);
  EXPECT_NEAR(leaf_cells({.structure = MeshStructure::leaves, .leaf_cells_per_tetrahedron = 0.1}), 600, 120);
  EXPECT_NEAR(leaf_cells({.structure = MeshStructure::leaves, .leaf_cell_count = 20000}), 20000, 2000);
  EXPECT_EQ(leaf_cells({.structure = MeshStructure::leaves, .leaf_cells_per_tetrahedron = 1e-9}), 1);
}

TEST(PackMesh, reports_what_it_met_and_keeps_the_ids_of_cells) {
  NeutralMesh mesh = tests::box_mesh({}, tests::product_field());
  std::swap(mesh.cells[5][0], mesh.cells[5][1]);
  mesh.cells[7] = {0, 1, 1, 2};
  mesh.points.push_back({0.1, 0.1, 0.1});
  mesh.point_fields[0].values.push_back(123456);  // of the unused point: in no range
  mesh.point_fields[0].values[0] = nan;
  std::vector<std::string> notes;
  const TetMesh opened = packed(mesh, {}, &notes);
  const auto& description = opened.description();
  EXPECT_EQ(description.flipped_cell_count, 1u);
  EXPECT_EQ(description.dropped_cell_count, 1u);
  EXPECT_EQ(description.unused_point_count, 1u);
  EXPECT_EQ(description.fields[0].no_data_count, 1u);
  EXPECT_EQ(description.fields[0].range.hi, 1);
  const std::vector<std::uint64_t> ids = sorted_ids(opened);
  EXPECT_EQ(ids[6], 6u);
  EXPECT_EQ(ids[7], 8u);
  EXPECT_THAT(notes, ElementsAre("1 cell with a repeated vertex: dropped (cell 7)",
                                 "1 point without a cell: dropped (point 125)",
                                 "1 cell of negative orientation: two vertices exchanged (cell 5)",
                                 "field \"value\" has no data at 1 point; adjacent cells are not drawn"));
}

TEST(PackMesh, keeps_ids_that_the_importer_gave_also_where_no_cell_is_dropped) {
  NeutralMesh mesh = tests::box_mesh({}, tests::product_field());
  for (std::uint64_t c = 0; c < mesh.cells.size(); ++c) mesh.cell_ids.push_back(2 * c + 100);
  const TetMesh opened = packed(mesh);
  const std::vector<std::uint64_t> ids = sorted_ids(opened);
  EXPECT_EQ(ids[0], 100u);
  EXPECT_EQ(ids[50], 200u);
  mesh.cell_ids.back() = std::uint64_t{1} << 32;
  EXPECT_EQ(refusal(mesh).code(), ErrorCode::unsupported);
}

TEST(PackMesh, has_empty_intervals_where_all_cells_lack_data) {
  const auto mesh = tests::box_mesh(
      {.cells = {8, 8, 8}, .jitter = 0.1}, [](const Vec3& p) { return p.x < 0.6 ? nan : p.x; }, true);
  const TetMesh opened = packed(mesh, {.structure = MeshStructure::leaves});
  EXPECT_EQ(opened.description().fields[0].type, formats::ElementType::F32);
  const auto levels = opened.macro_levels<float>(0);
  EXPECT_TRUE(levels.range(0, 0, 0, 0).is_empty());
  EXPECT_TRUE(levels.range(1, 0, 1, 1).is_empty());
  EXPECT_EQ(levels.range(3, 0, 0, 0).hi, 1.0f);
  EXPECT_GE(levels.range(3, 0, 0, 0).lo, 0.6f);
  const TetMesh clustered = packed(mesh, {.cluster_size = 8});
  const auto clusters = clustered.cluster_ranges<float>(0);
  const auto empty = std::count_if(clusters[0].begin(), clusters[0].end(),
                                   [](const formats::RangeBlock<float>& block) { return block.lo[0] > block.hi[0]; });
  EXPECT_GT(empty, 16) << "of 48";
  EXPECT_LT(empty, 40);
}

TEST(PackMesh, packs_several_fields_of_both_precisions_in_the_order_asked) {
  NeutralMesh mesh = tests::box_mesh({.jitter = 0.1}, tests::product_field(), true);
  tests::add_point_field(mesh, "distance", tests::distance_field({0, 0, 0}));
  NeutralField velocity{.name = "velocity", .unit = "m/s", .component_count = 3, .values = {}};
  for (const auto& point : mesh.points) velocity.values.insert(velocity.values.end(), {point[0], 2.0, -1.0});
  mesh.point_fields.push_back(velocity);
  NeutralField region{.name = "region", .unit = {}, .values = {}};
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) region.values.push_back(static_cast<double>(c % 3));
  mesh.cell_fields.push_back(region);

  const TetMesh opened =
      packed(mesh, {.fields = {"velocity.y", "distance", "value", "velocity.mag", "region"}, .cells_to_points = true});
  const auto& fields = opened.description().fields;
  ASSERT_EQ(fields.size(), 5u);
  EXPECT_EQ(fields[0].name, "velocity.y");
  EXPECT_EQ(fields[0].unit, "m/s");
  EXPECT_EQ(fields[0].range, (Interval<double>{2, 2}));
  EXPECT_EQ(fields[1].type, formats::ElementType::F64);
  EXPECT_EQ(fields[2].type, formats::ElementType::F32);
  EXPECT_EQ(opened.find_field("region"), 4u);
  EXPECT_GE(fields[4].range.lo, 0);
  EXPECT_LE(fields[4].range.hi, 2);
  ASSERT_EQ(opened.find_cell_field("region"), 0u);
  EXPECT_EQ(opened.description().cell_fields[0].range, (Interval<double>{0, 2}));
  for (std::uint64_t c = 0; c < opened.description().cell_count; ++c)
    ASSERT_EQ(opened.cell_values<float>(0)[c], static_cast<float>(opened.cell_id(c) % 3));
}

TEST(PackMesh, keeps_the_boundary_in_at_most_5_percent_of_the_file) {
  const NeutralMesh mesh = tests::box_mesh({.cells = {30, 30, 30}, .jitter = 0.15}, tests::product_field(), true);
  const TetMesh opened = packed(mesh);
  EXPECT_EQ(opened.boundary().size(), 12U * 30 * 30);
  EXPECT_LT(static_cast<double>(opened.boundary().size_bytes()),
            0.05 * static_cast<double>(opened.file().file_bytes()));
}

TEST(UnpackMesh, ends_after_a_stop_request) {
  const TetMesh opened = packed(tests::box_mesh({.cells = {3, 3, 3}}, tests::product_field()));
  std::stop_source stop;
  stop.request_stop();
  tests::expect_error(ErrorCode::interrupted, "interrupted", [&] { unpack_mesh(opened, stop.get_token()); });
  EXPECT_EQ(unpack_mesh(opened).cells.size(), opened.description().cell_count);
}

TEST(PackMesh, writes_the_same_bytes_on_any_number_of_threads) {
  const TemporaryFolder folder;
  NeutralMesh mesh = tests::box_mesh({.cells = {14, 14, 14}, .jitter = 0.15}, tests::product_field());
  mesh.cell_fields.push_back({.name = "c", .unit = {}, .values = Array<double>(mesh.cells.size(), 0.1)});
  mesh.cell_fields[0].values[77] = 1e9;
  std::swap(mesh.cells[9][1], mesh.cells[9][3]);
  std::vector<std::string> files;
  for (const unsigned threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    pack_mesh(mesh, folder / "m.rho", {.cells_to_points = true, .replace_existing = true});
    files.push_back(tests::read_file(folder / "m.rho"));
  }
  EXPECT_TRUE(files[0] == files[1]);
  EXPECT_TRUE(files[0] == files[2]);
}

TEST(PackMesh, takes_at_most_14_bytes_for_a_tetrahedron_beyond_points_and_fields_and_100_with_lists) {
  const TemporaryFolder folder;
  for (const double grading : {1.0, 50.0}) {
    const NeutralMesh mesh = tests::box_mesh(
        {.cells = {20, 20, 20}, .jitter = grading == 1 ? 0.15 : 0, .grading = grading}, tests::product_field(), true);
    const auto bytes_beyond = [&](MeshStructure structure) {
      const auto report = pack_mesh(mesh, folder / "m.rho", {.structure = structure, .replace_existing = true});
      const auto beyond = static_cast<double>(report.file_bytes - mesh.points.size() * (3 * 8 + 4));
      return beyond / static_cast<double>(mesh.cells.size());
    };
    EXPECT_LT(bytes_beyond(MeshStructure::clusters), 14);
    EXPECT_LT(bytes_beyond(MeshStructure::leaves), 100);
  }
}

TEST(PackMesh, refuses_bad_meshes_and_bad_options_and_leaves_nothing) {
  const NeutralMesh good = tests::box_mesh({}, tests::product_field());
  EXPECT_EQ(refusal(tests::box_mesh({})).code(), ErrorCode::invalid) << "no field";
  EXPECT_EQ(refusal(NeutralMesh{}).code(), ErrorCode::invalid);
  NeutralMesh wrong = good;
  wrong.cells[3][3] = 125;
  EXPECT_THAT(refusal(wrong, {.source_name = "a.vtu"}).what(), HasSubstr("a.vtu, cell 3: found vertex 125"));
  EXPECT_EQ(refusal(good, {.fields = {"valeu"}}).hint(), "did you mean value?");
  for (const double share : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()})
    EXPECT_EQ(refusal(good, {.structure = MeshStructure::leaves, .leaf_cells_per_tetrahedron = share}).code(),
              ErrorCode::usage);
  EXPECT_EQ(refusal(good, {.structure = MeshStructure::leaves, .leaf_cell_count = std::uint64_t{1} << 40}).code(),
            ErrorCode::usage);
  EXPECT_EQ(refusal(good, {.macro_factor = 1}).code(), ErrorCode::usage);
  for (const std::uint64_t size : {0U, 3U, 128U})
    EXPECT_EQ(refusal(good, {.cluster_size = size}).code(), ErrorCode::usage);
}

TEST(PackMesh, can_be_stopped_by_its_progress) {
  const TemporaryFolder folder;
  struct Stopped {};
  const NeutralMesh mesh = tests::box_mesh({.cells = {10, 10, 10}}, tests::product_field());
  const auto stop = [](std::string_view phase, std::uint64_t done, std::uint64_t) {
    if (phase == "writing (bytes)" && done > 0) throw Stopped();
  };
  EXPECT_THROW(pack_mesh(mesh, folder / "m.rho", {}, stop), Stopped);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace rhoray::preprocess

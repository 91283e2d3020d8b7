#include "formats/tet_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/expect_error.h"
#include "tests/support/memory_file.h"
#include "tests/support/packed_samples.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::formats {
namespace {

using tests::expect_error;
using tests::TemporaryFolder;
using tests::TetSample;

TetSample small_mesh() {
  return tests::sample_tets(2,
                            {{"height", [](const Vec3& p) { return p.z; }},
                             {"far", [](const Vec3& p) { return p.x > 0.9 ? std::nan("") : p.x * p.y - 100; }}},
                            {3, 2, 2});
}

TEST(TetMesh, comes_back_as_written) {
  const TemporaryFolder folder;
  const TetSample sample = small_mesh();
  const TetMesh mesh = packed(sample, folder / "m.rho");
  const TetMeshDescription& d = mesh.description();
  EXPECT_EQ(d.point_count, 27U);
  EXPECT_EQ(d.cell_count, 48U);
  EXPECT_EQ(d.origin, Vec3(10, 20, 30));
  EXPECT_EQ(d.length_unit, "m");
  EXPECT_EQ(d.lattice.leaf_size, sample.description.lattice.leaf_size);
  EXPECT_EQ(d.lattice.macro, sample.description.lattice.macro);
  ASSERT_EQ(mesh.points().size(), 27U);
  for (std::size_t p = 0; p < 27; ++p)
    EXPECT_THAT(mesh.points()[p], testing::ElementsAreArray(sample.points.data() + 3 * p, 3));
  for (std::size_t c = 0; c < 48; ++c)
    EXPECT_THAT(mesh.cell(c), testing::ElementsAreArray(sample.cells.data() + 4 * c, 4));
  EXPECT_FALSE(mesh.has_clusters());
  EXPECT_THAT(mesh.leaf_lists().offsets, testing::ElementsAreArray(sample.offsets));
  EXPECT_THAT(mesh.leaf_lists().items, testing::ElementsAreArray(sample.items));
  EXPECT_EQ(mesh.find_field("far"), 1U);
  EXPECT_EQ(mesh.find_field("near"), std::nullopt);
  EXPECT_EQ(mesh.values<float>(0)[26], 1.0F);
  EXPECT_EQ(mesh.macro_levels<float>(0).range(2, 0, 0, 0), (Interval<float>{0, 1}));
  EXPECT_EQ(mesh.description().fields[1].no_data_count, 9U);
  EXPECT_EQ(mesh.cell_id(5), 5U) << "without a table a cell is its own id";
  EXPECT_THAT(deep_findings(mesh), testing::IsEmpty());
}

TEST(TetMesh, volumes_of_the_sample_cells_are_positive_and_fill_the_box) {
  const TetSample sample = tests::sample_tets(3, {{"f", [](const Vec3& p) { return p.x; }}}, {2, 2, 2}, {2, 3, 4});
  double total = 0;
  for (std::size_t c = 0; c < sample.cells.size(); c += 4) {
    const auto point = [&](std::size_t v) {
      const double* p = sample.points.data() + 3 * std::size_t{sample.cells[c + v]};
      return Vec3(p[0], p[1], p[2]);
    };
    const Vec3 p0 = point(0);
    const double volume = (point(1) - p0).cross(point(2) - p0).dot(point(3) - p0) / 6;
    EXPECT_GT(volume, 0);
    total += volume;
  }
  EXPECT_NEAR(total, 24, 1e-12);
}

TEST(TetMesh, ids_of_the_source_are_kept_where_cells_were_dropped) {
  TetSample sample = small_mesh();
  sample.description.dropped_cell_count = 2;
  for (std::uint32_t i = 0; i < 48; ++i) sample.cell_ids.push_back(i + (i > 10 ? 2 : 0));
  const TemporaryFolder folder;
  const TetMesh mesh = packed(sample, folder / "m.rho");
  EXPECT_EQ(mesh.cell_id(10), 10U);
  EXPECT_EQ(mesh.cell_id(11), 13U);
  EXPECT_EQ(mesh.description().dropped_cell_count, 2U);
  EXPECT_THAT(deep_findings(mesh), testing::IsEmpty());
}

/// The small mesh with cells and points in a different order from the source.
TetSample reordered_mesh() {
  TetSample sample = small_mesh();
  sample.description.in_source_order = false;
  // six cells were cut from one
  for (std::uint32_t c = 0; c < 48; ++c) sample.cell_ids.push_back((c * 5 + 1) % 48 / 6);
  for (std::uint32_t p = 0; p < 27; ++p) sample.point_ranks.push_back((p * 4 + 3) % 27);
  return sample;
}

TEST(TetMesh, tells_where_cells_and_points_stood_in_the_source) {
  const TemporaryFolder folder;
  const TetMesh mesh = packed(reordered_mesh(), folder / "m.rho");
  EXPECT_EQ(mesh.file().version(), "1.2");
  EXPECT_FALSE(mesh.description().in_source_order);
  EXPECT_EQ(mesh.cell_id(1), 1U);
  EXPECT_EQ(mesh.cell_id(47), 236U % 48 / 6);
  EXPECT_EQ(mesh.point_rank(0), 3U);
  EXPECT_EQ(mesh.point_rank(6), 0U);
  EXPECT_THAT(deep_findings(mesh), testing::IsEmpty());
  EXPECT_EQ(packed(small_mesh(), folder / "s.rho").file().version(), "1.0");
}

TEST(TetMesh, comes_back_as_written_in_clusters_of_any_size) {
  for (const std::uint64_t size : {1U, 4U, 16U, 32U, 64U}) {
    const TemporaryFolder folder;
    const TetSample sample = clustered(small_mesh(), size);
    const TetMesh mesh = packed(sample, folder / "m.rho");
    EXPECT_EQ(mesh.file().version(), "1.2");
    EXPECT_THAT(mesh.file().description().required, testing::ElementsAre("cell-clusters"));
    ASSERT_TRUE(mesh.has_clusters());
    for (std::size_t c = 0; c < 48; ++c)
      EXPECT_THAT(mesh.cell(c), testing::ElementsAreArray(sample.cells.data() + 4 * c, 4));
    const CellClustersView& clusters = mesh.clusters();
    EXPECT_EQ(clusters.cluster_count(), (48 + size - 1) / size);
    EXPECT_EQ(clusters.end_cell(clusters.cluster_count() - 1), 48U);
    EXPECT_EQ(clusters.cluster_of(47), clusters.cluster_count() - 1);
    EXPECT_EQ(clusters.shape.top_level(), size <= 4 ? 1 : 0);
    const auto top = static_cast<std::size_t>(clusters.shape.top_level());
    const BoxBlock& root = clusters.boxes[top].front();
    EXPECT_EQ(*std::min_element(root.lo[0].begin(), root.lo[0].end()), 0);
    EXPECT_EQ(*std::max_element(root.hi[2].begin(), root.hi[2].end()), 1);
    const RangeBlock<float>& heights = mesh.cluster_ranges<float>(0)[top].front();
    EXPECT_EQ(*std::max_element(heights.hi.begin(), heights.hi.end()), 1);
    EXPECT_THAT(deep_findings(mesh), testing::IsEmpty());
  }
}

// ---- content that would lead a reader astray ----------------------------------------------------

void open_after(const std::function<void(TetSample&)>& spoil) {
  TetSample sample = small_mesh();
  spoil(sample);
  const tests::MemoryFile memory;
  PackedFileWriter writer(memory.descriptor(), describe(sample.description), tet_mesh_arrays(sample.description));
  sample.write_into(writer).commit();
  TetMesh(PackedFile::from_descriptor(memory.descriptor(), "m.rho"));
}

TEST(TetMesh, refuses_what_a_hot_loop_could_not_survive) {
  expect_error(ErrorCode::invalid, "array 'cells', element 191: found 27; expected an index below 27",
               [] { open_after([](TetSample& s) { s.cells.back() = 27; }); });
  expect_error(ErrorCode::invalid, "array 'leaf.items', element 3: found 48; expected an index below 48",
               [] { open_after([](TetSample& s) { s.items[3] = 48; }); });
  expect_error(ErrorCode::invalid, "array 'leaf.offsets', element 0: found 1",
               [] { open_after([](TetSample& s) { s.offsets[0] = 1; }); });
  expect_error(ErrorCode::invalid, "array 'leaf.offsets', element 12: found",
               [] { open_after([](TetSample& s) { ++s.offsets.back(); }); });
  expect_error(ErrorCode::invalid, "array 'leaf.offsets', element 5: found 0; expected at least",
               [] { open_after([](TetSample& s) { s.offsets[5] = 0; }); });
  expect_error(ErrorCode::invalid, "array 'leaf.offsets', element 5: found",
               [] { open_after([](TetSample& s) { s.offsets[5] = s.offsets[4] - 1; }); });
  expect_error(ErrorCode::invalid, "array 'leaf.offsets', element 5: found",
               [] { open_after([](TetSample& s) { s.offsets[4] = std::uint64_t{1} << 60; }); });
  expect_error(ErrorCode::invalid, "array 'points', element 7: found nan",
               [] { open_after([](TetSample& s) { s.points[7] = std::nan(""); }); });
  expect_error(ErrorCode::invalid, "array 'points', element 80: found -inf",
               [] { open_after([](TetSample& s) { s.points[80] = -std::numeric_limits<double>::infinity(); }); });
  expect_error(ErrorCode::invalid, "array 'point_ranks', element 20: found 27; expected an index below 27", [] {
    open_after([](TetSample& s) {
      s = reordered_mesh();
      s.point_ranks[20] = 27;
    });
  });
}

TEST(TetMesh, refuses_clusters_that_a_hot_loop_could_not_survive) {
  const auto refuses = [](const std::string& words, const std::function<void(TetSample&)>& spoil) {
    expect_error(ErrorCode::invalid, words, [&] {
      open_after([&](TetSample& s) {
        s = clustered(s, 16);
        spoil(s);
      });
    });
  };
  refuses("array 'cluster.vertices', element 2: found 27; expected an index below 27",
          [](TetSample& s) { s.clusters.vertices[2] = 27; });
  refuses("array 'cluster.corners', cluster 1: found", [](TetSample& s) {
    s.clusters.corners[4 * 16 + 7] = static_cast<std::uint8_t>(s.clusters.offsets[2] - s.clusters.offsets[1]);
  });
  refuses("array 'cluster.offsets', element 0: found 1", [](TetSample& s) { s.clusters.offsets[0] = 1; });
  refuses("array 'cluster.offsets', element 3: found", [](TetSample& s) { ++s.clusters.offsets.back(); });
  refuses("array 'cluster.offsets', element 2: found", [](TetSample& s) { s.clusters.offsets[2] = 1; });
  refuses("array 'cluster.boxes.0', entry 3: found one that is not empty; expected 3 entries",
          [](TetSample& s) { s.clusters.boxes[0][8 + 3] = 0; });
  refuses("array 'range.1.0', entry 7: found one that is not empty", [](TetSample& s) {
    s.ranges[1][0][7] = 0;
    s.ranges[1][0][15] = 0;
  });
}

// The same with a scan that is divided between several threads.
TEST(TetMesh, names_the_first_bad_element_of_large_arrays) {
  constexpr std::uint64_t cells = 600'000;
  for (const std::uint64_t bad : {std::uint64_t{0}, std::uint64_t{1'234'567}, 4 * cells - 1}) {
    TetSample sample;
    TetMeshDescription& d = sample.description;
    d.point_count = 4;
    d.cell_count = cells;
    d.fields.push_back({.name = "f", .unit = {}, .type = ElementType::F32, .range = {0, 3}, .histogram = {}});
    d.lattice = {{0, 0, 0}, {1, 1, 1}, {{1, 1, 1}, 2, 1}};
    sample.points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (std::uint64_t c = 0; c < cells; ++c) sample.cells.insert(sample.cells.end(), {0, 1, 2, 3});
    sample.cells[bad] = sample.cells.back() = 4;
    sample.offsets = {0, 0};
    sample.values = {{0, 1, 2, 3}};
    sample.ranges = {{{0, 3}, {0, 3}}};
    const tests::MemoryFile memory;
    PackedFileWriter writer(memory.descriptor(), describe(d), tet_mesh_arrays(d));
    sample.write_into(writer).commit();
    expect_error(ErrorCode::invalid, concat("array 'cells', element ", bad, ": found 4"),
                 [&] { TetMesh(PackedFile::from_descriptor(memory.descriptor(), "m.rho")); });
  }
}

// ---- deep findings ------------------------------------------------------------------------------

std::vector<std::string> findings_after(const std::function<void(TetSample&)>& spoil) {
  TetSample sample = small_mesh();
  spoil(sample);
  const TemporaryFolder folder;
  return deep_findings(packed(sample, folder / "m.rho"));
}

TEST(TetMeshDeepFindings, name_each_kind_of_lie) {
  using testing::Contains, testing::ElementsAre, testing::HasSubstr;
  EXPECT_THAT(findings_after([](TetSample&) {}), testing::IsEmpty());
  EXPECT_THAT(findings_after([](TetSample& s) { std::swap(s.cells[0], s.cells[1]); }),
              ElementsAre("a cell of negative orientation: cell 0"));
  EXPECT_THAT(findings_after([](TetSample& s) { s.cells[1] = s.cells[0]; }),
              Contains("a cell with a vertex twice: cell 0"));
  EXPECT_THAT(findings_after([](TetSample& s) { std::swap(s.items[0], s.items[1]); }),
              Contains("a leaf list that does not rise: leaf 0"));
  EXPECT_THAT(findings_after([](TetSample& s) {
                for (std::uint32_t& item : s.items) item = item == 7 ? 6 : item;
              }),
              Contains(HasSubstr("a cell missing from the list of a leaf cell that it touches: cell 7 touches leaf ")));
  EXPECT_THAT(findings_after([](TetSample& s) { s.ranges[0][2][0] = 0.25F; }),
              ElementsAre(HasSubstr("macro levels of field 'height': a macrocell does not match the level below")));
  EXPECT_THAT(findings_after([](TetSample& s) {
                for (std::vector<float>& level : s.ranges[0])
                  for (std::size_t i = 1; i < level.size(); i += 2) level[i] = std::min(level[i], 0.3F);
              }),
              Contains(HasSubstr("macro levels of field 'height': an interval lacks a value of its leaf cell: leaf")));
  EXPECT_THAT(findings_after([](TetSample& s) { s.description.fields[0].range.lo = -1; }),
              Contains(HasSubstr("the range of field 'height' is wrong")));
  EXPECT_THAT(findings_after([](TetSample& s) { s.description.fields[1].no_data_count = 0; }),
              ElementsAre(HasSubstr("the count without data of field 'far' is wrong: the values give 9")));
  EXPECT_THAT(findings_after([](TetSample& s) {
                s.points.insert(s.points.end(), {0.5, 0.5, 0.5});
                ++s.description.point_count;
                s.values[0].push_back(0.5);
                s.values[1].push_back(-99);
              }),
              Contains("a point that no cell uses: point 27"));
  EXPECT_THAT(findings_after([](TetSample& s) {
                s = reordered_mesh();
                s.point_ranks[9] = s.point_ranks[8];
              }),
              ElementsAre("a point rank given twice: point 9"));
}

TEST(TetMeshDeepFindings, name_each_kind_of_lie_about_clusters) {
  using testing::Contains, testing::ElementsAre, testing::HasSubstr;
  const auto findings = [](const std::function<void(TetSample&)>& spoil) {
    return findings_after([&](TetSample& s) {
      s = clustered(s, 4);
      spoil(s);
    });
  };
  EXPECT_THAT(findings([](TetSample&) {}), testing::IsEmpty());
  EXPECT_THAT(findings([](TetSample& s) { std::swap(s.clusters.vertices[0], s.clusters.vertices[1]); }),
              Contains("a table of vertices that does not rise: cluster 0"));
  EXPECT_THAT(findings([](TetSample& s) {
                const std::size_t vertices = s.clusters.offsets[1];
                for (std::uint8_t& corner : std::span(s.clusters.corners).first(16))
                  if (corner + 1U == vertices) --corner;
              }),
              Contains("a table with vertices that no cell of it uses: cluster 0"));
  EXPECT_THAT(findings([](TetSample& s) { s.clusters.boxes[0][48 + 3 * 8 + 3] -= 0.1F; }),
              ElementsAre(HasSubstr("a cluster that reaches out of its box: cluster 11 has [")));
  EXPECT_THAT(findings([](TetSample& s) { s.clusters.boxes[0][8 + 1] -= 0.1F; }),
              ElementsAre(HasSubstr("a box that does not hold those below it: entry 0 of level 1 has [")));
  EXPECT_THAT(findings([](TetSample& s) { s.ranges[0][0][8 + 2] = -1; }),
              Contains(HasSubstr("ranges of field 'height': a cluster's lacks a value of its cells: cluster 2")));
  EXPECT_THAT(
      findings([](TetSample& s) { s.ranges[1][1][8] = -1e9F; }),
      ElementsAre(HasSubstr(
          "ranges of field 'far': an entry does not match the level below: entry 0 of level 1 has empty, below it [")));
}

/// Sampled pictures end where the lattice ends: this one was empty.
TEST(TetMesh, points_outside_the_lattice_are_found_also_with_clusters) {
  TetSample sample = clustered(small_mesh(), 8);
  const TemporaryFolder folder;
  EXPECT_THAT(deep_findings(packed(sample, folder / "sound.rho")), testing::IsEmpty());
  sample.description.lattice.low = {50, 50, 50};
  EXPECT_THAT(deep_findings(packed(sample, folder / "m.rho")),
              testing::ElementsAre(testing::HasSubstr("a point outside the lattice")));
}

}  // namespace
}  // namespace rhoray::formats

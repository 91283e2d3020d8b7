#include "preprocess/mesh/inspect/clean_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "formats/base/error.h"
#include "preprocess/mesh/inspect/orientation.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Cell = std::array<std::uint32_t, 4>;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string refusal(const NeutralMesh& mesh) {
  try {
    clean_mesh(mesh, "heart.vtu");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid);
    return error.what();
  }
  return "accepted";
}

/// One cell of each kind, in the order: good, vertex twice, not finite, flipped, flat, good. Points
/// 1 and 8 belong to none.
NeutralMesh mixed_mesh() {
  NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {9, 9, 9}, {1, 0, 0},        {0, 1, 0}, {0, 0, 1},
                 {1, 1, 1}, {1, 1, 0}, {0, infinity, 0}, {5, 5, 5}};
  mesh.cells = {{0, 2, 3, 4}, {0, 2, 2, 4}, {0, 2, 3, 7}, {0, 3, 2, 4}, {0, 2, 3, 6}, {2, 6, 3, 5}};
  return mesh;
}

TEST(CleanMesh, drops_turns_keeps_and_counts_each_kind_of_cell) {
  const CleanMesh clean = clean_mesh(mixed_mesh(), "mesh");
  EXPECT_EQ(clean.dropped_cell_count, 2u);
  EXPECT_EQ(clean.flipped_cell_count, 1u);
  EXPECT_EQ(clean.flat_cell_count, 1u);
  EXPECT_EQ(clean.unused_point_count, 3u);
  EXPECT_THAT(clean.source_cells, ElementsAre(0, 3, 4, 5));
  EXPECT_THAT(clean.source_points, ElementsAre(0, 2, 3, 4, 5, 6));
  EXPECT_THAT(clean.cells, ElementsAre(Cell{0, 1, 2, 3}, Cell{0, 2, 3, 1}, Cell{0, 1, 2, 5}, Cell{1, 5, 2, 4}));
  EXPECT_THAT(clean.notes, ElementsAre("1 cell with a repeated vertex: dropped (cell 1)",
                                       "1 cell with a coordinate that is not finite: dropped (cell 2)",
                                       "3 points without a cell: dropped (points 1, 7, 8)",
                                       "1 cell of negative orientation: two vertices exchanged (cell 3)",
                                       "1 cell of zero volume: kept (cell 4)"));
}

TEST(CleanMesh, names_cells_by_their_place_in_the_source) {
  NeutralMesh mesh = mixed_mesh();
  mesh.cell_ids = {10, 20, 30, 40, 50, 60};
  EXPECT_THAT(clean_mesh(mesh, "mesh").notes.front(), HasSubstr("(cell 20)"));
}

TEST(CleanMesh, notes_nothing_about_a_clean_mesh) {
  const CleanMesh clean = clean_mesh(tests::box_mesh({.jitter = 0.1}), "mesh");
  EXPECT_TRUE(clean.notes.empty());
  EXPECT_EQ(clean.flipped_cell_count + clean.flat_cell_count + clean.dropped_cell_count + clean.unused_point_count, 0u);
}

TEST(CleanMesh, turns_every_cell_of_a_mirrored_mesh) {
  NeutralMesh mesh = tests::box_mesh({.jitter = 0.1});
  for (auto& point : mesh.points) point[0] = -point[0];
  const CleanMesh clean = clean_mesh(mesh, "mesh");
  EXPECT_EQ(clean.flipped_cell_count, mesh.cells.size());
  EXPECT_THAT(clean.notes.at(0), HasSubstr("(first cells 0, 1, 2)"));
  for (const Cell& cell : clean.cells)
    EXPECT_EQ(orientation(clean.points[cell[0]], clean.points[cell[1]], clean.points[cell[2]], clean.points[cell[3]]),
              1);
}

TEST(CleanMesh, keeps_every_digit_of_coordinates_far_from_zero) {
  for (const Vec3& place :
       {Vec3(0, 0, 0), Vec3(0.3, -1, 2), Vec3(8.5e6, -4e6, 1e3), Vec3(1e15, -1e12, 1e9), Vec3(1e-9, 1e3, -2.5)}) {
    NeutralMesh mesh =
        tests::box_mesh({.cells = {6, 5, 4}, .box = {place, place + Vec3(1.7, 2.1, 0.9)}, .jitter = 0.15});
    const CleanMesh clean = clean_mesh(mesh, "mesh");
    for (std::size_t p = 0; p < clean.points.size(); ++p) {
      const auto& source = mesh.points[clean.source_points[p]];
      for (std::size_t a = 0; a < 3; ++a) {
        const double origin = clean.origin[static_cast<int>(a)];
        EXPECT_EQ(origin + clean.points[p][a], source[a]);
        EXPECT_LE(std::abs(clean.points[p][a]), 8);
        EXPECT_EQ(static_cast<long double>(origin) + clean.points[p][a], static_cast<long double>(source[a]));
      }
    }
  }
}

TEST(CleanMesh, refuses_a_vertex_index_out_of_range_naming_cell_and_index) {
  NeutralMesh mesh = tests::box_mesh({});
  mesh.cells[17][2] = mesh.points.size();
  mesh.cells[300][0] = 999999;
  EXPECT_EQ(refusal(mesh), "heart.vtu, cell 17: found vertex 125; expected a number below the count of points, 125");
  mesh.cells[17][2] = std::numeric_limits<std::uint64_t>::max();  // -1 in the source
  EXPECT_THAT(refusal(mesh), HasSubstr("cell 17: found vertex 18446744073709551615"));
}

TEST(CleanMesh, refuses_a_mesh_without_cells_or_with_none_left) {
  NeutralMesh mesh;
  EXPECT_EQ(refusal(mesh), "heart.vtu: found no tetrahedra; expected at least one");
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.cells = {{0, 1, 2, 2}};
  EXPECT_THAT(refusal(mesh), HasSubstr("found 1 cells, all with a repeated vertex"));
}

TEST(CleanMesh, refuses_a_mesh_without_volume) {
  NeutralMesh mesh = tests::box_mesh({});
  for (auto& point : mesh.points) point[2] = 3.5;
  EXPECT_EQ(refusal(mesh), "heart.vtu: found z from 3.5 to 3.5; expected a box with volume");
}

TEST(CleanMesh, refuses_coordinates_that_no_product_can_hold) {
  NeutralMesh mesh = tests::box_mesh({});
  mesh.points[3][1] = -1e200;
  EXPECT_EQ(refusal(mesh), "heart.vtu, point 3: found coordinate -1e+200; expected at most 1e+100");
}

}  // namespace
}  // namespace rhoray::preprocess

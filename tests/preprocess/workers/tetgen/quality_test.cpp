#include "preprocess/workers/tetgen/quality.h"

#include <gmock/gmock.h>

#include "preprocess/tetrahedralize.h"
#include "tests/preprocess/workers/tetgen/surfaces.h"

namespace rhoray::tests {
namespace {

using preprocess::share_above;
using preprocess::tetrahedralize;
using testing::Contains;
using testing::HasSubstr;

/// A sphere whose first triangles each have a point a millionth of their size beside the middle of
/// an edge: needles, as in a scanned surface.
NeutralSurface sphere_with_needles(std::size_t needles) {
  NeutralSurface sphere, result;
  add_sphere(sphere, 1, 3);
  result.points = sphere.points;
  for (std::size_t facet = 0; facet + 1 < sphere.facet_offsets.size(); ++facet) {
    const std::uint64_t* c = sphere.facet_corners.data() + 3 * facet;
    if (facet >= needles) {
      add_facet(result, {c[0], c[1], c[2]});
      continue;
    }
    constexpr double beside = 1e-6;
    const std::uint64_t middle = result.points.size();
    Point& p = result.points.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] = (1 - beside) * (sphere.points[c[0]][axis] + sphere.points[c[1]][axis]) / 2 +
                beside * sphere.points[c[2]][axis];
    add_facet(result, {c[0], c[1], middle});
    add_facet(result, {c[1], c[2], middle});
    add_facet(result, {c[2], c[0], middle});
  }
  return result;
}

TEST(Quality, counts_the_cells_and_the_volume_above_a_ratio) {
  NeutralMesh mesh;
  // A corner of a cube: circumradius sqrt(3)/2, shortest edge 1; and one ten times as tall.
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -10}};
  mesh.cells = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  EXPECT_DOUBLE_EQ(share_above(mesh, 0.9).of_cells, 0.5);
  EXPECT_DOUBLE_EQ(share_above(mesh, 0.9).of_volume, 10.0 / 11);
  EXPECT_EQ(share_above(mesh, 0.8).of_cells, 1);
  EXPECT_EQ(share_above(mesh, 5.1).of_cells, 0) << "the tall one has sqrt(102)/2 = 5.05";
  EXPECT_EQ(share_above(mesh, 5.0).of_cells, 0.5);
  mesh.cells.push_back({0, 1, 2, 2});
  EXPECT_DOUBLE_EQ(share_above(mesh, 5.1).of_cells, 1.0 / 3) << "a flat cell is bad whatever the ratio";
  EXPECT_EQ(share_above({}, 1).of_cells, 0);
}

TEST(Quality, needles_of_a_scanned_surface_are_kept_and_the_inside_is_made_well_shaped) {
  const NeutralSurface surface = sphere_with_needles(40);
  const NeutralMesh mesh = tetrahedralize(surface, {.time_limit_s = 60});
  EXPECT_THAT(mesh.notes, Contains(HasSubstr("the surface's triangles were kept as they are; ")));
  EXPECT_LT(share_above(mesh, preprocess::usual_quality).of_volume, 0.1);
  EXPECT_LT(mesh.points.size(), 4 * surface.points.size());
  // Asked for it, TetGen splits them; these needles alone then take several times the surface's
  // points.
  const NeutralMesh split = tetrahedralize(surface, {.quality = preprocess::usual_quality, .tetgen = "S5000"});
  EXPECT_GT(split.points.size(), 2 * mesh.points.size());
  const NeutralMesh again = tetrahedralize(surface, {.time_limit_s = 60});
  EXPECT_EQ(again.points, mesh.points);
  EXPECT_EQ(again.cells, mesh.cells);
}

/// A sphere of triangles close to another one inside it: a thin shell, which a mesh of good quality
/// fills with very many cells.
NeutralSurface thin_shell() {
  NeutralSurface shell;
  add_sphere(shell, 1, 3);
  add_sphere(shell, 0.995, 3);
  return shell;
}

TEST(Quality, without_options_there_are_at_most_20_cells_for_each_triangle) {
  for (const NeutralSurface& surface :
       {box({0, 0, 0}, {1, 1, 1}), box({0, 0, 0}, {1, 1, 300}), box({0, 0, 0}, {1, 50, 0.01}), thin_shell(),
        sphere_with_needles(40), sphere_with_needles(1000)}) {
    const std::size_t triangles = surface.facet_offsets.size() - 1;
    const NeutralMesh mesh = tetrahedralize(surface, {.time_limit_s = 60});
    EXPECT_LE(mesh.cells.size(), 20 * triangles) << triangles;
    EXPECT_GT(mesh.cells.size(), triangles / 3);
    EXPECT_THAT(mesh.notes, Contains(HasSubstr("do not reach a quality of 1.4")));
  }
}

TEST(Quality, a_note_says_that_more_cells_would_be_better) {
  const NeutralSurface bar = box({0, 0, 0}, {1, 1, 300});
  EXPECT_THAT(tetrahedralize(bar).notes, Contains(HasSubstr("more than 20 cells per triangle")));
  const NeutralMesh good = tetrahedralize(bar, {.quality = 1.4});
  EXPECT_GT(good.cells.size(), 240U) << "a quality that is asked for has no such limit";
  EXPECT_LT(share_above(good, preprocess::usual_quality).of_volume, 0.1);
}

TEST(Quality, the_coarse_triangles_of_a_slender_part_are_split) {
  const NeutralSurface bar = box({0, 0, 0}, {1, 1, 20});
  const NeutralMesh mesh = tetrahedralize(bar);
  EXPECT_THAT(mesh.notes, Contains(HasSubstr("the surface's triangles were split; ")));
  EXPECT_LT(share_above(mesh, preprocess::usual_quality).of_volume, 0.1);
  EXPECT_GT(share_above(tetrahedralize(bar, {.tetgen = "Y"}), preprocess::usual_quality).of_volume, 0.1)
      << "kept would do as well: is this bar still slender?";
}

}  // namespace
}  // namespace rhoray::tests

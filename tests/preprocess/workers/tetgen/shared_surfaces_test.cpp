#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "formats/base/error.h"
#include "preprocess/import_mesh.h"
#include "preprocess/input_file.h"
#include "preprocess/tetrahedralize.h"
#include "tests/preprocess/workers/tetgen/surfaces.h"

namespace rhoray::tests {
namespace {

class SharedSurfaces : public testing::Test {
 protected:
  void SetUp() override {
    const char* shared = std::getenv("RHORAY_SHARED_DATA");
    if (shared == nullptr) GTEST_SKIP() << "RHORAY_SHARED_DATA does not name the folder of shared data";
    surfaces_ = std::filesystem::path(shared) / "surfaces";
  }
  NeutralSurface read(const char* name) const { return preprocess::import_surface(surfaces_ / name); }

  /// The refusal's text; its places must lie inside the surface's box.
  std::string refusal_with_places(const char* name) const {
    const NeutralSurface surface = read(name);
    try {
      preprocess::tetrahedralize(surface);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::invalid);
      const std::string text = error.what();
      int count = 0;
      for (std::size_t found = text.find(" at ("); found != std::string::npos; found = text.find(" at (", found + 1)) {
        Point place{};
        EXPECT_EQ(std::sscanf(text.c_str() + found, " at (%lf, %lf, %lf)", &place[0], &place[1], &place[2]), 3);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto [lo, hi] = std::minmax_element(surface.points.begin(), surface.points.end(),
                                                    [&](const Point& p, const Point& q) { return p[axis] < q[axis]; });
          EXPECT_GE(place[axis], (*lo)[axis]);
          EXPECT_LE(place[axis], (*hi)[axis]);
        }
        ++count;
      }
      EXPECT_EQ(count, 5);
      return text;
    }
    ADD_FAILURE() << name << " was filled";
    return {};
  }

  std::filesystem::path surfaces_;
};

TEST_F(SharedSurfaces, the_rabbit_heart_is_filled) {
  const NeutralSurface heart = read("rabbit_heart/rabbit_heart.ply");
  const double enclosed = std::abs(enclosed_volume(heart, 0, heart.facet_offsets.size() - 1));
  constexpr double limit = 2e-4;
  for (const bool limited : {false, true}) {
    const NeutralMesh mesh = preprocess::tetrahedralize(heart, {.quality = 0, .max_volume = limited ? limit : 0});
    double volume = 0;
    std::size_t too_large = 0;
    for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
      volume += cell_volume(mesh, cell);
      too_large += cell_volume(mesh, cell) > limit;
    }
    // TetGen merges facets that are coplanar to 1e-8 of the size and may turn an edge between them.
    EXPECT_NEAR(volume, enclosed, 1e-7 * enclosed);
    if (limited) {
      EXPECT_LT(too_large, mesh.cells.size() / 1000) << "smoothing at the end may enlarge some";
    } else {
      EXPECT_GT(too_large, mesh.cells.size() / 100) << "the limit limits nothing";
    }
  }
}

/// All surfaces that can be filled as they are; those with faults are refused before TetGen runs.
TEST_F(SharedSurfaces, are_filled_with_at_most_20_cells_for_each_triangle) {
  std::size_t filled = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(surfaces_)) {
    if (!entry.is_regular_file() || preprocess::foreign_kind(entry.path()) != preprocess::ForeignKind::surface)
      continue;
    const NeutralSurface surface = preprocess::import_surface(entry.path());
    const bool asks_for_volumes = std::any_of(surface.regions.begin(), surface.regions.end(),
                                              [](const auto& region) { return region.max_volume > 0; });
    if (asks_for_volumes) continue;
    try {
      const NeutralMesh mesh = preprocess::tetrahedralize(surface);
      const std::size_t triangles = surface.facet_corners.size() - 2 * (surface.facet_offsets.size() - 1);
      EXPECT_LE(mesh.cells.size(), 20 * triangles) << entry.path();
      ++filled;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::invalid) << entry.path() << ": " << error.what();
    }
  }
  EXPECT_GE(filled, 7U);
}

// CGAL's own search on the mesh (PMP::self_intersections) counts the same pairs here and in the
// gears.
TEST_F(SharedSurfaces, five_crossings_of_the_lung_lobe_are_named) {
  EXPECT_THAT(refusal_with_places("lungs/lul.stl"), testing::HasSubstr("surface: 5 pairs of facets intersect"));
}

TEST_F(SharedSurfaces, the_gears_cross_each_other_in_many_places) {
  EXPECT_THAT(refusal_with_places("gears.stl"), testing::HasSubstr("surface: 110 pairs of facets intersect"));
}

TEST_F(SharedSurfaces, the_example_of_tetgen_keeps_its_holes_and_regions) {
  NeutralSurface example = read("tetgen_example.poly");
  const auto count = [&] { return preprocess::tetrahedralize(example, {.quality = 0}).cells.size(); };
  EXPECT_EQ(count(), 28253u);  // as the program tetgen makes of it with -pq0aA
  for (auto& region : example.regions) region.max_volume = 0;
  EXPECT_EQ(count(), 68u);  // and with -pA
}

}  // namespace
}  // namespace rhoray::tests

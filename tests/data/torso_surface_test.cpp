#include "data/recipes/torso_surface.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <random>

#include "data/recipes/torso_scene.h"
#include "formats/base/error.h"
#include "preprocess/import_mesh.h"
#include "preprocess/tetrahedralize.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using recipes::make_torso_surface;
using recipes::TorsoSurface;

double cell_volume(const preprocess::NeutralMesh& mesh, std::size_t cell) {
  const auto p = [&](std::size_t i) {
    const auto& q = mesh.points[mesh.cells[cell][i]];
    return Vec3(q[0], q[1], q[2]);
  };
  return (p(1) - p(0)).cross(p(2) - p(0)).dot(p(3) - p(0)) / 6;
}

double enclosed_volume(const recipes::Triangulation& part) {
  double volume = 0;
  for (const auto& t : part.triangles) volume += part.points[t[0]].dot(part.points[t[1]].cross(part.points[t[2]])) / 6;
  return volume;
}

TEST(TorsoScene, shows_its_whole_surfaces_to_the_centres) {
  struct Body {
    double (*outside_by)(const Vec3&);
    Vec3 centre;
    double reach;
  };
  std::mt19937 random(20);
  std::normal_distribution<double> normal;
  for (const Body& body : {Body{recipes::torso::skin, recipes::torso::body_centre, 420},
                           Body{recipes::torso::heart, recipes::torso::heart_centre, 90},
                           Body{recipes::torso::left_lung, recipes::torso::left_lung_centre, 190},
                           Body{recipes::torso::right_lung, recipes::torso::right_lung_centre, 190}})
    for (int i = 0; i < 3000; ++i) {
      const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
      int changes = 0;
      bool inside = true;
      for (double r = 0; r <= body.reach; r += 2) {
        const bool still = body.outside_by(body.centre + r * direction) < 0;
        changes += still != inside;
        inside = still;
      }
      EXPECT_EQ(changes, 1) << "towards " << direction << " from " << body.centre;
    }
}

TEST(TorsoScene, keeps_its_organs_apart) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> x(-160, 160), y(-120, 120), z(250, 520);
  int in_lung = 0;
  for (int i = 0; i < 50000; ++i) {
    const Vec3 p(x(random), y(random), z(random));
    const bool left = recipes::torso::left_lung(p) < 0, right = recipes::torso::right_lung(p) < 0;
    EXPECT_FALSE(left && right);
    if (!left && !right) continue;
    ++in_lung;
    EXPECT_GT(recipes::torso::heart(p), 5);
    EXPECT_LT(recipes::torso::skin(p), -15);
    EXPECT_GT(recipes::torso::bone(p), 0);
  }
  EXPECT_GT(in_lung, 5000);
}

TEST(TorsoSurface, is_made_of_closed_oriented_spheres) {
  for (const auto& part : make_torso_surface(20'000).parts) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
    for (const auto& t : part.triangulation.triangles)
      for (std::size_t i = 0; i < 3; ++i) ++directed[{t[i], t[(i + 1) % 3]}];
    for (const auto& [edge, count] : directed) {
      ASSERT_EQ(count, 1) << part.name;
      ASSERT_TRUE(directed.contains({edge.second, edge.first})) << part.name;
    }
    const std::size_t points = part.triangulation.points.size(), triangles = part.triangulation.triangles.size();
    EXPECT_EQ(points + triangles, directed.size() / 2 + 2) << part.name << ": Euler's formula for a sphere";
    EXPECT_GT(enclosed_volume(part.triangulation), 0) << part.name << " is inside out";
  }
}

TEST(TorsoSurface, lies_on_the_formulas) {
  const TorsoSurface torso = make_torso_surface(20'000);
  double (*const outside_by[])(const Vec3&) = {recipes::torso::skin, recipes::torso::heart, recipes::torso::left_lung,
                                               recipes::torso::right_lung};
  ASSERT_EQ(torso.parts.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i)
    for (const Vec3& p : torso.parts[i].triangulation.points)
      EXPECT_NEAR(outside_by[i](p), 0, 1e-5) << torso.parts[i].name;
}

TEST(TorsoSurface, becomes_graded_tetrahedra_of_three_regions) {
  const TorsoSurface torso = make_torso_surface(20'000);
  const auto mesh = preprocess::tetrahedralize(torso.surface, {.quality = 1.4});
  EXPECT_NEAR(static_cast<double>(mesh.cells.size()), 20'000, 5'000);
  ASSERT_EQ(mesh.cell_fields.size(), 1u);

  std::map<int, double> by_region;
  std::vector<double> volumes;
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
    volumes.push_back(cell_volume(mesh, cell));
    by_region[static_cast<int>(mesh.cell_fields[0].values[cell])] += volumes.back();
  }
  const auto enclosed = [&](std::size_t part) { return enclosed_volume(torso.parts[part].triangulation); };
  const double inner = enclosed(1) + enclosed(2) + enclosed(3);
  EXPECT_NEAR(by_region[1], enclosed(0) - inner, 1e-9 * enclosed(0));
  EXPECT_NEAR(by_region[2], enclosed(1), 1e-9 * enclosed(0));
  EXPECT_NEAR(by_region[3], enclosed(2) + enclosed(3), 1e-9 * enclosed(0));

  std::sort(volumes.begin(), volumes.end());
  EXPECT_GT(volumes[volumes.size() * 95 / 100], 100 * volumes[volumes.size() * 5 / 100]);
}

TEST(TorsoSurface, is_written_as_it_was_made) {
  const TemporaryFolder folder;
  const TorsoSurface torso = make_torso_surface(5'000);
  recipes::write_torso_surface(torso, folder / "torso.smesh", true, false);
  const auto read = preprocess::import_surface(folder / "torso.smesh");
  EXPECT_EQ(read.points, torso.surface.points);
  EXPECT_EQ(read.point_sizes, torso.surface.point_sizes);
  EXPECT_EQ(read.facet_corners, torso.surface.facet_corners);
  EXPECT_EQ(read.facet_offsets, torso.surface.facet_offsets);
  ASSERT_EQ(read.regions.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(read.regions[i].seed, torso.surface.regions[i].seed);
    EXPECT_EQ(read.regions[i].attribute, torso.surface.regions[i].attribute);
  }
  const auto heart = preprocess::import_surface(folder / "torso_heart.ply");
  EXPECT_EQ(heart.points.size(), torso.parts[1].triangulation.points.size());
  EXPECT_EQ(heart.facet_offsets.size(), torso.parts[1].triangulation.triangles.size() + 1);
}

TEST(TorsoSurface, is_the_same_each_time) {
  EXPECT_EQ(make_torso_surface(5'000).surface.points, make_torso_surface(5'000).surface.points);
}

TEST(TorsoSurface, refuses_sizes_out_of_its_range) {
  EXPECT_THROW(make_torso_surface(1'000), Error);
}

}  // namespace
}  // namespace rhoray::tests

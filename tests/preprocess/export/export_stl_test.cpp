#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "preprocess/export_grid.h"
#include "preprocess/export_tets.h"
#include "preprocess/import_mesh.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "tests/preprocess/import/support.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

class ExportStl : public testing::Test {
 protected:
  ExportStl() { ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1); }
  TemporaryFolder folder_;
};

Vec3 point(const NeutralSurface& surface, std::uint64_t corner) {
  const auto& p = surface.points[corner];
  return {p[0], p[1], p[2]};
}

/// How often each edge runs one way more than the other: nothing is left of a closed surface whose
/// fronts agree.
std::size_t open_edges(const NeutralSurface& surface) {
  std::map<std::pair<std::uint64_t, std::uint64_t>, int> runs;
  for (std::size_t f = 0; f + 1 < surface.facet_offsets.size(); ++f)
    for (std::uint64_t c = 0; c < 3; ++c) {
      const std::uint64_t from = surface.facet_corners[surface.facet_offsets[f] + c];
      const std::uint64_t to = surface.facet_corners[surface.facet_offsets[f] + (c + 1) % 3];
      runs[std::minmax(from, to)] += from < to ? 1 : -1;
    }
  return static_cast<std::size_t>(
      std::count_if(runs.begin(), runs.end(), [](const auto& run) { return run.second != 0; }));
}

/// Of what a closed surface holds; negative when its fronts look inwards.
double enclosed_volume(const NeutralSurface& surface, const Vec3& from) {
  double sum = 0;
  for (std::size_t f = 0; f + 1 < surface.facet_offsets.size(); ++f) {
    const std::uint64_t first = surface.facet_offsets[f];
    const auto corner = [&](std::uint64_t c) { return point(surface, surface.facet_corners[first + c]) - from; };
    sum += corner(0).dot(corner(1).cross(corner(2))) / 6;
  }
  return sum;
}

constexpr double ball_volume = 4 * std::numbers::pi / 3;

/// 1 - distance from the middle of [-1.5, 1.5]^3: the unit ball is where it is not negative.
Field ball_field() {
  return [](const Vec3& p) { return 1 - p.length(); };
}

void expect_unit_ball(const NeutralSurface& surface, double coarseness) {
  EXPECT_EQ(open_edges(surface), 0U);
  EXPECT_NEAR(enclosed_volume(surface, {0, 0, 0}), ball_volume, coarseness);
}

TEST_F(ExportStl, of_a_grid_is_closed_and_its_corners_lie_where_the_samples_take_the_isovalue) {
  const Index3 count(25, 29, 31);
  const Box3 box({-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5});
  Affine mirrored = lattice_over(box, count);
  mirrored.x_axis = -mirrored.x_axis;
  mirrored.origin.x = 1.5;
  for (const Affine& map : {lattice_over(box, count), mirrored}) {
    const NeutralVolume volume = sampled_volume<float>(count, map, ball_field());
    pack_volume(volume, folder_ / "a.rho", {.replace_existing = true});
    const ExportReport report = export_grid_stl(folder_ / "a.rho", 0.1, folder_ / "a.stl", {.replace_existing = true});
    const NeutralSurface surface = import_surface(folder_ / "a.stl");
    EXPECT_EQ(surface.facet_offsets.size() - 1, report.triangle_count);
    EXPECT_EQ(report.file_bytes, 84 + 50 * report.triangle_count);
    EXPECT_EQ(open_edges(surface), 0U);
    EXPECT_NEAR(enclosed_volume(surface, {0, 0, 0}), ball_volume * 0.9 * 0.9 * 0.9, 0.05);
    const std::vector<double> values = values_of(volume);
    const Affine grid_from_world = map.inverse();
    for (std::uint64_t p = 0; p < surface.points.size(); ++p) {
      // On an edge of the grid: linear between its two samples.
      const Vec3 at = grid_from_world.point(point(surface, p));
      double expected = 0, weight_sum = 0;
      for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        std::int64_t n = 0;
        for (int axis = 2; axis >= 0; --axis) {
          const double low = std::min(std::floor(at[axis]), static_cast<double>(count[axis] - 2));
          weight *= corner >> axis & 1 ? at[axis] - low : 1 - (at[axis] - low);
          n = n * count[axis] + static_cast<std::int64_t>(low) + (corner >> axis & 1);
        }
        expected += weight * values[static_cast<std::size_t>(n)];
        weight_sum += weight;
      }
      ASSERT_NEAR(weight_sum, 1, 1e-9);
      ASSERT_NEAR(expected, 0.1, 1e-6);
    }
  }
}

TEST_F(ExportStl, of_a_grid_has_nothing_in_cells_without_data) {
  const Index3 count(12, 12, 12);
  const auto sample = [](const Index3& s) {
    if (s.x == 6 && s.y == 6) return std::numeric_limits<float>::quiet_NaN();
    return static_cast<float>(s.z) - 5.5F;
  };
  pack_volume(volume_of<float>(count, sample), folder_ / "a.rho");
  const ExportReport report = export_grid_stl(folder_ / "a.rho", 0, folder_ / "a.stl");
  EXPECT_EQ(report.triangle_count, 2U * (11 * 11 - 4));  // the four cells around the line without data are absent
  const NeutralSurface surface = import_surface(folder_ / "a.stl");
  for (std::uint64_t p = 0; p < surface.points.size(); ++p) EXPECT_EQ(surface.points[p][2], 5.5);
}

TEST_F(ExportStl, of_integers_takes_isovalues_between_them) {
  pack_volume(volume_of<std::uint8_t>({4, 5, 6}, [](const Index3& s) { return static_cast<std::uint8_t>(10 * s.x); }),
              folder_ / "a.rho");
  EXPECT_EQ(export_grid_stl(folder_ / "a.rho", 12.5, folder_ / "a.stl").triangle_count, 2U * 4 * 5);
  const NeutralSurface surface = import_surface(folder_ / "a.stl");
  for (const auto& p : surface.points) EXPECT_EQ(p[0], 1.25);
}

/// 20^3 samples around a sphere of radius 5.3 steps.
NeutralVolume sphere_at(const Vec3& origin, double spacing) {
  const auto distance = [](const Index3& s) {
    const auto from_middle = [](std::int64_t i) { return static_cast<double>(i) - 9.5; };
    return static_cast<float>(Vec3(from_middle(s.x), from_middle(s.y), from_middle(s.z)).length());
  };
  return volume_of<float>({20, 20, 20}, distance, axis_parallel_map({spacing, spacing, spacing}, origin));
}

/// Single precision has steps of 8 at 1e8, and of 64 at 1e9.
TEST_F(ExportStl, says_how_many_triangles_single_precision_loses_and_refuses_to_lose_all) {
  const auto exported = [&](const Vec3& origin, double spacing) {
    pack_volume(sphere_at(origin, spacing), folder_ / "a.rho", {.replace_existing = true});
    return export_grid_stl(folder_ / "a.rho", 5.3, folder_ / "a.stl", {.replace_existing = true});
  };
  const ExportReport whole = exported({0, 0, 0}, 1), cracked = exported({1e8, 0, 0}, 1);
  EXPECT_THAT(whole.notes, testing::IsEmpty());
  EXPECT_LT(cracked.triangle_count, whole.triangle_count);
  EXPECT_THAT(cracked.notes, testing::ElementsAre(testing::HasSubstr(
                                 concat(whole.triangle_count - cracked.triangle_count, " of ", whole.triangle_count,
                                        " triangles are too small for single precision"))));
  std::filesystem::remove(folder_ / "a.stl");
  expect_refusal([&] { exported({1e9, 1e9, 1e9}, 1); }, ErrorCode::unsupported, {"a.stl: no triangle is left"});
  expect_refusal([&] { exported({0, 0, 0}, 1e39); }, ErrorCode::unsupported, {"a.stl: found the coordinate "});
  pack_mesh(box_mesh({.box = Box3({1e9, 1e9, 1e9}, {1e9 + 1, 1e9 + 1, 1e9 + 1})}, ball_field()), folder_ / "m.rho");
  expect_refusal([&] { export_tets_stl(folder_ / "m.rho", std::nullopt, folder_ / "a.stl"); }, ErrorCode::unsupported,
                 {"a.stl: no triangle is left"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.stl"));
}

TEST_F(ExportStl, of_tetrahedra_is_closed_and_its_corners_lie_on_edges_where_the_field_takes_the_isovalue) {
  const NeutralMesh mesh =
      box_mesh({.cells = {16, 16, 16}, .box = Box3({-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}), .jitter = 0.1}, ball_field());
  pack_mesh(mesh, folder_ / "m.rho");
  const ExportReport report = export_tets_stl(folder_ / "m.rho", 0.0, folder_ / "m.stl");
  const NeutralSurface surface = import_surface(folder_ / "m.stl");
  EXPECT_EQ(surface.facet_offsets.size() - 1, report.triangle_count);
  expect_unit_ball(surface, 0.12);
  // Another road: crossings of all edges, rounded as the file rounds them.
  std::vector<std::array<double, 3>> crossings;
  for (const auto& cell : mesh.cells)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b) {
        const double from = mesh.point_fields[0].values[cell[a]], to = mesh.point_fields[0].values[cell[b]];
        if (!(from >= 0 && to < 0)) continue;
        std::array<double, 3> p;
        for (std::size_t axis = 0; axis < 3; ++axis)
          p[axis] = mesh.points[cell[a]][axis] +
                    from / (from - to) * (mesh.points[cell[b]][axis] - mesh.points[cell[a]][axis]);
        crossings.push_back(p);
      }
  const auto is_crossing = [&](const std::array<double, 3>& p) {
    return std::any_of(crossings.begin(), crossings.end(), [&](const auto& q) {
      return std::abs(p[0] - q[0]) < 1e-6 && std::abs(p[1] - q[1]) < 1e-6 && std::abs(p[2] - q[2]) < 1e-6;
    });
  };
  for (std::uint64_t p = 0; p < surface.points.size(); p += 17) EXPECT_TRUE(is_crossing(surface.points[p])) << p;
}

TEST_F(ExportStl, of_tetrahedra_without_an_isovalue_is_their_own_surface_seen_from_outside) {
  const NeutralMesh mesh = box_mesh({.cells = {3, 4, 5}, .box = Box3({0, 0, 0}, {1, 2, 3})}, ball_field());
  pack_mesh(mesh, folder_ / "m.rho");
  const ExportReport report = export_tets_stl(folder_ / "m.rho", std::nullopt, folder_ / "m.stl");
  EXPECT_EQ(report.triangle_count, 2U * 2 * (3 * 4 + 4 * 5 + 3 * 5));
  const NeutralSurface surface = import_surface(folder_ / "m.stl");
  EXPECT_EQ(open_edges(surface), 0U);
  EXPECT_NEAR(enclosed_volume(surface, {0.5, 0.5, 0.5}), 6, 1e-6);
}

TEST_F(ExportStl, of_tetrahedra_leaves_out_cells_without_data_and_refuses_unknown_fields) {
  NeutralMesh mesh = box_mesh({}, [](const Vec3& p) { return p.z; });
  pack_mesh(mesh, folder_ / "m.rho");
  const std::uint64_t all = export_tets_stl(folder_ / "m.rho", 0.3, folder_ / "m.stl").triangle_count;
  mesh.point_fields[0].values[0] = std::numeric_limits<double>::infinity();
  for (double& value : mesh.point_fields[0].values)
    if (value < 0.3) value = std::numeric_limits<double>::quiet_NaN();
  pack_mesh(mesh, folder_ / "n.rho");
  EXPECT_GT(all, 0U);
  EXPECT_EQ(export_tets_stl(folder_ / "n.rho", 0.3, folder_ / "n.stl").triangle_count, 0U);
  expect_refusal([&] { export_tets_stl(folder_ / "m.rho", 0.3, folder_ / "x.stl", {.field = "heat"}); },
                 ErrorCode::usage, {"'heat'", "'value'"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.stl"));
}

}  // namespace
}  // namespace rhoray::preprocess

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "tests/tools/workbench.h"
#include "tools/analysis/enclosed.h"

namespace rhoray::tests {
namespace {

using tools::Enclosed;

/// A packed grid of doubles with f at the samples' positions in the world.
formats::PackedFile packed_grid(const auto& folder, const Index3& count, const Affine& world, const auto& f) {
  preprocess::NeutralVolume volume;
  volume.sample_count = count;
  volume.type = formats::ElementType::F64;
  volume.world_from_grid = world;
  std::vector<double> values;
  for (int k = 0; k < count.z; ++k)
    for (int j = 0; j < count.y; ++j)
      for (int i = 0; i < count.x; ++i) values.push_back(f(world.point({double(i), double(j), double(k)})));
  const auto bytes = std::as_bytes(std::span(values));
  volume.owned_samples.assign(bytes.begin(), bytes.end());
  volume.samples = volume.owned_samples;
  volume.field_name = "f";
  preprocess::pack_volume(volume, folder / "grid.rho", {.replace_existing = true});
  return formats::PackedFile::open(folder / "grid.rho");
}

Enclosed measured(const formats::PackedFile& file, double isovalue, double share = 1e-3) {
  return tools::measure_enclosed(file, {.isovalue = isovalue, .undecided_share = share});
}

TEST(Measure, finds_half_spaces_to_rounding) {
  const TemporaryFolder folder;
  const Affine world{{0.5, 0, 0}, {0, 2, 0}, {0, 0, 1}, {-1, 3, 0}};
  const auto file = packed_grid(folder, {9, 5, 6}, world, [](const Vec3& p) { return p.x; });
  const Enclosed found = measured(file, 0.3);
  EXPECT_NEAR(found.whole_volume, 4.0 * 8 * 5, 1e-12);
  EXPECT_NEAR(found.volume, 2.7 * 8 * 5, 1e-11);
  EXPECT_LE(std::abs(found.volume - 2.7 * 8 * 5), found.volume_error);
  EXPECT_LE(found.volume_error, 1e-10);
  EXPECT_NEAR(found.area, 8 * 5, 1e-11);
  EXPECT_EQ(found.crossed_cells, 4U * 5);
}

/// Cells whose corners all are the isovalue, as inside a mask, lie inside.
TEST(Measure, takes_plateaus_at_the_isovalue_as_inside) {
  const TemporaryFolder folder;
  const auto flat = packed_grid(folder, {4, 4, 4}, {}, [](const Vec3&) { return 3; });
  EXPECT_EQ(measured(flat, 3).volume, 27);
  EXPECT_LE(measured(flat, 3).volume_error, 1e-9);
  EXPECT_EQ(measured(flat, std::nextafter(3, 4)).volume, 0);
  const auto mask = packed_grid(folder, {7, 7, 7}, {}, [](const Vec3& p) {
    return std::min({p.x, p.y, p.z}) >= 1 && std::max({p.x, p.y, p.z}) <= 5 ? 1 : 0;
  });
  const Enclosed found = measured(mask, 1);
  EXPECT_LE(std::abs(found.volume - 64), found.volume_error);
  EXPECT_LE(found.volume_error, 1) << "only of the cells around";
}

/// In one cell with f = x y, f is at least c in a volume of 1 - c + c ln c.
TEST(Measure, encloses_the_volume_of_a_trilinear_cell) {
  const TemporaryFolder folder;
  const auto file = packed_grid(folder, {2, 2, 2}, {}, [](const Vec3& p) { return p.x * p.y; });
  for (const double c : {0.01, 0.2, 0.5, 0.9}) {
    const double exact = 1 - c + c * std::log(c);
    for (const double share : {0.1, 1e-3}) {
      const Enclosed found = measured(file, c, share);
      EXPECT_LE(std::abs(found.volume - exact), found.volume_error) << c << " " << share;
      EXPECT_LE(found.volume_error, 0.6 * share) << c << " " << share;
    }
  }
}

TEST(Measure, encloses_the_volume_where_all_coefficients_are_mixed) {
  // f = x y z: at least c in 1 - c (1 - ln c + (ln c)^2 / 2).
  const TemporaryFolder folder;
  const auto file = packed_grid(folder, {2, 2, 2}, {}, [](const Vec3& p) { return p.x * p.y * p.z; });
  for (const double c : {0.05, 0.3, 0.7}) {
    const double l = std::log(c), exact = 1 - c * (1 - l + l * l / 2);
    const Enclosed found = measured(file, c);
    EXPECT_LE(std::abs(found.volume - exact), found.volume_error) << c;
    EXPECT_LE(found.volume_error, 1e-3) << c;
  }
}

TEST(Measure, comes_near_a_ball_in_grids_and_meshes) {
  const TemporaryFolder folder;
  const auto far = [](const Vec3& p) { return 1 - (p - Vec3(8, 8, 8)).length(); };
  const double radius = 6, ball = 4.0 / 3 * std::numbers::pi * radius * radius * radius;
  const double sphere = 4 * std::numbers::pi * radius * radius;
  const Enclosed grid = measured(packed_grid(folder, {17, 17, 17}, {}, far), 1 - radius);
  // The trilinear field differs from the distance by at most 3/8 of a squared step over the radius.
  EXPECT_NEAR(grid.volume, ball, 0.02 * ball);
  EXPECT_NEAR(grid.area, sphere, 0.02 * sphere);
  EXPECT_LE(grid.volume_error, 1e-3 * ball);
}

TEST(Measure, takes_linear_fields_of_meshes_exactly) {
  const Workbench bench;
  bench.make_box();
  const auto file = formats::PackedFile::open(bench / "box.rho");
  const Enclosed found = tools::measure_enclosed(file, {.field = "height", .isovalue = 0.3});
  EXPECT_NEAR(found.whole_volume, 1, 1e-12);
  EXPECT_LE(std::abs(found.volume - 0.7), found.volume_error);
  EXPECT_LE(found.volume_error, 1e-11);
  EXPECT_NEAR(found.area, 1, 1e-6);  // the values are floats
}

/// The differences of these values are beyond the largest double.
TEST(Measure, takes_values_of_any_size) {
  preprocess::NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.cells = {{0, 1, 2, 3}};
  mesh.point_fields.push_back({.name = "f",
                               .unit = {},
                               .component_count = 1,
                               .was_single_precision = false,
                               .values = {-1.7e308, -1.7e308, -1.7e308, 1.7e308}});
  const TemporaryFolder folder;
  preprocess::pack_mesh(mesh, folder / "tet.rho", {});
  const Enclosed tet = measured(formats::PackedFile::open(folder / "tet.rho"), 0);
  EXPECT_LE(std::abs(tet.volume - 1.0 / 48), tet.volume_error);
  EXPECT_LE(tet.volume_error, 1e-13);
  EXPECT_NEAR(tet.area, 1.0 / 8, 1e-13);
  const auto file =
      packed_grid(folder, {2, 2, 2}, {}, [](const Vec3& p) { return p.x * p.y != p.z ? 1.7e308 : -1.7e308; });
  const Enclosed same =
      measured(packed_grid(folder, {2, 2, 2}, {}, [](const Vec3& p) { return p.x * p.y != p.z ? 1.7 : -1.7; }), 0);
  const Enclosed grid = measured(file, 0);
  EXPECT_NEAR(grid.volume, same.volume, 1e-12);
  EXPECT_NEAR(grid.area, same.area, 1e-12);
}

/// The products of the determinant cancel: the volume is the exact determinant of these doubles,
/// 3 * 0.2 - 6 * 0.1 with their rounding, times 125 cells.
TEST(Measure, bounds_the_volume_of_sheared_cells) {
  const TemporaryFolder folder;
  const double a = 0.1, b = 0.2, c = 0.3, d = 0.6000000000000003;
  const auto file =
      packed_grid(folder, {6, 6, 6}, {{a, b, 0}, {c, d, 0}, {0, 0, 1}, {0, 0, 0}}, [](const Vec3&) { return 1.0; });
  const Enclosed found = measured(file, 0.5);
  // Each product is rounded once; fma gives what the rounding lost.
  const double ad = a * d, bc = b * c;
  const double exact = 125 * std::abs((ad - bc) + (std::fma(a, d, -ad) - std::fma(b, c, -bc)));
  EXPECT_LE(std::abs(found.whole_volume - exact), found.volume_error);
  EXPECT_LE(std::abs(found.volume - exact), found.volume_error);
}

TEST(Measure, counts_cells_without_data_as_outside) {
  const TemporaryFolder folder;
  const auto file = packed_grid(
      folder, {4, 2, 2}, {}, [](const Vec3& p) { return p.x < 0.5 ? std::numeric_limits<double>::quiet_NaN() : 1.0; });
  const Enclosed found = measured(file, 0.5);
  EXPECT_EQ(found.cells_without_data, 1U);
  EXPECT_NEAR(found.volume, 2, 1e-13);
}

TEST(Measure, says_where_no_cell_has_data) {
  const Workbench bench;
  packed_grid(bench, {2, 2, 2}, {},
              [](const Vec3& p) { return p.x < 0.5 && p.y < 0.5 ? std::numeric_limits<double>::quiet_NaN() : p.x; });
  const RunResult text = bench.rhoray({"measure", "grid.rho", "--iso", "0.5"});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("no cell has data"), std::string::npos) << text.out;
}

TEST(Measure, prints_volume_and_area) {
  const Workbench bench;
  bench.make_box();
  const RunResult text = bench.rhoray({"measure", "box.rho", "--field", "height", "--iso", "0.3"});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("(proven)"), std::string::npos) << text.out;
  const auto json =
      nlohmann::json::parse(bench.rhoray({"measure", "box.vtu", "--field", "height", "--iso", "0.3", "--json"}).out);
  EXPECT_NEAR(json["volume"].get<double>(), 0.7, 1e-7);
}

}  // namespace
}  // namespace rhoray::tests

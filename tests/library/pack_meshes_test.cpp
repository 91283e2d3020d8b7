// Arrays of points and indices become meshes and surfaces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

template <class Arrays>
std::string bytes_packed(const Arrays& arrays) {
  const TemporaryFolder folder;
  pack(arrays, {.file = folder / "packed.rho"});
  return read_file(folder / "packed.rho");
}

TEST(PackMesh, takes_indices_of_any_integers_and_strides) {
  const MadeMesh mesh = box_mesh(3);
  const std::vector<double> x = mesh.point_values([](const Vec3& p) { return p.x; });
  MeshArrays arrays = mesh.arrays();
  arrays.point_fields = {{.name = "x", .values = std::span<const double>(x)}};
  const std::string expected = bytes_packed(arrays);
  const auto with = [&]<class T>(T) {
    const std::vector<T> indices(mesh.tetrahedra.begin(), mesh.tetrahedra.end());
    arrays.tetrahedra = {std::span<const T>(indices), {mesh.cell_count(), 4}};
    EXPECT_TRUE(bytes_packed(arrays) == expected) << sizeof(T) << std::is_signed_v<T>;
  };
  with(std::int8_t{}), with(std::uint8_t{}), with(std::int16_t{}), with(std::uint16_t{});
  with(std::int32_t{}), with(std::uint32_t{}), with(std::int64_t{}), with(std::uint64_t{});
  // Columns first, as Fortran stores them; points in records with something else.
  std::vector<std::int32_t> columns;
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t cell = 0; cell < mesh.tetrahedra.size() / 4; ++cell)
      columns.push_back(static_cast<std::int32_t>(mesh.tetrahedra[4 * cell + column]));
  const std::array<std::int64_t, 2> cells{mesh.cell_count(), 4}, cell_strides{4, 4 * mesh.cell_count()};
  arrays.tetrahedra = ArrayView(columns.data(), ElementType::I32, cells, cell_strides);
  std::vector<double> records;
  for (std::int64_t p = 0; p < mesh.point_count(); ++p)
    records.insert(records.end(), {-7, mesh.point(p).z, mesh.point(p).y, mesh.point(p).x});
  const std::array<std::int64_t, 2> points{mesh.point_count(), 3}, point_strides{32, -8};
  arrays.points = ArrayView(records.data() + 3, ElementType::F64, points, point_strides);
  EXPECT_TRUE(bytes_packed(arrays) == expected);
}

TEST(PackMesh, keeps_fields_of_points_and_cells) {
  const Dataset data = ball_mesh();
  EXPECT_EQ(data.kind(), DataKind::tetrahedra);
  EXPECT_EQ(data.length_unit(), "mm");
  ASSERT_EQ(data.fields().size(), 3U);
  EXPECT_EQ(data.fields()[0].name, "radius");
  EXPECT_TRUE(data.field("part").is_of_cells);
  EXPECT_EQ(data.field("part").label_names.at(2), "right");
  EXPECT_EQ(data.field("part").range, (Interval{1, 2}));
  EXPECT_EQ(data.field("x").range, (Interval{-1, 1}));
  EXPECT_EQ(data.bounds(), (Box3{{-1, -1, -1}, {1, 1, 1}}));
}

TEST(PackMesh, takes_fields_of_any_numbers) {
  const MadeMesh mesh = box_mesh(2);
  MeshArrays arrays = mesh.arrays();
  std::vector<double> values(static_cast<std::size_t>(mesh.point_count()));
  std::iota(values.begin(), values.end(), 3);
  const auto with = [&]<class T>(T) {
    const std::vector<T> same(values.begin(), values.end());
    arrays.point_fields = {{.name = "f", .values = std::span<const T>(same), .unit = "K"}};
    const Dataset data = pack(arrays);
    EXPECT_EQ(data.field().range, (Interval{3, 29}));
    EXPECT_EQ(data.field().unit, "K");
    const std::array<double, 3> corner{1, 1, 1};
    double value = 0;
    FieldSampler(data).at({std::span<const double>(corner), {1, 3}}, {&value, 1});
    EXPECT_EQ(value, 29);
  };
  with(std::int8_t{}), with(std::uint8_t{}), with(std::int16_t{}), with(std::uint16_t{});
  with(std::int32_t{}), with(std::uint32_t{}), with(std::int64_t{}), with(std::uint64_t{});
  with(float{}), with(double{});
}

TEST(PackMesh, without_fields_shows_its_boundary) {
  const Dataset data = pack(box_mesh(2).arrays());
  Scene scene{.layers = {{.data = data.boundary(), .show = Triangles{}}}};
  scene.camera = fit_camera(scene, {40, 30});
  RenderContext context;
  Picture picture;
  EXPECT_GT(context.render(scene, {.size = {40, 30}}, picture).statistics.hits, 300U);
}

TEST(PackMesh, refuses_a_cell_field_with_the_name_of_a_point_field) {
  const MadeMesh mesh = box_mesh(2);
  MeshArrays arrays = mesh.arrays();
  const std::vector<double> points(static_cast<std::size_t>(mesh.point_count()), 1);
  const std::vector<double> cells(static_cast<std::size_t>(mesh.cell_count()), 2);
  arrays.point_fields = {{.name = "f", .values = std::span<const double>(points)}};
  arrays.cell_fields = {{.name = "f", .values = std::span<const double>(cells)}};
  expect_refused(ErrorCode::usage, "MeshArrays::cell_fields[0].name: 'f' occurs twice", [&] { pack(arrays); });
}

TEST(PackMesh, with_cell_fields_only_averages_them_to_points) {
  const MadeMesh mesh = box_mesh(2);
  MeshArrays arrays = mesh.arrays();
  const std::vector<float> part(static_cast<std::size_t>(mesh.cell_count()), 2);
  arrays.cell_fields = {{.name = "part", .values = std::span<const float>(part)}};
  const Dataset data = pack(arrays);
  EXPECT_EQ(data.field("part").range, (Interval{2, 2}));
}

TEST(PackMesh, takes_cells_of_negative_volume) {
  const auto bits = [](const MadeMesh& mesh) {
    const std::vector<double> x = mesh.point_values([](const Vec3& p) { return p.x + p.y; });
    MeshArrays arrays = mesh.arrays();
    arrays.point_fields = {{.name = "x", .values = std::span<const double>(x)}};
    const Scene scene = certified_scene(pack(arrays), 0.7, {40, 30});
    return bits_of(rendered(scene, {.size = {40, 30}, .channels = {.depth = true, .cell = true}}));
  };
  MadeMesh turned = box_mesh(2);
  for (std::size_t cell = 0; cell < turned.tetrahedra.size(); cell += 8)
    std::swap(turned.tetrahedra[cell], turned.tetrahedra[cell + 1]);
  EXPECT_TRUE(bits(turned) == bits(box_mesh(2)));
}

TEST(PackMesh, in_memory_and_in_a_file_makes_the_same_bytes) {
  const TemporaryFolder folder;
  ball_mesh(4).save(folder / "saved.rho");
  ball_mesh(4, {.file = folder / "file.rho"});
  EXPECT_TRUE(read_file(folder / "saved.rho") == read_file(folder / "file.rho"));
  octahedron().save(folder / "o.rho");
  octahedron({.file = folder / "octahedron.rho"});
  EXPECT_TRUE(read_file(folder / "o.rho") == read_file(folder / "octahedron.rho"));
}

TEST(PackSurface, keeps_its_triangles) {
  const Dataset data = octahedron();
  EXPECT_EQ(data.kind(), DataKind::triangles);
  EXPECT_TRUE(data.fields().empty());
  EXPECT_EQ(data.bounds(), (Box3{{-1, -1, -1}, {1, 1, 1}}));
  MadeRays rays;
  rays.add({5, 0.2, 0.1}, {-2, 0, 0});
  rays.add({5, 0.7, 0.7}, {-2, 0, 0});
  double t[2];
  std::uint8_t is_hit[2];
  RayScratch scratch;
  const RayCaster caster(data, Triangles{}, Accuracy::float64);
  caster.first_hits(rays.rays(), {.t = t}, scratch);
  caster.any_hits(rays.rays(), is_hit, scratch);
  EXPECT_NEAR(t[0], (5 - 0.7) / 2, 1e-6);
  EXPECT_TRUE(std::isinf(t[1]));
  EXPECT_EQ(is_hit[0], 1);
  EXPECT_EQ(is_hit[1], 0);
}

}  // namespace
}  // namespace rhoray::tests

#include "render/triangles/mesh_boundary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "formats/base/error.h"
#include "formats/mesh_boundary.h"
#include "preprocess/pack_surface.h"
#include "render/dataset/loaded_dataset.h"
#include "render/ray_caster.h"
#include "tests/agreement/pictures.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/expect_error.h"

/// The boundary of a mesh as a surface with the fields of its cells.
namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::Layer;
using render::Mode;
using render::Scene;

double linear(const Vec3& p) {
  return 3 * p.x - 2 * p.y + 0.5 * p.z + 7;
}

struct Meshes {
  TemporaryFolder folder;
  preprocess::NeutralMesh neutral = box_mesh({.cells = {5, 4, 3}, .box = {{10, -2, 3}, {12, 0, 4}}, .jitter = 0.1});
  render::Dataset mesh, boundary;

  explicit Meshes(preprocess::MeshStructure structure = preprocess::MeshStructure::clusters)
      : mesh(made(structure)), boundary(mesh.boundary()) {}

 private:
  render::Dataset made(preprocess::MeshStructure structure) {
    add_point_field(neutral, "linear", linear);
    add_point_field(neutral, "square", [](const Vec3& p) { return p.x * p.x; });
    return packed(folder, "m.rho", neutral, {.structure = structure});
  }
};

Scene scene_of(const render::Dataset& dataset, const std::string& field = {}) {
  Layer layer{.mode = Mode::triangles, .method = render::default_method(dataset, Mode::triangles)};
  if (!field.empty())
    layer.material.color_by = render::FieldColors{.field = field, .range = dataset.field(field)->range};
  Scene scene;
  scene.layers = {layer};
  scene.camera = render::fit_camera(dataset.bounds(), {.azimuth_deg = 33, .elevation_deg = 21}, 1);
  return scene;
}

/// The boundary as a packed surface: triangles in world coordinates.
render::Dataset as_surface(const Meshes& meshes) {
  const auto& view = std::get<render::TriangleData>(meshes.boundary.implementation().view);
  const render::MeshBoundary& of = *view.boundary();
  const Affine& world_from_data = meshes.mesh.implementation().world_from_data;
  preprocess::NeutralSurface surface;
  for (const auto& point : of.points) surface.points.push_back(to_array(world_from_data.point(to_vec3(point))));
  for (const auto& triangle : of.triangles) {
    for (const std::uint32_t corner : triangle) surface.facet_corners.push_back(corner);
    surface.facet_offsets.push_back(surface.facet_corners.size());
  }
  preprocess::pack_surface(surface, meshes.folder / "s.rho");
  return render::Dataset::load(meshes.folder / "s.rho");
}

TEST(MeshBoundary, is_the_same_for_all_copies_of_a_mesh_while_it_is_in_use) {
  const Meshes meshes;
  const render::Dataset copy = meshes.mesh;
  EXPECT_EQ(&copy.boundary().implementation(), &meshes.boundary.implementation());
  EXPECT_NE(&Meshes().boundary.implementation(), &meshes.boundary.implementation());
}

TEST(MeshBoundary, is_a_surface_with_the_fields_of_the_mesh) {
  const Meshes meshes;
  EXPECT_TRUE(meshes.boundary.is_surface());
  EXPECT_FALSE(meshes.boundary.is_mesh());
  EXPECT_TRUE(meshes.mesh.is_mesh());
  EXPECT_TRUE(meshes.boundary.has_fields());
  EXPECT_EQ(meshes.boundary.field_names(), meshes.mesh.field_names());
  EXPECT_EQ(meshes.boundary.field().name, "linear");
  EXPECT_EQ(meshes.boundary.bounds(), meshes.mesh.bounds());
  expect_error(ErrorCode::usage, "has no boundary", [&] { (void)meshes.boundary.boundary(); });
}

TEST(MeshBoundary, is_seen_where_the_same_triangles_are_seen) {
  const Meshes meshes;
  const render::Dataset surface = as_surface(meshes);
  for (const render::Accuracy accuracy : {render::Accuracy::float32, render::Accuracy::float64})
    for (const render::Normals normals : {render::Normals::exact, render::Normals::smooth}) {
      Scene scene = scene_of(meshes.boundary);
      scene.layers[0].method = render::method_of(accuracy);
      scene.layers[0].material.normals = normals;
      const Framebuffer found = picture(meshes.boundary, scene), expected = picture(surface, scene);
      ASSERT_GT(hit_count(found), 2000U);
      std::size_t others = 0;
      for (std::size_t p = 0; p < found.pixel_count(); ++p) {
        ASSERT_EQ(std::isfinite(found.depth[p]), std::isfinite(expected.depth[p])) << p;
        if (!std::isfinite(found.depth[p])) continue;
        // The frames differ by the mesh's origin, and float moves points by 2^-25 of the box.
        EXPECT_NEAR(found.depth[p], expected.depth[p], 1e-5) << p;
        for (std::size_t c = 0; c < 3; ++c)
          others += std::abs(found.color[4 * p + c] - expected.color[4 * p + c]) > 1e-3F ? 1 : 0;
      }
      EXPECT_LT(others, 30U) << "at edges either triangle may be met";
    }
}

TEST(MeshBoundary, shows_fields_exactly_and_the_ids_of_cells) {
  for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves}) {
    const Meshes meshes(structure);
    const auto& view = std::get<render::TriangleData>(meshes.boundary.implementation().view);
    std::set<std::uint64_t> owners;
    for (std::uint32_t t = 0; t < view.triangle_count(); ++t) owners.insert(view.cell_id(t));
    for (const render::Normals normals : {render::Normals::exact, render::Normals::smooth}) {
      Scene scene = scene_of(meshes.boundary, "linear");
      scene.layers[0].material.normals = normals;
      scene.layers[0].method = render::method_of(render::Accuracy::float64);
      const Framebuffer found = picture(meshes.boundary, scene);
      const std::vector<render::Ray> rays = camera_rays(meshes.boundary, scene.camera, 96, 96);
      const Affine& world_from_data = meshes.mesh.implementation().world_from_data;
      std::size_t hits = 0;
      for (std::size_t p = 0; p < found.pixel_count(); ++p) {
        if (!std::isfinite(found.depth[p])) {
          EXPECT_TRUE(std::isnan(found.value[p]));
          continue;
        }
        ++hits;
        const Vec3 place = world_from_data.point(rays[p].origin + double{found.depth[p]} * rays[p].direction);
        // The depth is a float: it moves the place by 2^-24 of the camera's distance.
        ASSERT_NEAR(found.value[p], linear(place), 1e-5) << p;
        EXPECT_TRUE(owners.contains(found.cell[p])) << p;
      }
      EXPECT_GT(hits, 2000U);
    }
  }
}

TEST(MeshBoundary, shows_one_value_in_each_cell_of_a_field_of_cells) {
  Meshes meshes;
  preprocess::NeutralField field{.name = "number", .unit = {}, .was_single_precision = false, .values = {}};
  for (std::size_t c = 0; c < meshes.neutral.cells.size(); ++c) field.values.push_back(0.5 * static_cast<double>(c));
  meshes.neutral.cell_fields.push_back(field);
  for (const bool averages : {false, true})
    for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves}) {
      const render::Dataset mesh =
          packed(meshes.folder, concat("cells", averages, ".rho"), meshes.neutral,
                 {.cells_to_points = averages, .structure = structure, .replace_existing = true});
      EXPECT_EQ(mesh.color_names(), (std::vector<std::string>{"linear", "square", "number"}));
      EXPECT_EQ(mesh.field_names().size(), averages ? 3U : 2U);
      ASSERT_TRUE(mesh.field("number"));
      EXPECT_EQ(mesh.field("number")->range.hi, 0.5 * static_cast<double>(meshes.neutral.cells.size() - 1));
      const render::Dataset boundary = mesh.boundary();
      const Framebuffer on_boundary = picture(boundary, scene_of(boundary, "number"));
      EXPECT_GT(hit_count(on_boundary), 2000U);
      for (std::size_t p = 0; p < on_boundary.pixel_count(); ++p)
        if (std::isfinite(on_boundary.depth[p])) {
          ASSERT_EQ(on_boundary.value[p], 0.5 * static_cast<double>(on_boundary.cell[p])) << p;
        }
    }
}

TEST(MeshBoundary, isosurfaces_are_coloured_by_fields_of_cells_too) {
  Meshes meshes;
  preprocess::NeutralField field{.name = "side", .unit = {}, .was_single_precision = true, .values = {}};
  for (const auto& cell : meshes.neutral.cells) {
    double x = 0;
    for (const std::uint64_t v : cell) x += meshes.neutral.points[v][0] / 4;
    field.values.push_back(x < 11 ? 0 : 1);
  }
  meshes.neutral.cell_fields.push_back(field);
  const render::Dataset mesh = packed(meshes.folder, "sides.rho", meshes.neutral);
  Scene scene = scene_of(mesh);
  scene.layers[0].mode = Mode::isosurface;
  scene.layers[0].isovalue = linear({11, -1, 3.5});
  scene.layers[0].material.specular = 0;
  scene.layers[0].material.color_by =
      render::FieldColors{.field = "side", .map = render::ColorMap::gray, .range = {0, 1}};
  const Framebuffer found = picture(mesh, scene);
  std::size_t dark = 0, bright = 0;
  for (std::size_t p = 0; p < found.pixel_count(); ++p) {
    if (!std::isfinite(found.depth[p])) continue;
    const bool is_dark = meshes.neutral.cell_fields[0].values[found.cell[p]] == 0;
    (is_dark ? dark : bright) += 1;
    if (is_dark)
      EXPECT_EQ(found.color[4 * p], 0) << p;
    else
      EXPECT_GT(found.color[4 * p], 0.05F) << p;
  }
  EXPECT_GT(dark, 100U);
  EXPECT_GT(bright, 100U);
}

TEST(MeshBoundary, keeps_the_range_of_a_field_in_every_triangle) {
  const Meshes meshes;
  Scene scene = scene_of(meshes.boundary, "square");
  const Framebuffer found = picture(meshes.boundary, scene);
  for (std::size_t p = 0; p < found.pixel_count(); ++p)
    if (std::isfinite(found.depth[p])) {
      // The weights add up to 1 but for rounding.
      EXPECT_GE(found.value[p], 100 * (1 - 1e-14));
      EXPECT_LE(found.value[p], 144 * (1 + 1e-14));
    }
}

TEST(MeshBoundary, of_a_file_without_it_is_the_same) {
  const Meshes meshes;
  const formats::TetMesh packed_mesh(formats::PackedFile::open(meshes.folder / "m.rho"));
  ASSERT_FALSE(packed_mesh.boundary().empty());
  const formats::FaceNumbers computed = formats::computed_boundary_faces(packed_mesh);
  EXPECT_TRUE(
      std::equal(computed.begin(), computed.end(), packed_mesh.boundary().begin(), packed_mesh.boundary().end()));
}

TEST(MeshBoundary, of_a_closed_mesh_is_empty_and_never_hit) {
  // The five tetrahedra between five points: each face belongs to two of them.
  preprocess::NeutralMesh closed;
  closed.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.2, 0.1}};
  for (std::uint64_t absent = 0; absent < 5; ++absent) {
    std::vector<std::uint64_t> cell;
    for (std::uint64_t point = 0; point < 5; ++point)
      if (point != absent) cell.push_back(point);
    closed.cells.push_back({cell[0], cell[1], cell[2], cell[3]});
  }
  add_point_field(closed, "linear", linear);
  const TemporaryFolder folder;
  const render::Dataset boundary = packed(folder, "closed.rho", closed).boundary();
  EXPECT_EQ(formats::TetMesh(formats::PackedFile::open(folder / "closed.rho")).boundary().size(), 0U);
  const Scene scene = scene_of(boundary);
  EXPECT_EQ(hit_count(picture(boundary, scene)), 0U);

  const render::LoadedDataset& dataset = boundary.implementation();
  const std::vector<render::Ray> rays = camera_rays(boundary, scene.camera, 16, 16);
  std::vector<render::Machine> machines = wide_machines();
  machines.push_back(render::Machine::scalar);
  for (const render::Machine machine : machines)
    for (const render::Accuracy accuracy : {render::Accuracy::float32, render::Accuracy::float64})
      for (const bool use_hierarchy : {false, true}) {
        const render::Method method = render::method_of(accuracy);
        render::KernelScratch scratch;
        std::vector<render::Hit> hits(rays.size());
        ask(render::choose_intersectors(dataset, {.method = method}, machine).first_hit, dataset,
            {.method = method, .use_hierarchy = use_hierarchy}, rays, hits, scratch);
        for (const render::Hit& hit : hits) EXPECT_TRUE(hit.is_miss()) << name_of(machine);
      }
}

TEST(MeshBoundary, surfaces_without_fields_are_not_coloured) {
  const Meshes meshes;
  const render::Dataset surface = as_surface(meshes);
  EXPECT_FALSE(surface.has_fields());
  Scene scene = scene_of(surface);
  scene.layers[0].material.color_by = render::FieldColors{.field = "linear", .range = {0, 1}};
  expect_error(ErrorCode::usage, "a surface has no fields to be coloured by", [&] { picture(surface, scene); });
}

}  // namespace
}  // namespace rhoray::tests

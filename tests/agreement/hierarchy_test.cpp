#include "tests/agreement/pictures.h"

namespace rhoray::tests {

namespace {

void expect_hierarchy_changes_nothing(const render::Dataset& dataset, const render::Scene& scene) {
  const render::Framebuffer with = picture(dataset, scene, {.use_hierarchy = true});
  EXPECT_GT(hit_count(with), 500u);
  expect_same_bits(with, picture(dataset, scene, {.use_hierarchy = false}));
}

}  // namespace

TEST(Hierarchy, on_and_off_give_the_same_picture_of_grids_for_any_factor_and_number_of_levels) {
  const TemporaryFolder folder;
  const Index3 count(41, 35, 29);
  const auto smooth =
      sampled_volume<float>(count, lattice_over({{-1, -1, -1}, {1, 1, 1}}, count), marschner_lobb_field(3));
  const auto noise = noise_volume<std::uint8_t>(count, 9, 5);
  for (const std::int64_t factor : {2, 3, 4, 5})
    for (const int levels : {1, 3, 6}) {
      const std::string name = concat(factor, "-", levels);
      const preprocess::PackVolumeOptions options{.macro_factor = factor, .macro_level_count = levels};
      const render::Dataset a = packed(folder, "smooth" + name, smooth, options);
      const render::Dataset b = packed(folder, "noise" + name, noise, options);
      for (const render::Mode mode : {render::Mode::isosurface, render::Mode::mip}) {
        render::Scene scene = oblique_scene(a, 0.5);
        scene.layers[0].mode = mode;
        expect_hierarchy_changes_nothing(a, scene);
        scene = oblique_scene(b, 8.5);
        scene.layers[0].mode = mode;
        expect_hierarchy_changes_nothing(b, scene);
      }
    }
}

// Samples equal the whole-numbered isovalues. Rays along an axis at whole positions run in faces
// and along edges.
TEST(Hierarchy, changes_nothing_where_rays_run_in_faces_and_the_isovalue_equals_samples) {
  const TemporaryFolder folder;
  const render::Dataset dataset = packed(folder, "v.rho", noise_volume<std::uint8_t>({25, 25, 25}, 4, 21));
  render::Scene scene = straight_scene(dataset, 3);
  // 24 cells in 48 pixels: rays pass at a quarter and three quarters of a cell. A shift by 0.25 of
  // a cell puts every second ray into a lattice plane.
  scene.camera.orthographic_height = 24;
  for (const double shift : {0.0, 0.25, 0.5}) {
    render::Scene shifted = scene;
    shifted.camera.position += Vec3(shift, 0, shift);
    shifted.camera.target += Vec3(shift, 0, shift);
    const render::Framebuffer with = picture(dataset, shifted, {.width = 48, .height = 48});
    EXPECT_GT(hit_count(with), 1500u);
    expect_same_bits(with, picture(dataset, shifted, {.width = 48, .height = 48, .use_hierarchy = false}));
  }
}

TEST(Hierarchy, on_and_off_give_the_same_picture_of_meshes) {
  const TemporaryFolder folder;
  const auto mesh = box_mesh({.cells = {9, 8, 7}, .jitter = 0.15, .grading = 6}, distance_field({0.3, 0.4, 0.5}));
  for (const double leaves : {0.1, 1.0, 8.0}) {
    const render::Dataset dataset =
        packed(folder, concat("m", leaves), mesh,
               {.structure = preprocess::MeshStructure::leaves, .leaf_cells_per_tetrahedron = leaves});
    for (const render::Mode mode : {render::Mode::isosurface, render::Mode::mip}) {
      render::Scene scene = oblique_scene(dataset, 0.31);
      scene.layers[0].mode = mode;
      expect_hierarchy_changes_nothing(dataset, scene);
    }
  }
}

TEST(Hierarchy, leaf_lattices_of_any_resolution_give_the_same_picture_of_a_mesh) {
  const TemporaryFolder folder;
  const auto mesh = box_mesh({.cells = {9, 8, 7}, .jitter = 0.15, .grading = 6}, distance_field({0.3, 0.4, 0.5}));
  const render::Dataset coarse =
      packed(folder, "coarse", mesh, {.structure = preprocess::MeshStructure::leaves, .leaf_cell_count = 1});
  const render::Scene scene = oblique_scene(coarse, 0.31);
  const render::Framebuffer expected = picture(coarse, scene);
  for (const std::uint64_t leaves : {20u, 500u, 20000u})
    expect_same_bits(expected,
                     picture(packed(folder, concat(leaves), mesh,
                                    {.structure = preprocess::MeshStructure::leaves, .leaf_cell_count = leaves}),
                             scene));
}

}  // namespace rhoray::tests

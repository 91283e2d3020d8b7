#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "formats/base/error.h"
#include "tests/render/frame/lit_pictures.h"

/// Light on surfaces: several lights, ambient occlusion, fog.
namespace rhoray::tests {
namespace {

using namespace lit;

TEST(Lights, that_are_one_together_give_the_light_of_one) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder, waves, 12);
  for (std::size_t v = 0; v < datasets.size(); ++v) {
    Layer layer = matte(v, 0.2);
    layer.material = {};
    const Picture one = picture_of(datasets, scene_of({layer}, {{}})),
                  halves = picture_of(datasets, scene_of({layer}, {{.color = {0.25, 0.25, 0.25}},
                                                                   {.color = {0, 0, 0}},
                                                                   {.color = {0.75, 0.75, 0.75}}})),
                  none = picture_of(datasets, scene_of({layer}, {}));
    for (std::size_t i = 0; i < one.pixels.color.size(); ++i)
      ASSERT_NEAR(one.pixels.color[i], halves.pixels.color[i], 2e-5);
    for (std::size_t p = 0; p < none.pixels.pixel_count(); ++p)
      if (none.is_hit(p)) {
        ASSERT_NEAR(none.red(p), 0.12 * 0.78, 1e-6);
      }
  }
}

/// A floor at z = -0.5 and a wall at x = -0.3.
std::vector<render::Dataset> floor_and_wall(const TemporaryFolder& folder) {
  std::vector<render::Dataset> datasets;
  const Index3 samples(7, 7, 7);
  const Box3 wide{{-9, -9, -9}, {9, 9, 9}};
  datasets.push_back(packed(folder, "floor.rho",
                            sampled_volume<double>(samples, lattice_over(wide, samples), linear_field({0, 0, 1}))));
  preprocess::NeutralMesh mesh = box_mesh({.cells = {5, 5, 5}, .box = wide});
  add_point_field(mesh, "value", linear_field({1, 0, 0}));
  datasets.push_back(packed(folder, "wall.rho", mesh));
  return datasets;
}

TEST(Occlusion, of_a_floor_beside_a_wall_is_the_share_of_the_disk_that_the_wall_takes) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = floor_and_wall(folder);
  Scene scene = scene_of({matte(0, -0.5), matte(1, -0.3)}, {});
  for (Layer& layer : scene.layers) layer.material.ambient = 1;
  scene.occlusion = {.samples = 64, .radius = 0.8};
  const Picture found = picture_of(datasets, scene, 2);
  double sum = 0, largest = 0;
  std::size_t count = 0, untouched = 0;
  for (std::size_t p = 0; p < found.pixels.pixel_count(); ++p) {
    if (!found.is_hit(p)) continue;
    const Vec3 place = place_of(scene, found, p);
    if (place.z > -0.4999 || place.x < -0.299) continue;
    // With cosine-weighted directions as points of the unit disk, those that hit the wall within
    // the radius are beyond a chord.
    const double chord = (place.x + 0.3) / 0.8;
    const double taken = chord < 1 ? (std::acos(chord) - chord * std::sqrt(1 - chord * chord)) / std::numbers::pi : 0;
    const double error = static_cast<double>(found.red(p)) - (1 - taken);
    sum += error, largest = std::max(largest, std::abs(error)), ++count;
    untouched += chord > 1 && error == 0;
  }
  EXPECT_GT(count, 2000);
  EXPECT_GT(untouched, 500);
  EXPECT_LT(std::abs(sum / static_cast<double>(count)), 0.002);
  // Of 64 evenly spread points, about five near the chord may be on its wrong side.
  EXPECT_LT(largest, 0.08);
  EXPECT_EQ(found.statistics.occlusion_rays, 64 * found.statistics.hits);
  EXPECT_EQ(found.statistics.shadow_rays, 0);
}

TEST(Occlusion, leaves_a_plane_as_it_is_and_a_ball_but_for_its_cells) {
  for (const double scale : scales) {
    const TemporaryFolder folder;
    const std::vector<render::Dataset> planes = both_kinds(folder, linear_field({0.3, -0.7, 0.2}), 8, scale);
    for (std::size_t v = 0; v < planes.size(); ++v) {
      Scene scene = scene_of({matte(v, 0.1)}, {{}}, {scale * cube.min, scale * cube.max});
      const Picture none = picture_of(planes, scene);
      EXPECT_EQ(none.statistics.occlusion_rays, 0);
      scene.occlusion = {.samples = 9, .radius = scale};
      const Picture with = picture_of(planes, scene);
      EXPECT_EQ(with.statistics.occlusion_rays, 9 * with.statistics.hits);
      for (std::size_t i = 0; i < none.pixels.color.size(); ++i)
        ASSERT_NEAR(with.pixels.color[i], none.pixels.color[i], 1e-6);
    }
  }
}

TEST(Fog, mixes_colours_by_distance) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder, waves, 12);
  Scene scene = scene_of({matte(0, 0.2)}, {{}});
  const Picture clear = picture_of(datasets, scene);
  const double near = (scene.camera.position - scene.camera.target).length() - 0.5;
  scene.fog = {.color = {1, 0.5, 0}, .range = {.lo = near, .hi = near + 1}};
  const Picture found = picture_of(datasets, scene);
  std::size_t between = 0;
  for (std::size_t p = 0; p < clear.pixels.pixel_count(); ++p) {
    const double share = clear.is_hit(p) ? std::clamp(static_cast<double>(clear.pixels.depth[p]) - near, 0.0, 1.0) : 0;
    between += share > 0 && share < 1;
    for (int c = 0; c < 3; ++c) {
      const std::size_t i = 4 * p + static_cast<std::size_t>(c);
      const double color = clear.pixels.color[i];
      ASSERT_NEAR(found.pixels.color[i], color + share * (scene.fog->color[c] - color), 1e-5);
    }
  }
  EXPECT_GT(between, 500);
}

/// All effects at once, on layers of every kind.
Scene full_scene() {
  Scene scene =
      scene_of({matte(0, 0.2), matte(1, -0.1), matte(1, 0.35)}, {sun({1, -2, 1.5}), lamp({0.1, -0.4, 0.9}), {}});
  scene.layers[1].material.opacity = 0.4;
  scene.layers[2].material.specular = 0.5;
  scene.layers[2].material.normals = render::Normals::smooth;
  scene.occlusion = {.samples = 3, .radius = 0.5};
  scene.fog = render::Fog{.color = {0, 0, 1}, .range = {.lo = 0, .hi = 20}};
  return scene;
}

TEST(Lighting, is_the_same_for_any_number_of_threads_and_any_refinement) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder, waves, 12);
  const Scene scene = full_scene();
  const Picture one = picture_of(datasets, scene), three = picture_of(datasets, scene, 3);
  expect_same_bits(one.pixels, three.pixels);
  EXPECT_EQ(one.statistics.shadow_rays, three.statistics.shadow_rays);
  EXPECT_EQ(one.statistics.occlusion_rays, three.statistics.occlusion_rays);
  Framebuffer refined;
  render::RenderContext memory;
  render::refine(datasets, scene, {.width = edge, .height = edge, .channels = all_channels}, {.first_spacing = 4},
                 refined, memory);
  expect_same_bits(one.pixels, refined);
}

TEST(Lighting, of_a_linear_field_is_that_of_a_mesh) {
  const TemporaryFolder folder;
  std::vector<render::Dataset> datasets = both_kinds(folder, linear_field({0.3, -0.4, 1}), 8);
  for (render::Dataset& dataset : ball_over_floor(folder, false)) datasets.push_back(std::move(dataset));
  std::vector<Picture> pictures;
  for (const std::size_t v : {0U, 1U}) {
    Scene scene = scene_of({matte(v, -0.6), matte(2, -0.16)}, {sun({1, -0.7, 1.9}), {}});
    scene.layers[0].material.specular = 0.3;
    scene.occlusion = {.samples = 4, .radius = 0.7};
    pictures.push_back(picture_of(datasets, scene));
  }
  std::size_t differing = 0;
  for (std::size_t p = 0; p < pictures[0].pixels.pixel_count(); ++p)
    differing += std::abs(pictures[0].red(p) - pictures[1].red(p)) > 1e-4F;
  EXPECT_LT(differing, 12) << "pixels at the edges of shadows";
  EXPECT_GT(pictures[0].statistics.hits, 2000);
  EXPECT_GT(pictures[0].statistics.shadow_rays, 2000);
}

TEST(Lighting, is_refused_where_it_makes_no_sense) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder, ball, 4);
  const Scene fine = scene_of({matte(0, 0)}, {sun({0, 0, 1})});
  const auto refused = [&](const auto& change) {
    Scene scene = fine;
    change(scene);
    try {
      picture_of(datasets, scene);
    } catch (const Error& error) {
      return error.code() == ErrorCode::usage;
    }
    return false;
  };
  const double nan = std::nan("");
  EXPECT_FALSE(refused([](Scene&) {}));
  EXPECT_TRUE(refused([](Scene& scene) { scene.lights[0].place = {0, 0, 0}; }));
  EXPECT_TRUE(refused([&](Scene& scene) { scene.lights[0].place.x = nan; }));
  EXPECT_TRUE(refused([&](Scene& scene) { scene.lights[0] = lamp({0, 0, infinity}); }));
  EXPECT_TRUE(refused([&](Scene& scene) { scene.lights[0].color.y = nan; }));
  EXPECT_TRUE(refused([](Scene& scene) { scene.lights[0].color.y = -1; }));
  EXPECT_TRUE(refused([&](Scene& scene) { scene.occlusion.radius = nan; }));
  EXPECT_TRUE(refused([](Scene& scene) { scene.occlusion.radius = -1; }));
  EXPECT_TRUE(refused([](Scene& scene) { scene.occlusion.samples = 5000; }));
  EXPECT_TRUE(refused([](Scene& scene) { scene.fog = render::Fog{.range = {.lo = 2, .hi = 1}}; }));
  EXPECT_TRUE(refused([&](Scene& scene) { scene.fog = render::Fog{.range = {.lo = 0, .hi = infinity}}; }));
}

}  // namespace
}  // namespace rhoray::tests

#include "render/texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "preprocess/pack_colors.h"
#include "render/called_for.h"
#include "render/frame/camera_rays.h"
#include "tests/agreement/pictures.h"
#include "tests/support/colors.h"
#include "tests/support/expect_error.h"

/// Surfaces covered by colours in space.
namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::FrameStatistics;
using render::Layer;
using render::Scene;
using render::Texture;

constexpr int edge = 96;
const Box3 cube{{-1, -1, -1}, {1, 1, 1}};

double decoded(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
std::uint8_t encoded_byte(double linear) {
  const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

Texture texture_of(const TemporaryFolder& folder, const preprocess::NeutralVolume& colors,
                   const std::string& name = "colors.rho") {
  preprocess::pack_colors(colors, folder / name, {.replace_existing = true});
  return Texture::load(folder / name);
}

/// The linear colour of the texture in the world.
Vec3 light_at(const Vec3& p) {
  return {0.5 + 0.4 * p.x, 0.5 + 0.2 * p.y - 0.2 * p.z, 0.4 - 0.3 * p.x + 0.2 * p.z};
}

/// Slightly larger than the cube, in axes of its own.
preprocess::NeutralVolume ramps(int component_count = 3, std::uint8_t alpha = 255) {
  const Index3 count(40, 36, 44);
  Affine world = lattice_over(Box3({-1.2, -1.3, -1.1}, {1.2, 1.3, 1.1}), count);
  world.x_axis += 0.1 * world.y_axis;
  return colors_of(
      count, component_count,
      [&](const Index3& at) {
        const Vec3 light = light_at(world.point(Vec3(at)));
        return std::array<std::uint8_t, 4>{encoded_byte(light.x), encoded_byte(light.y), encoded_byte(light.z), alpha};
      },
      world);
}

/// Only ambient light: a surface shows its own colours.
Layer glowing(std::size_t dataset, double isovalue, const std::optional<Texture>& texture) {
  Layer layer{.dataset = dataset, .isovalue = isovalue, .method = render::method_of(render::Accuracy::float64)};
  layer.material = {.color = {0.1, 0.2, 0.9}, .texture = texture, .ambient = 1, .specular = 0};
  return layer;
}

Scene scene_of(const std::vector<Layer>& layers) {
  Scene scene;
  scene.layers = layers;
  scene.camera = render::fit_camera(cube, {.azimuth_deg = 33, .elevation_deg = 31, .zoom = 1.1}, 1);
  scene.background = {0, 0, 0};
  return scene;
}

struct Picture {
  Framebuffer pixels;
  FrameStatistics statistics;

  bool is_hit(std::size_t p) const { return pixels.color[4 * p + 3] > 0; }
  double channel(std::size_t p, int c) const { return pixels.color[4 * p + static_cast<std::size_t>(c)]; }
};

Picture picture_of(const std::vector<render::Dataset>& datasets, const Scene& scene, unsigned threads = 1) {
  Picture picture;
  picture.statistics = render::render(
      datasets, scene, {.width = edge, .height = edge, .channels = all_channels, .threads = threads}, picture.pixels);
  return picture;
}

double ball(const Vec3& p) {
  return 0.8 - p.length();
}

/// The same ball as a grid and as a mesh.
std::vector<render::Dataset> both_kinds(const TemporaryFolder& folder) {
  const Index3 samples(25, 25, 25);
  preprocess::NeutralMesh mesh = box_mesh({.cells = {24, 24, 24}, .box = {cube.min, cube.max}});
  add_point_field(mesh, "value", ball);
  return {packed(folder, "grid.rho", sampled_volume<float>(samples, lattice_over(cube, samples), ball)),
          packed(folder, "mesh.rho", mesh)};
}

Vec3 place_of(const Scene& scene, const Picture& picture, std::size_t p) {
  const render::CameraRays rays(scene.camera, edge, edge);
  const render::Ray ray = rays.through_pixel(static_cast<int>(p % edge), static_cast<int>(p / edge));
  return ray.at(static_cast<double>(picture.pixels.depth[p]));
}

TEST(Textures, cover_grids_and_meshes_with_their_light_at_every_hit) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder);
  const Texture texture = texture_of(folder, ramps());
  for (std::size_t v = 0; v < datasets.size(); ++v)
    for (const render::Accuracy accuracy : {render::Accuracy::float32, render::Accuracy::float64}) {
      Scene scene = scene_of({glowing(v, 0.05, texture)});
      scene.layers[0].method = render::method_of(accuracy);
      const Picture picture = picture_of(datasets, scene);
      EXPECT_GT(picture.statistics.hits, 1000U);
      EXPECT_EQ(picture.statistics.texture_lookups, picture.statistics.hits);
      for (std::size_t p = 0; p < picture.pixels.pixel_count(); ++p) {
        if (!picture.is_hit(p)) continue;
        const Vec3 expected = light_at(place_of(scene, picture, p));
        // Half a step of 8 bits where it is widest, at the bright end.
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(picture.channel(p, c), expected[c], 0.005) << p;
      }
      expect_same_bits(picture.pixels, picture_of(datasets, scene, 3).pixels);
    }
}

TEST(Textures, of_one_texel_are_a_colour) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder);
  const Texture one = texture_of(folder, colors_of({1, 1, 1}, 3,
                                                   [](const Index3&) {
                                                     return std::array<std::uint8_t, 4>{255, 0, 124, 0};
                                                   },
                                                   {{4, 0, 0}, {0, 4, 0}, {0, 0, 4}, {0, 0, 0}}));
  for (std::size_t v = 0; v < datasets.size(); ++v) {
    Scene textured = scene_of({glowing(v, 0.05, one)}), plain = textured;
    for (Scene* scene : {&textured, &plain}) {
      scene->layers[0].material.ambient = 0.2;
      scene->layers[0].material.specular = 0.3;
    }
    plain.layers[0].material.texture.reset();
    plain.layers[0].material.color = {1, 0, static_cast<double>(static_cast<float>(decoded(124 / 255.0)))};
    expect_same_bits(picture_of(datasets, textured).pixels, picture_of(datasets, plain).pixels);
  }
}

TEST(Textures, are_mixed_over_the_surface_by_their_alpha) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder);
  for (const int alpha : {0, 51, 255}) {
    const Texture texture = texture_of(folder, ramps(4, static_cast<std::uint8_t>(alpha)));
    const Scene scene = scene_of({glowing(0, 0.05, texture)});
    const Picture picture = picture_of(datasets, scene);
    std::size_t hits = 0;
    for (std::size_t p = 0; p < picture.pixels.pixel_count(); ++p) {
      if (!picture.is_hit(p)) continue;
      ++hits;
      const Vec3 covering = light_at(place_of(scene, picture, p));
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(picture.channel(p, c),
                    alpha / 255.0 * covering[c] + (1 - alpha / 255.0) * scene.layers[0].material.color[c], 0.005);
    }
    EXPECT_GT(hits, picture.pixels.pixel_count() / 10);
  }
}

TEST(Textures, leave_what_they_do_not_reach_as_it_is) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder);
  // Covers only the half with z above 0.
  const Texture half = texture_of(folder, colors_of({1, 1, 1}, 3,
                                                    [](const Index3&) {
                                                      return std::array<std::uint8_t, 4>{255, 255, 255, 255};
                                                    },
                                                    {{4, 0, 0}, {0, 4, 0}, {0, 0, 2}, {0, 0, 1}}));
  const Scene scene = scene_of({glowing(0, 0.05, half)});
  const Picture picture = picture_of(datasets, scene);
  std::uint64_t above = 0;
  for (std::size_t p = 0; p < picture.pixels.pixel_count(); ++p) {
    if (!picture.is_hit(p)) continue;
    const double z = place_of(scene, picture, p).z;
    above += z >= 0;
    if (std::abs(z) < 1e-5) continue;
    ASSERT_EQ(static_cast<float>(picture.channel(p, 0)), z > 0 ? 1.0F : 0.1F);
  }
  EXPECT_EQ(picture.statistics.texture_lookups, above);

  Scene plain = scene;
  plain.layers[0].material.texture.reset();
  const Texture elsewhere = texture_of(folder, colors_of({4, 4, 4}, 3, telling_texel, {.origin = {10, 0, 0}}));
  Scene missed = scene;
  missed.layers[0].material.texture = elsewhere;
  const Picture without = picture_of(datasets, plain), with = picture_of(datasets, missed);
  expect_same_bits(without.pixels, with.pixels);
  EXPECT_EQ(with.statistics.texture_lookups, 0U);
  EXPECT_EQ(without.statistics.texture_lookups, 0U);
}

TEST(Textures, cover_clear_surfaces_at_each_of_their_crossings) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder);
  const Texture texture = texture_of(folder, ramps());
  for (std::size_t v = 0; v < datasets.size(); ++v) {
    Layer clear = glowing(v, 0.05, texture);
    clear.material.opacity = 0.5;
    const Scene scene = scene_of({clear});
    const Picture picture = picture_of(datasets, scene);
    EXPECT_GT(picture.statistics.texture_lookups, picture.statistics.hits * 19 / 10) << "in and out again";
    // A ball: the first crossing determines where the ray leaves it.
    for (std::size_t p = 0; p < picture.pixels.pixel_count(); ++p) {
      if (!picture.is_hit(p)) continue;
      const Vec3 in = place_of(scene, picture, p), along = (in - scene.camera.position).normalized();
      const Vec3 out = in - 2 * in.dot(along) * along;
      const Vec3 expected = 0.5 * light_at(in) + 0.25 * light_at(out);
      if (-in.dot(along) < 0.2) continue;  // the grid's ball is not exactly a ball
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(picture.channel(p, c), expected[c], 0.02);
    }
  }
}

TEST(Textures, are_lit_as_the_surface_is) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder);
  const Texture texture = texture_of(folder, ramps());
  Scene lit = scene_of({glowing(0, 0.05, texture)});
  lit.layers[0].material.ambient = 0.2;
  lit.lights = {
      {.kind = render::Light::Kind::directional, .place = {-2, -1, 1.5}, .color = {1, 0.5, 2}, .casts_shadows = true}};
  Scene white = lit, dark = lit;
  white.layers[0].material.texture.reset(), white.layers[0].material.color = {1, 1, 1};
  dark.layers[0].material.ambient = 1, dark.lights = {render::Light{}};
  const Picture found = picture_of(datasets, lit), light = picture_of(datasets, white),
                own = picture_of(datasets, dark);
  for (std::size_t p = 0; p < found.pixels.pixel_count(); ++p)
    for (int c = 0; c < 3; ++c)
      if (found.is_hit(p)) {
        ASSERT_NEAR(found.channel(p, c), light.channel(p, c) * own.channel(p, c), 1e-6);
      }
  EXPECT_EQ(found.statistics.shadow_rays, light.statistics.shadow_rays);
}

TEST(Textures, of_surfaces_that_are_hidden_are_not_read) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder);
  const Texture texture = texture_of(folder, ramps());
  const Layer shell = glowing(0, 0.05, std::nullopt);
  const Picture hidden = picture_of(datasets, scene_of({shell, glowing(1, 0.3, texture)}));
  EXPECT_GT(hidden.statistics.hits, 1000U);
  EXPECT_EQ(hidden.statistics.texture_lookups, 0U);
  // Where two surfaces partly cover each other, no hit is looked up twice.
  const Picture both = picture_of(datasets, scene_of({glowing(0, 0.05, texture), glowing(1, 0.05, texture)}));
  EXPECT_EQ(both.statistics.texture_lookups, both.statistics.hits);
}

TEST(Textures, are_called_for_by_surfaces_that_name_one) {
  const TemporaryFolder folder;
  const Texture texture = texture_of(folder, ramps());
  const auto called_for = [&](const Layer& layer) {
    for (const render::EffectReason& reason : render::reasons_for_effects(scene_of({layer}), layer))
      if (reason.effect == "texture") return std::pair(reason.called_for, reason.why);
    return std::pair(false, std::string("no row"));
  };
  EXPECT_EQ(called_for(glowing(0, 0, std::nullopt)), std::pair(false, std::string("no texture covers the surface")));
  const auto [is_called_for, why] = called_for(glowing(0, 0, texture));
  EXPECT_TRUE(is_called_for);
  EXPECT_NE(why.find("colors.rho"), why.npos) << why;
  Layer projection = glowing(0, 0, texture);
  projection.mode = render::Mode::mip;
  EXPECT_FALSE(called_for(projection).first);
}

TEST(Textures, are_refused_beside_colours_by_a_field) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder);
  Scene scene = scene_of({glowing(0, 0.05, texture_of(folder, ramps()))});
  scene.layers[0].material.color_by = {.field = "value", .range = {0, 1}};
  expect_error(ErrorCode::usage, "expected one of the two", [&] { picture_of(datasets, scene); });
}

TEST(Textures, are_refused_where_no_colours_are_expected_and_other_files_as_textures) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder);
  texture_of(folder, ramps());
  expect_error(ErrorCode::unsupported, "holds colours; expected a grid",
               [&] { render::Dataset::load(folder / "colors.rho"); });
  expect_error(ErrorCode::invalid, "'colors'", [&] { Texture::load(folder / "grid.rho"); });
}

TEST(Textures, tell_of_boxes_that_they_may_reach) {
  const TemporaryFolder folder;
  // A square standing on its corner: its bounds extend farther than it does.
  const Texture texture =
      texture_of(folder, colors_of({10, 10, 10}, 3, telling_texel, {{1, 1, 0}, {-1, 1, 0}, {0, 0, 1}, {0, 0, 0}}));
  const auto box = [](const Vec3& low, const Vec3& high) { return Box3(low, high); };
  EXPECT_TRUE(texture.may_overlap(box({-1, 5, 2}, {1, 7, 3})));
  EXPECT_TRUE(texture.contains(box({-1, 5, 2}, {1, 7, 3})));
  EXPECT_TRUE(texture.may_overlap(box({-30, 5, 2}, {1, 7, 3})));
  EXPECT_FALSE(texture.contains(box({-30, 5, 2}, {1, 7, 3})));
  EXPECT_FALSE(texture.may_overlap(box({11, 5, 2}, {12, 7, 3})));
  EXPECT_FALSE(texture.may_overlap(box({7, 0, 2}, {8, 1, 3}))) << "within the bounds, beside the square";
  EXPECT_FALSE(texture.may_overlap(Box3()));
}

}  // namespace
}  // namespace rhoray::tests

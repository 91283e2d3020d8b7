#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "render/ray_caster.h"
#include "tests/render/frame/lit_pictures.h"

/// Shadows of lights without a size: no self-shadowing, and all other shadows where they must be.
namespace rhoray::tests {
namespace {

using namespace lit;

Scene without_shadows(Scene scene) {
  for (Light& light : scene.lights) light.casts_shadows = false;
  return scene;
}

TEST(Shadows, are_not_seen_on_a_ball_towards_the_light) {
  for (const double scale : scales)
    for (const double steepness : {1.0, 1e-15, 1e15}) {
      const TemporaryFolder folder;
      const std::vector<render::Dataset> datasets = both_kinds(folder, ball, 24, scale, steepness);
      for (std::size_t v = 0; v < datasets.size(); ++v)
        for (const Light& light : {sun({-2, -1, 1.5}), lamp(scale * Vec3(-3, -2, 4))}) {
          const Scene scene = scene_of({matte(v, 0.01 * steepness)}, {light}, {scale * cube.min, scale * cube.max});
          const Picture with = picture_of(datasets, scene), none = picture_of(datasets, without_shadows(scene));
          std::size_t towards = 0, away = 0;
          for (std::size_t p = 0; p < with.pixels.pixel_count(); ++p) {
            if (!with.is_hit(p)) continue;
            // The light without shadows gives the angle: ambient + (1 - ambient) * cosine.
            const double cosine = (static_cast<double>(none.red(p)) - 0.25) / 0.75;
            // The interpolant of a ball is not exactly a ball: cells shadow themselves along the
            // terminator.
            if (cosine > 0.12) {
              ASSERT_EQ(with.red(p), none.red(p)) << p << " of " << v << ", scale " << scale << ' ' << steepness;
            }
            towards += cosine > 0.12, away += cosine == 0;
          }
          EXPECT_GT(towards, 600);
          EXPECT_GT(away, 200);
          EXPECT_LT(with.statistics.shadow_rays, with.statistics.hits - away + 10);
          EXPECT_GE(with.statistics.shadow_rays, towards);
        }
    }
}

TEST(Shadows, do_not_fall_from_a_plane_on_itself) {
  std::size_t lit = 0;
  for (const double scale : scales)
    for (const Vec3& slope : {Vec3(0, 0, 1), Vec3(0, -1, 0), Vec3(1, 1, 0), Vec3(1, 1, 1), Vec3(0.3, -0.7, 0.2)}) {
      const TemporaryFolder folder;
      const std::vector<render::Dataset> datasets = both_kinds(folder, linear_field(slope), 8, scale);
      for (const double isovalue : {0.0, 0.25, 0.1234567})  // in planes of cells and between them
        for (std::size_t v = 0; v < datasets.size(); ++v)
          for (const Light& light :
               {sun({1, -2, 1.5}), sun(slope + Vec3(100, 1, -37)), lamp(scale * Vec3(0.5, -2, 0.7))}) {
            const Scene scene = scene_of({matte(v, isovalue)}, {light}, {scale * cube.min, scale * cube.max});
            const Picture with = picture_of(datasets, scene), none = picture_of(datasets, without_shadows(scene));
            ASSERT_EQ(with.pixels.color, none.pixels.color) << slope << ' ' << isovalue << ' ' << v << ' ' << scale;
            for (std::size_t p = 0; p < none.pixels.pixel_count(); ++p) lit += none.is_hit(p) && none.red(p) > 0.25F;
          }
    }
  EXPECT_GT(lit, 100'000);
}

TEST(Shadows, do_not_fall_from_a_saddle_on_itself) {
  // A grid's cells represent this field exactly. It rises by less than 0.71 per unit; the lights
  // are steeper.
  const auto saddle = [](const Vec3& p) { return p.z - 0.5 * p.x * p.y; };
  for (const double scale : scales)
    for (const double steepness : {1.0, 1e-15, 1e15}) {
      const TemporaryFolder folder;
      const std::vector<render::Dataset> datasets = both_kinds(folder, saddle, 12, scale, steepness);
      for (const double isovalue : {0.0, 0.0517})  // through lattice points and beside them
        for (std::size_t v = 0; v < datasets.size(); ++v)
          for (const Light& light : {sun({1, -2, 3}), sun({-1, 1, 1.6}), lamp(scale * Vec3(0.5, -2, 9))}) {
            const Scene scene =
                scene_of({matte(v, isovalue * steepness)}, {light}, {scale * cube.min, scale * cube.max});
            const Picture with = picture_of(datasets, scene), none = picture_of(datasets, without_shadows(scene));
            ASSERT_EQ(with.pixels.color, none.pixels.color) << isovalue << ' ' << v << ' ' << scale << ' ' << steepness;
            EXPECT_GT(with.statistics.shadow_rays, 1000);
          }
    }
}

TEST(Shadows, do_not_fall_from_slivers_on_themselves) {
  // Cells a hundred thousand times as wide as high.
  const Box3 flat{{-1, -1, -1e-5}, {1, 1, 1e-5}};
  for (const Vec3& slope : {Vec3(0, 0, 1), Vec3(1e-6, 2e-6, 1), Vec3(3e-6, -2e-6, 1)}) {
    const TemporaryFolder folder;
    preprocess::NeutralMesh mesh = box_mesh({.cells = {9, 9, 1}, .box = flat});
    add_point_field(mesh, "value", linear_field(slope));
    const std::vector<render::Dataset> datasets{packed(folder, "mesh.rho", mesh)};
    const Scene scene = scene_of({matte(0, 1e-6)}, {sun({1, -2, 1.5}), sun({-1, 1, 0.02})});
    const Picture with = picture_of(datasets, scene), none = picture_of(datasets, without_shadows(scene));
    EXPECT_EQ(with.pixels.color, none.pixels.color) << slope;
    EXPECT_GT(with.statistics.shadow_rays, 50);
  }
}

/// Uncertainty of the ray's distance from the ball's centre at the edge of its shadow. It is 3/8
/// h^2 / r, plus rounding of the depths from which a pixel's position is computed.
constexpr double shadow_tolerance = 0.375 / 80 / 80 / 0.4 + 1e-5;

/// Returns the distance from the origin at which a ray towards a light passes, forwards only.
double passes_at(const Vec3& from, const Light& light) {
  const Vec3 way = light.kind == Light::Kind::point ? light.place - from : light.place;
  const double share = std::max(0.0, -from.dot(way) / way.dot(way));
  return (from + (light.kind == Light::Kind::point ? std::min(share, 1.0) : share) * way).length();
}

TEST(Shadows, of_a_ball_on_a_floor_are_where_they_must_be) {
  for (const bool floor_is_mesh : {false, true})
    for (const Light& light : {sun({1, -0.7, 1.9}), lamp({0.3, 0.2, 1.5}), lamp({0, 0.7, 0.6}), lamp({0, 0, -0.6})}) {
      const TemporaryFolder folder;
      const std::vector<render::Dataset> datasets = ball_over_floor(folder, floor_is_mesh);
      const Scene scene = scene_of({matte(0, -0.16), matte(1, -0.75)}, {light});
      const Picture found = picture_of(datasets, scene);
      std::size_t dark = 0, lit = 0, skipped = 0;
      for (std::size_t p = 0; p < found.pixels.pixel_count(); ++p) {
        if (!found.is_hit(p)) continue;
        const Vec3 place = place_of(scene, found, p);
        if (place.z > -0.749) continue;
        const double passes = passes_at(place, light);
        if (std::abs(passes - 0.4) < shadow_tolerance) {
          ++skipped;
          continue;
        }
        const bool is_dark = found.red(p) == 0.25F;  // ambient light only
        ASSERT_EQ(is_dark, passes < 0.4) << place << " passes at " << passes;
        ++(is_dark ? dark : lit);
      }
      EXPECT_GT(lit, 500);
      EXPECT_LT(skipped, 30);
      // A point light below the ball casts no shadow of it on the floor.
      EXPECT_EQ(dark > 0, light.place.z > -0.5) << dark;
    }
}

TEST(Shadows, fall_on_clear_surfaces_but_not_from_them) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = ball_over_floor(folder, true);
  Scene scene = scene_of({matte(0, -0.16), matte(1, -0.75)}, {sun({1, -0.7, 1.9})});
  const Picture opaque = picture_of(datasets, scene);
  scene.layers[1].material.opacity = 0.5;
  const Picture floor_clear = picture_of(datasets, scene);
  std::size_t dark = 0;
  for (std::size_t p = 0; p < opaque.pixels.pixel_count(); ++p) {
    if (!opaque.is_hit(p) || place_of(scene, opaque, p).z > -0.749) continue;
    ASSERT_NEAR(floor_clear.red(p), 0.5F * opaque.red(p), 1e-6);  // nothing is seen behind it
    dark += opaque.red(p) == 0.25F;
  }
  EXPECT_GT(dark, 100);
  scene.layers[1].material.opacity = 1, scene.layers[0].material.opacity = 0.5;
  EXPECT_EQ(picture_of(datasets, scene).pixels.color, picture_of(datasets, without_shadows(scene)).pixels.color);
}

double saddle(const Vec3& p) {
  return p.x * p.x - p.y * p.y + 0.3 * p.z;
}
// A different method: rays that start a thousandth of a cell before the hit, whose side is read
// from the field, one by one in double precision. Rays that start along the surface may differ, and
// those that graze another surface.
TEST(Shadows, are_those_of_rays_that_start_beside_the_surface) {
  std::size_t asked = 0, skipped = 0, dark = 0, differing = 0;
  for (const Field& field : {Field(ball), Field(saddle), Field(waves)}) {
    const TemporaryFolder folder;
    constexpr std::int64_t cells = 16;
    const std::vector<render::Dataset> datasets = both_kinds(folder, field, cells);
    for (const std::vector<Layer>& layers : {std::vector{matte(0, 0.0123)}, std::vector{matte(1, 0.0123)},
                                             std::vector{matte(0, 0.2), matte(1, -0.1), matte(1, 0.35)}})
      for (const Light& light : {sun({1, -2, 1.5}), lamp({0.1, -0.4, 0.9})}) {
        const Scene scene = scene_of(layers, {light});
        const Picture with = picture_of(datasets, scene), none = picture_of(datasets, without_shadows(scene));
        std::vector<std::unique_ptr<render::RayCaster>> queries;
        std::vector<Affine> world_from;
        for (const Layer& layer : layers) {
          queries.push_back(
              std::make_unique<render::RayCaster>(datasets[layer.dataset], layer.isovalue, render::Method{}));
          world_from.push_back(world_from_ray_frame(datasets[layer.dataset]));
        }
        for (std::size_t p = 0; p < with.pixels.pixel_count(); p += 3) {
          if (!with.is_hit(p) || none.red(p) < 0.26F) continue;  // behind the surface
          const Vec3 place = place_of(scene, with, p);
          const Vec3 way = light.kind == Light::Kind::point ? light.place - place : light.place;
          ++asked;
          if (with.normal(p).dot(way.normalized()) < 0.08) {
            ++skipped;
            continue;
          }
          const double off = 2e-3 / cells;
          const Vec3 start = place + off * with.normal(p);
          double nearest = infinity;
          for (std::size_t l = 0; l < layers.size(); ++l) {
            const Affine from_world = world_from[l].inverse();
            const render::Ray ray{.origin = from_world.point(start),
                                  .direction = from_world.vector(way.normalized()),
                                  .t_max = light.kind == Light::Kind::point ? way.length() : infinity};
            nearest = std::min(nearest, queries[l]->first_crossing(ray).t);
          }
          const bool is_dark = with.red(p) == 0.25F;
          ASSERT_TRUE(is_dark || with.red(p) == none.red(p));
          differing += is_dark != (nearest < infinity);
          dark += is_dark;
        }
      }
  }
  EXPECT_GT(asked, 10'000);
  EXPECT_GT(dark, 2'000);
  EXPECT_LT(skipped, asked / 8);
  EXPECT_LT(differing, asked / 500);
}

TEST(Shadows, do_not_fall_between_surfaces_that_are_one) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder, ball, 24);
  for (std::size_t v = 0; v < datasets.size(); ++v) {
    const Light light = sun({1, -2, 1.5});
    const Picture one = picture_of(datasets, scene_of({matte(v, 0.01)}, {light}));
    // The same surface twice, and then with a second one inside, a millionth of a cell away, which
    // is completely in its shadow.
    for (const double inner : {0.01, 0.01 + 1e-6 / 12}) {
      const Picture two = picture_of(datasets, scene_of({matte(v, 0.01), matte(v, inner)}, {light}));
      // For a ray that ends at the nearest surface the root is rounded differently.
      for (std::size_t i = 0; i < one.pixels.color.size(); ++i)
        ASSERT_NEAR(two.pixels.color[i], one.pixels.color[i], 1e-5) << v << ' ' << inner;
    }
  }
}

TEST(Shadows, ask_nothing_where_no_light_is_held_back) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(folder, linear_field({0, 0, 1}), 8);
  const auto rays_of = [&](const Scene& scene) { return picture_of(datasets, scene).statistics.shadow_rays; };
  const Scene lit = scene_of({matte(0, 0)}, {sun({1, -2, 1.5})});
  EXPECT_GT(rays_of(lit), 1000);
  EXPECT_EQ(rays_of(scene_of({matte(0, 0)}, {sun({1, -2, -1.5})})), 0) << "behind the surface";
  EXPECT_EQ(rays_of(scene_of({matte(0, 0)}, {sun({1, -2, 1.5}, {0, 0, 0})})), 0) << "without intensity";
  EXPECT_EQ(rays_of(without_shadows(lit)), 0);
  EXPECT_EQ(rays_of(scene_of({matte(0, 0)}, {{.casts_shadows = true}})), 0) << "at the eye";
  Scene other = lit;
  other.layers[0].material.opacity = 0.5;
  EXPECT_EQ(rays_of(other), 0) << "clear";
  other = lit;
  other.layers[0].material.ambient = 1;
  EXPECT_EQ(rays_of(other), 0) << "ambient light only";
  other = lit;
  other.layers[0].mode = render::Mode::mip, other.layers[0].window = datasets[0].field().range;
  EXPECT_EQ(rays_of(other), 0) << "no surface";
}

// Occluders are kept while the light does not move; a frame does not depend on those before it.
TEST(Shadows, are_the_same_whatever_frames_were_before) {
  const TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = both_kinds(
      folder, [](const Vec3& p) { return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z); }, 16);
  for (std::size_t v = 0; v < datasets.size(); ++v) {
    render::RenderContext memory;
    std::size_t frame = 0;
    for (const double isovalue : {0.2, 0.2, 0.1, 0.2})
      for (const Light& light : {sun({-2, -1, 1.5}), sun({-2, -1, 1.5}), sun({-2, -1, 1.4}), lamp({-2, -1, 1.5}),
                                 lamp({-2, -1, 1.5}), sun({-2, -1, 1.5}), sun({1, -1, 1}), sun({1, -1, 0.5})}) {
        Scene scene = scene_of({matte(v, isovalue)}, {light});
        scene.camera = render::fit_camera(cube, {.azimuth_deg = 33.0 + static_cast<double>(frame++ % 3)}, 1);
        Picture picture;
        picture.statistics =
            render::render(datasets, scene, {.width = edge, .height = edge, .channels = all_channels, .threads = 2},
                           picture.pixels, memory);
        const Picture fresh = picture_of(datasets, scene);
        ASSERT_EQ(picture.pixels.color, fresh.pixels.color) << frame << " of " << v;
        EXPECT_EQ(picture.statistics.shadow_rays, fresh.statistics.shadow_rays);
        EXPECT_NE(picture.pixels.color, picture_of(datasets, without_shadows(scene)).pixels.color);
      }
  }
}

}  // namespace
}  // namespace rhoray::tests

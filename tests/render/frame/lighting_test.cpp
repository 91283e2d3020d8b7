#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "formats/base/trouble.h"
#include "render/frame/camera_rays.h"
#include "render/ray_questions.h"
#include "tests/agreement/pictures.h"

/// Light that reaches surfaces: shadows, occlusion, fog.
namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::Layer;
using render::Light;
using render::Scene;

constexpr int edge = 96;
constexpr double infinity = std::numeric_limits<double>::infinity();
const Box3 cube{{-1, -1, -1}, {1, 1, 1}};

Light sun(const Vec3& towards, const Vec3& color = {1, 1, 1}) {
  return {.kind = Light::Kind::directional, .place = towards, .color = color, .casts_shadows = true};
}

Light lamp(const Vec3& place) {
  return {.kind = Light::Kind::point, .place = place, .casts_shadows = true};
}

Layer matte(std::size_t volume, double isovalue) {
  Layer layer{.volume = volume, .isovalue = isovalue, .method = render::method_of(render::Accuracy::single)};
  layer.surface = {.color = {1, 1, 1}, .ambient = 0.25, .specular = 0};
  return layer;
}

Scene scene_of(const std::vector<Layer>& layers, const std::vector<Light>& lights, const Box3& box = cube) {
  Scene scene;
  scene.layers = layers;
  scene.lights = lights;
  scene.camera = render::fit_camera(box, {.azimuth_deg = 33, .elevation_deg = 31, .zoom = 1.1}, 1);
  scene.background = {0, 0, 0};
  return scene;
}

struct Picture {
  Framebuffer pixels;
  render::FrameStatistics statistics;

  bool is_hit(std::size_t p) const { return pixels.depth[p] < static_cast<float>(infinity); }
  Vec3 normal(std::size_t p) const {
    return {pixels.normal[3 * p], pixels.normal[3 * p + 1], pixels.normal[3 * p + 2]};
  }
  float red(std::size_t p) const { return pixels.color[4 * p]; }
};

Picture picture_of(const std::vector<render::Volume>& volumes, const Scene& scene, unsigned threads = 1) {
  Picture picture;
  picture.statistics = render::render(
      volumes, scene, {.width = edge, .height = edge, .channels = all_channels, .threads = threads}, picture.pixels);
  return picture;
}

Scene without_shadows(Scene scene) {
  for (Light& light : scene.lights) light.casts_shadows = false;
  return scene;
}

Affine scaled(Affine map, double scale) {
  for (Vec3* axis : {&map.x_axis, &map.y_axis, &map.z_axis, &map.origin}) *axis *= scale;
  return map;
}

/// A field on [-1, 1]^3 times `scale`, as a grid and as a mesh, its values times `steepness`.
std::vector<render::Volume> both_kinds(const TemporaryFolder& folder, const Field& field, std::int64_t cells,
                                       double scale = 1, double steepness = 1) {
  const Field of_world = [&](const Vec3& p) { return steepness * field(p / scale); };
  const Index3 samples(cells + 1, cells + 1, cells + 1);
  std::vector<render::Volume> volumes;
  volumes.push_back(packed(folder, "grid.rho",
                           sampled_volume<double>(samples, scaled(lattice_over(cube, samples), scale), of_world)));
  preprocess::NeutralMesh mesh =
      box_mesh({.cells = {cells, cells, cells}, .box = {scale * cube.min, scale * cube.max}});
  add_point_field(mesh, "value", of_world);
  volumes.push_back(packed(folder, "mesh.rho", mesh));
  return volumes;
}

double ball(const Vec3& p) {
  return 0.7 - p.length();
}

constexpr double scales[] = {1, 1e-20, 1e20};

TEST(Shadows, are_not_seen_on_a_ball_towards_the_light) {
  for (const double scale : scales)
    for (const double steepness : {1.0, 1e-15, 1e15}) {
      const TemporaryFolder folder;
      const std::vector<render::Volume> volumes = both_kinds(folder, ball, 24, scale, steepness);
      for (std::size_t v = 0; v < volumes.size(); ++v)
        for (const Light& light : {sun({-2, -1, 1.5}), lamp(scale * Vec3(-3, -2, 4))}) {
          const Scene scene = scene_of({matte(v, 0.01 * steepness)}, {light}, {scale * cube.min, scale * cube.max});
          const Picture with = picture_of(volumes, scene), none = picture_of(volumes, without_shadows(scene));
          std::size_t towards = 0, away = 0;
          for (std::size_t p = 0; p < with.pixels.pixel_count(); ++p) {
            if (!with.is_hit(p)) continue;
            // Light that is shown without shadows tells the angle: ambient + (1 - ambient) * cosine.
            const double cosine = (static_cast<double>(none.red(p)) - 0.25) / 0.75;
            // The interpolant of a ball is not quite one: cells' own shadows lie along the terminator.
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
      const std::vector<render::Volume> volumes = both_kinds(folder, linear_field(slope), 8, scale);
      for (const double isovalue : {0.0, 0.25, 0.1234567})  // in planes of cells and between them
        for (std::size_t v = 0; v < volumes.size(); ++v)
          for (const Light& light :
               {sun({1, -2, 1.5}), sun(slope + Vec3(100, 1, -37)), lamp(scale * Vec3(0.5, -2, 0.7))}) {
            const Scene scene = scene_of({matte(v, isovalue)}, {light}, {scale * cube.min, scale * cube.max});
            const Picture with = picture_of(volumes, scene), none = picture_of(volumes, without_shadows(scene));
            ASSERT_EQ(with.pixels.color, none.pixels.color) << slope << ' ' << isovalue << ' ' << v << ' ' << scale;
            for (std::size_t p = 0; p < none.pixels.pixel_count(); ++p) lit += none.is_hit(p) && none.red(p) > 0.25F;
          }
    }
  EXPECT_GT(lit, 100'000);
}

TEST(Shadows, do_not_fall_from_a_saddle_on_itself) {
  // Cells of a grid have it as it is. It rises by less than 0.71 a unit; the lights stand higher.
  const auto saddle = [](const Vec3& p) { return p.z - 0.5 * p.x * p.y; };
  for (const double scale : scales)
    for (const double steepness : {1.0, 1e-15, 1e15}) {
      const TemporaryFolder folder;
      const std::vector<render::Volume> volumes = both_kinds(folder, saddle, 12, scale, steepness);
      for (const double isovalue : {0.0, 0.0517})  // through lattice points and beside them
        for (std::size_t v = 0; v < volumes.size(); ++v)
          for (const Light& light : {sun({1, -2, 3}), sun({-1, 1, 1.6}), lamp(scale * Vec3(0.5, -2, 9))}) {
            const Scene scene =
                scene_of({matte(v, isovalue * steepness)}, {light}, {scale * cube.min, scale * cube.max});
            const Picture with = picture_of(volumes, scene), none = picture_of(volumes, without_shadows(scene));
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
    const std::vector<render::Volume> volumes{packed(folder, "mesh.rho", mesh)};
    const Scene scene = scene_of({matte(0, 1e-6)}, {sun({1, -2, 1.5}), sun({-1, 1, 0.02})});
    const Picture with = picture_of(volumes, scene), none = picture_of(volumes, without_shadows(scene));
    EXPECT_EQ(with.pixels.color, none.pixels.color) << slope;
    EXPECT_GT(with.statistics.shadow_rays, 50);
  }
}

/// A ball of radius 0.4 about the origin over a floor at z = -0.75, each a volume of its own.
std::vector<render::Volume> ball_over_floor(const TemporaryFolder& folder, bool floor_is_mesh) {
  std::vector<render::Volume> volumes;
  // Squares: between samples their interpolant is too large by at most 3/4 h^2, so the ball's radius by 3/8 h^2 / r.
  const Index3 samples(81, 81, 81);
  const Box3 around{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
  volumes.push_back(
      packed(folder, "ball.rho",
             sampled_volume<double>(samples, lattice_over(around, samples), [](const Vec3& p) { return -p.dot(p); })));
  const Field height = linear_field({0, 0, 1});
  const Index3 few(7, 7, 7);
  const Box3 wide{{-3, -3, -1}, {3, 3, -0.4}};
  if (floor_is_mesh) {
    preprocess::NeutralMesh mesh = box_mesh({.cells = {5, 5, 3}, .box = wide});
    add_point_field(mesh, "value", height);
    volumes.push_back(packed(folder, "floor.rho", mesh));
  } else {
    volumes.push_back(packed(folder, "floor.rho", sampled_volume<double>(few, lattice_over(wide, few), height)));
  }
  return volumes;
}

/// Of the ray's distance from the ball's middle over how large a range its shadow's edge may lie: 3/8 h^2 / r, and
/// rounding of the depths that say where a pixel lies.
constexpr double shadow_tolerance = 0.375 / 80 / 80 / 0.4 + 1e-5;

Vec3 place_of(const Scene& scene, const Picture& picture, std::size_t p) {
  const render::CameraRays rays(scene.camera, edge, edge);
  return rays.through_pixel(static_cast<int>(p % edge), static_cast<int>(p / edge))
      .at(static_cast<double>(picture.pixels.depth[p]));
}

/// How far from the origin a ray towards a light passes, going forward only.
double passes_at(const Vec3& from, const Light& light) {
  const Vec3 way = light.kind == Light::Kind::point ? light.place - from : light.place;
  const double share = std::max(0.0, -from.dot(way) / way.dot(way));
  return (from + (light.kind == Light::Kind::point ? std::min(share, 1.0) : share) * way).length();
}

TEST(Shadows, of_a_ball_on_a_floor_are_where_they_must_be) {
  for (const bool floor_is_mesh : {false, true})
    for (const Light& light : {sun({1, -0.7, 1.9}), lamp({0.3, 0.2, 1.5}), lamp({0, 0.7, 0.6}), lamp({0, 0, -0.6})}) {
      const TemporaryFolder folder;
      const std::vector<render::Volume> volumes = ball_over_floor(folder, floor_is_mesh);
      const Scene scene = scene_of({matte(0, -0.16), matte(1, -0.75)}, {light});
      const Picture found = picture_of(volumes, scene);
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
      // A lamp below the ball throws no shadow of it on the floor.
      EXPECT_EQ(dark > 0, light.place.z > -0.5) << dark;
    }
}

TEST(Shadows, fall_on_clear_surfaces_but_not_from_them) {
  const TemporaryFolder folder;
  const std::vector<render::Volume> volumes = ball_over_floor(folder, true);
  Scene scene = scene_of({matte(0, -0.16), matte(1, -0.75)}, {sun({1, -0.7, 1.9})});
  const Picture opaque = picture_of(volumes, scene);
  scene.layers[1].surface.opacity = 0.5;
  const Picture floor_clear = picture_of(volumes, scene);
  std::size_t dark = 0;
  for (std::size_t p = 0; p < opaque.pixels.pixel_count(); ++p) {
    if (!opaque.is_hit(p) || place_of(scene, opaque, p).z > -0.749) continue;
    ASSERT_NEAR(floor_clear.red(p), 0.5F * opaque.red(p), 1e-6);  // nothing is seen behind it
    dark += opaque.red(p) == 0.25F;
  }
  EXPECT_GT(dark, 100);
  scene.layers[1].surface.opacity = 1, scene.layers[0].surface.opacity = 0.5;
  EXPECT_EQ(picture_of(volumes, scene).pixels.color, picture_of(volumes, without_shadows(scene)).pixels.color);
}

double saddle(const Vec3& p) {
  return p.x * p.x - p.y * p.y + 0.3 * p.z;
}
double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z);
}

// By another road: rays that start a thousandth of a cell before the hit, whose side is read from the field, one by
// one in double precision. What starts along the surface may differ, and what grazes another one.
TEST(Shadows, are_those_of_rays_that_start_beside_the_surface) {
  std::size_t asked = 0, skipped = 0, dark = 0, differing = 0;
  for (const Field& field : {Field(ball), Field(saddle), Field(waves)}) {
    const TemporaryFolder folder;
    constexpr std::int64_t cells = 16;
    const std::vector<render::Volume> volumes = both_kinds(folder, field, cells);
    for (const std::vector<Layer>& layers : {std::vector{matte(0, 0.0123)}, std::vector{matte(1, 0.0123)},
                                             std::vector{matte(0, 0.2), matte(1, -0.1), matte(1, 0.35)}})
      for (const Light& light : {sun({1, -2, 1.5}), lamp({0.1, -0.4, 0.9})}) {
        const Scene scene = scene_of(layers, {light});
        const Picture with = picture_of(volumes, scene), none = picture_of(volumes, without_shadows(scene));
        std::vector<std::unique_ptr<render::RayQuestions>> questions;
        std::vector<Affine> world_from;
        for (const Layer& layer : layers) {
          questions.push_back(
              std::make_unique<render::RayQuestions>(volumes[layer.volume], layer.isovalue, render::Method{}));
          world_from.push_back(world_from_ray_frame(volumes[layer.volume]));
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
            nearest = std::min(nearest, questions[l]->first_crossing(ray).t);
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
  const std::vector<render::Volume> volumes = both_kinds(folder, ball, 24);
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    const Light light = sun({1, -2, 1.5});
    const Picture one = picture_of(volumes, scene_of({matte(v, 0.01)}, {light}));
    // The same surface twice, and a shell in another one, a millionth of a cell away, which is in its shadow all over.
    for (const double inner : {0.01, 0.01 + 1e-6 / 12}) {
      const Picture two = picture_of(volumes, scene_of({matte(v, 0.01), matte(v, inner)}, {light}));
      // Of a ray that ends at the nearest surface the root is another rounding of the same.
      for (std::size_t i = 0; i < one.pixels.color.size(); ++i)
        ASSERT_NEAR(two.pixels.color[i], one.pixels.color[i], 1e-5) << v << ' ' << inner;
    }
  }
}

TEST(Shadows, ask_nothing_where_no_light_is_held_back) {
  const TemporaryFolder folder;
  const std::vector<render::Volume> volumes = both_kinds(folder, linear_field({0, 0, 1}), 8);
  const auto rays_of = [&](const Scene& scene) { return picture_of(volumes, scene).statistics.shadow_rays; };
  const Scene lit = scene_of({matte(0, 0)}, {sun({1, -2, 1.5})});
  EXPECT_GT(rays_of(lit), 1000);
  EXPECT_EQ(rays_of(scene_of({matte(0, 0)}, {sun({1, -2, -1.5})})), 0) << "behind the surface";
  EXPECT_EQ(rays_of(scene_of({matte(0, 0)}, {sun({1, -2, 1.5}, {0, 0, 0})})), 0) << "without intensity";
  EXPECT_EQ(rays_of(without_shadows(lit)), 0);
  EXPECT_EQ(rays_of(scene_of({matte(0, 0)}, {{.casts_shadows = true}})), 0) << "at the eye";
  Scene other = lit;
  other.layers[0].surface.opacity = 0.5;
  EXPECT_EQ(rays_of(other), 0) << "clear";
  other = lit;
  other.layers[0].surface.ambient = 1;
  EXPECT_EQ(rays_of(other), 0) << "ambient light only";
  other = lit;
  other.layers[0].mode = render::Mode::mip, other.layers[0].window = volumes[0].field().range;
  EXPECT_EQ(rays_of(other), 0) << "no surface";
}

// What may hold light back is kept while the light stands still; a frame does not depend on those before it.
TEST(Shadows, are_the_same_whatever_frames_were_before) {
  const TemporaryFolder folder;
  const std::vector<render::Volume> volumes = both_kinds(
      folder, [](const Vec3& p) { return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z); }, 16);
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    render::FrameMemory memory;
    std::size_t frame = 0;
    for (const double isovalue : {0.2, 0.2, 0.1, 0.2})
      for (const Light& light : {sun({-2, -1, 1.5}), sun({-2, -1, 1.5}), sun({-2, -1, 1.4}), lamp({-2, -1, 1.5}),
                                 lamp({-2, -1, 1.5}), sun({-2, -1, 1.5}), sun({1, -1, 1}), sun({1, -1, 0.5})}) {
        Scene scene = scene_of({matte(v, isovalue)}, {light});
        scene.camera = render::fit_camera(cube, {.azimuth_deg = 33.0 + static_cast<double>(frame++ % 3)}, 1);
        Picture picture;
        picture.statistics =
            render::render(volumes, scene, {.width = edge, .height = edge, .channels = all_channels, .threads = 2},
                           picture.pixels, memory);
        const Picture fresh = picture_of(volumes, scene);
        ASSERT_EQ(picture.pixels.color, fresh.pixels.color) << frame << " of " << v;
        EXPECT_EQ(picture.statistics.shadow_rays, fresh.statistics.shadow_rays);
        EXPECT_NE(picture.pixels.color, picture_of(volumes, without_shadows(scene)).pixels.color);
      }
  }
}

TEST(Lights, that_are_one_together_give_the_light_of_one) {
  const TemporaryFolder folder;
  const std::vector<render::Volume> volumes = both_kinds(folder, waves, 12);
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    Layer layer = matte(v, 0.2);
    layer.surface = {};
    const Picture one = picture_of(volumes, scene_of({layer}, {{}})),
                  halves = picture_of(volumes, scene_of({layer}, {{.color = {0.25, 0.25, 0.25}},
                                                                  {.color = {0, 0, 0}},
                                                                  {.color = {0.75, 0.75, 0.75}}})),
                  none = picture_of(volumes, scene_of({layer}, {}));
    for (std::size_t i = 0; i < one.pixels.color.size(); ++i)
      ASSERT_NEAR(one.pixels.color[i], halves.pixels.color[i], 2e-5);
    for (std::size_t p = 0; p < none.pixels.pixel_count(); ++p)
      if (none.is_hit(p)) {
        ASSERT_NEAR(none.red(p), 0.12 * 0.78, 1e-6);
      }
  }
}

/// A floor at z = -0.5 and a wall at x = -0.3.
std::vector<render::Volume> floor_and_wall(const TemporaryFolder& folder) {
  std::vector<render::Volume> volumes;
  const Index3 samples(7, 7, 7);
  const Box3 wide{{-9, -9, -9}, {9, 9, 9}};
  volumes.push_back(packed(folder, "floor.rho",
                           sampled_volume<double>(samples, lattice_over(wide, samples), linear_field({0, 0, 1}))));
  preprocess::NeutralMesh mesh = box_mesh({.cells = {5, 5, 5}, .box = wide});
  add_point_field(mesh, "value", linear_field({1, 0, 0}));
  volumes.push_back(packed(folder, "wall.rho", mesh));
  return volumes;
}

TEST(Occlusion, of_a_floor_beside_a_wall_is_the_share_of_the_disk_that_the_wall_takes) {
  const TemporaryFolder folder;
  const std::vector<render::Volume> volumes = floor_and_wall(folder);
  Scene scene = scene_of({matte(0, -0.5), matte(1, -0.3)}, {});
  for (Layer& layer : scene.layers) layer.surface.ambient = 1;
  scene.occlusion = {.samples = 64, .radius = 0.8};
  const Picture found = picture_of(volumes, scene, 2);
  double sum = 0, largest = 0;
  std::size_t count = 0, untouched = 0;
  for (std::size_t p = 0; p < found.pixels.pixel_count(); ++p) {
    if (!found.is_hit(p)) continue;
    const Vec3 place = place_of(scene, found, p);
    if (place.z > -0.4999 || place.x < -0.299) continue;
    // Of directions weighed by the cosine, as points of the unit disk, those meet the wall within the radius that lie
    // beyond a chord.
    const double chord = (place.x + 0.3) / 0.8;
    const double taken = chord < 1 ? (std::acos(chord) - chord * std::sqrt(1 - chord * chord)) / std::numbers::pi : 0;
    const double error = static_cast<double>(found.red(p)) - (1 - taken);
    sum += error, largest = std::max(largest, std::abs(error)), ++count;
    untouched += chord > 1 && error == 0;
  }
  EXPECT_GT(count, 2000);
  EXPECT_GT(untouched, 500);
  EXPECT_LT(std::abs(sum / static_cast<double>(count)), 0.002);
  EXPECT_LT(largest, 0.08);  // of 64 points spread evenly, about five about the chord may be on its wrong side
  EXPECT_EQ(found.statistics.occlusion_rays, 64 * found.statistics.hits);
  EXPECT_EQ(found.statistics.shadow_rays, 0);
}

TEST(Occlusion, leaves_a_plane_as_it_is_and_a_ball_but_for_its_cells) {
  for (const double scale : scales) {
    const TemporaryFolder folder;
    const std::vector<render::Volume> planes = both_kinds(folder, linear_field({0.3, -0.7, 0.2}), 8, scale);
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
  const std::vector<render::Volume> volumes = both_kinds(folder, waves, 12);
  Scene scene = scene_of({matte(0, 0.2)}, {{}});
  const Picture clear = picture_of(volumes, scene);
  const double near = (scene.camera.position - scene.camera.target).length() - 0.5;
  scene.fog = {.color = {1, 0.5, 0}, .range = {.lo = near, .hi = near + 1}};
  const Picture found = picture_of(volumes, scene);
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
  scene.layers[1].surface.opacity = 0.4;
  scene.layers[2].surface.specular = 0.5;
  scene.layers[2].surface.normals = render::Normals::smooth;
  scene.occlusion = {.samples = 3, .radius = 0.5};
  scene.fog = render::Fog{.color = {0, 0, 1}, .range = {.lo = 0, .hi = 20}};
  return scene;
}

TEST(Lighting, is_the_same_for_any_number_of_threads_and_any_refinement) {
  const TemporaryFolder folder;
  const std::vector<render::Volume> volumes = both_kinds(folder, waves, 12);
  const Scene scene = full_scene();
  const Picture one = picture_of(volumes, scene), three = picture_of(volumes, scene, 3);
  expect_same_bits(one.pixels, three.pixels);
  EXPECT_EQ(one.statistics.shadow_rays, three.statistics.shadow_rays);
  EXPECT_EQ(one.statistics.occlusion_rays, three.statistics.occlusion_rays);
  Framebuffer refined;
  render::FrameMemory memory;
  render::refine(volumes, scene, {.width = edge, .height = edge, .channels = all_channels}, {.first_spacing = 4},
                 refined, memory);
  expect_same_bits(one.pixels, refined);
}

TEST(Lighting, of_a_linear_field_is_that_of_a_mesh) {
  const TemporaryFolder folder;
  std::vector<render::Volume> volumes = both_kinds(folder, linear_field({0.3, -0.4, 1}), 8);
  for (render::Volume& volume : ball_over_floor(folder, false)) volumes.push_back(std::move(volume));
  std::vector<Picture> pictures;
  for (const std::size_t v : {0U, 1U}) {
    Scene scene = scene_of({matte(v, -0.6), matte(2, -0.16)}, {sun({1, -0.7, 1.9}), {}});
    scene.layers[0].surface.specular = 0.3;
    scene.occlusion = {.samples = 4, .radius = 0.7};
    pictures.push_back(picture_of(volumes, scene));
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
  const std::vector<render::Volume> volumes = both_kinds(folder, ball, 4);
  const Scene fine = scene_of({matte(0, 0)}, {sun({0, 0, 1})});
  const auto refused = [&](const auto& change) {
    Scene scene = fine;
    change(scene);
    try {
      picture_of(volumes, scene);
    } catch (const Error& error) {
      return error.trouble() == Trouble::usage;
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

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "formats/base/error.h"
#include "render/ray_caster.h"
#include "tests/render/frame/clipped_pictures.h"
#include "tests/support/expect_error.h"

/// What a clip region leaves of a picture.
namespace rhoray::tests {
namespace {

using namespace clipped;
using render::Ray;

/// Returns all crossings of an isosurface along a ray, from exact arithmetic.
std::vector<double> crossings_on(render::RayCaster& judge, Ray ray) {
  std::vector<double> all;
  for (;;) {
    const render::Hit hit = judge.first_crossing(ray);
    if (hit.is_miss()) return all;
    all.push_back(hit.t);
    ray.t_min = hit.t + 1e-7;
  }
}

TEST(Clip, shows_the_first_of_the_exact_crossings_that_is_kept) {
  const Shown shown;
  const double isovalues[] = {0.4, 0.3, 0.5};
  for (const bool orthographic : {false, true})
    for (std::size_t v = 0; v < 3; ++v) {
      const Scene whole = scene_of({surface(v, isovalues[v], render::Accuracy::float32)}, {}, orthographic);
      const render::Dataset& dataset = shown.datasets[v];
      render::RayCaster judge(dataset, isovalues[v], render::method_of(render::Accuracy::exact));
      const std::vector<Ray> rays = camera_rays(dataset, whole.camera, edge, edge);
      const Affine& world = world_from_ray_frame(dataset);
      std::vector<std::vector<double>> crossings;
      for (const Ray& ray : rays) crossings.push_back(crossings_on(judge, ray));
      for (const render::Accuracy accuracy :
           {render::Accuracy::float32, render::Accuracy::float64, render::Accuracy::certified}) {
        std::size_t hits = 0, misses = 0, changed = 0, wrong = 0;
        for (const Clip& clip : regions()) {
          Scene scene = whole;
          scene.clip = clip;
          scene.layers[0].method = render::method_of(accuracy);
          const Picture found = picture_of(shown.datasets, scene);
          EXPECT_GT(found.statistics.rays_clipped, 100);
          for (std::size_t p = 0; p < rays.size(); ++p) {
            double expected = infinity;
            bool is_clear_cut = true;
            for (std::size_t c = 0; c < crossings[p].size() && expected == infinity; ++c) {
              const std::optional<bool> kept = is_kept(clip, world.point(rays[p].at(crossings[p][c])));
              is_clear_cut &= kept.has_value() && (c == 0 || crossings[p][c] - crossings[p][c - 1] > 1e-3);
              if (kept.value_or(false)) expected = crossings[p][c];
            }
            if (!is_clear_cut) continue;
            (expected < infinity ? hits : misses) += 1;
            changed += !crossings[p].empty() && expected != crossings[p].front();
            const double depth = static_cast<double>(found.pixels.depth[p]);
            wrong += expected == infinity ? depth < infinity : !(std::abs(depth - expected) < 2e-5);
          }
        }
        EXPECT_GT(hits, 2500);
        EXPECT_GT(misses, 2500);
        EXPECT_GT(changed, 1500);
        // In single precision, a ray that grazes the surface may hit or miss.
        EXPECT_LE(wrong, accuracy == render::Accuracy::float32 ? 8 : 0);
      }
    }
}

TEST(Clip, parts_a_picture_into_what_is_kept_and_what_is_cut_away) {
  const Shown shown;
  for (std::size_t v = 0; v < 4; ++v)
    for (const Clip& clip : regions()) {
      if (clip.cuts_away) continue;
      Scene scene = scene_of({surface(v, 0.35, render::Accuracy::float64)});
      const Picture whole = picture_of(shown.datasets, scene);
      scene.clip = clip;
      const Picture inside = picture_of(shown.datasets, scene);
      scene.clip->cuts_away = true;
      const Picture outside = picture_of(shown.datasets, scene);
      std::size_t differing = 0;
      for (std::size_t p = 0; p < whole.pixels.pixel_count(); ++p) {
        const float nearest = std::min(inside.pixels.depth[p], outside.pixels.depth[p]);
        if (std::isinf(nearest) || std::isinf(whole.pixels.depth[p]))
          differing += nearest != whole.pixels.depth[p];
        else
          differing += !(std::abs(nearest - whole.pixels.depth[p]) < 1e-5F);
      }
      // In a face the parts of a ray begin and end to rounding: a hit there may be in neither or in
      // both.
      EXPECT_LE(differing, 1) << v;
    }
}

TEST(Clip, ends_largest_values_at_its_faces) {
  const Shown shown;
  for (const std::size_t v : {0, 1, 2}) {
    Layer layer{.dataset = v, .mode = Mode::mip, .window = {-2, 2}};
    const Scene whole = scene_of({layer});
    const render::Dataset& dataset = shown.datasets[v];
    render::RayCaster kernel(dataset, 0, render::Method{});
    const std::vector<Ray> rays = camera_rays(dataset, whole.camera, edge, edge);
    const Affine& world = world_from_ray_frame(dataset);
    std::size_t different_from_whole = 0;
    for (const Clip& clip : regions()) {
      Scene scene = whole;
      scene.clip = clip;
      const Picture found = picture_of(shown.datasets, scene);
      for (std::size_t p = 0; p < rays.size(); ++p) {
        // Computed from the half spaces: the range of t in which the ray is inside the region.
        double from = -infinity, to = infinity;
        for (const HalfSpace& half : render::half_spaces_of(clip)) {
          const double along = half.normal.dot(world.vector(rays[p].direction)),
                       t = half.normal.dot(half.point - world.point(rays[p].origin)) / along;
          (along > 0 ? from : to) = along > 0 ? std::max(from, t) : std::min(to, t);
        }
        double expected = -infinity;
        const auto shading = [&](double t_min, double t_max) {
          Ray part = rays[p];
          part.t_min = std::max(t_min, 0.0), part.t_max = t_max;
          render::Hit hit;
          kernel.largest_values(std::span(&part, 1), std::span(&hit, 1));
          if (!hit.is_miss()) expected = std::max(expected, hit.value);
        };
        if (!clip.cuts_away)
          shading(from, to);
        else if (from <= to)
          shading(0, from), shading(to, infinity);
        else
          shading(0, infinity);
        const double value = found.pixels.value[p];
        if (expected == -infinity)
          EXPECT_TRUE(std::isnan(value)) << p;
        else
          EXPECT_NEAR(value, expected, 1e-12) << p;
        render::Hit hit;
        kernel.largest_values(std::span(&rays[p], 1), std::span(&hit, 1));
        different_from_whole += !hit.is_miss() && hit.value != expected;
      }
    }
    EXPECT_GT(different_from_whole, 8000);
  }
}

TEST(Clip, cuts_a_ball_where_formulas_say) {
  const TemporaryFolder folder;
  const Index3 samples(129, 129, 129);
  std::vector<render::Dataset> datasets;
  datasets.push_back(packed(
      folder, "ball.rho",
      sampled_volume<float>(samples, lattice_over(cube, samples), [](const Vec3& p) { return 1 - p.length2(); })));
  const double radius = 0.8, isovalue = 1 - radius * radius, height = 0.3;
  Scene scene =
      scene_of({surface(0, isovalue, render::Accuracy::float64)}, Clip{.planes = {{{0, 0, height}, {0, 0, -1}}}});
  scene.camera = render::fit_camera(cube, {.azimuth_deg = 0, .elevation_deg = 90, .orthographic = true}, 1);
  const int wide = 400;
  Framebuffer found;
  render::render(datasets[0], scene, {.width = wide, .height = wide, .channels = all_channels, .threads = 2}, found);
  const double pixel = scene.camera.orthographic_height / wide;
  std::size_t bowl = 0, rim = 0;
  for (std::size_t p = 0; p < found.pixel_count(); ++p) {
    const double across = (static_cast<double>(p % wide) + 0.5 - wide / 2.0) * pixel,
                 down = (static_cast<double>(p / wide) + 0.5 - wide / 2.0) * pixel,
                 square = across * across + down * down;
    const double z = scene.camera.position.z - static_cast<double>(found.depth[p]);
    const double expected = radius * radius - square;
    if (std::abs(expected) < 1e-3 || std::abs(expected - height * height) < 1e-3) continue;
    if (expected < 0) {
      EXPECT_TRUE(std::isinf(found.depth[p]));
    } else if (expected > height * height) {
      // The bottom, seen through the hole.
      EXPECT_NEAR(z, -std::sqrt(expected), 1e-4 / std::sqrt(expected));
      ++bowl;
    } else {
      EXPECT_NEAR(z, std::sqrt(expected), 1e-4 / std::sqrt(expected));
      ++rim;
    }
  }
  const double pi = std::acos(-1), area = pixel * pixel;
  EXPECT_NEAR(static_cast<double>(bowl) * area, pi * (radius * radius - height * height), 0.02);
  EXPECT_NEAR(static_cast<double>(rim) * area, pi * height * height, 0.02);
}

/// A field that is z, seen along z from above: every number is exact.
struct Ramp {
  TemporaryFolder folder;
  std::vector<render::Dataset> datasets;

  explicit Ramp(double far_away = 0) {
    const Index3 samples(9, 9, 9);
    Affine map;
    map.origin = Vec3(far_away);
    datasets.push_back(
        packed(folder, "grid.rho", sampled_volume<float>(samples, map, [=](const Vec3& p) { return p.z - far_away; })));
    preprocess::NeutralMesh mesh =
        box_mesh({.cells = {4, 4, 4}, .box = {Vec3(far_away), Vec3(far_away) + Vec3(8, 8, 8)}});
    add_point_field(mesh, "value", [=](const Vec3& p) { return p.z - far_away; });
    datasets.push_back(packed(folder, "mesh.rho", mesh));
  }

  Scene scene(std::size_t dataset, double isovalue, const Clip& clip, double far_away = 0) const {
    Scene scene = scene_of({surface(dataset, isovalue, render::Accuracy::float64)}, clip);
    scene.camera = {.position = Vec3(far_away) + Vec3(4, 4, 16),
                    .target = Vec3(far_away) + Vec3(4, 4, 0),
                    .up = {0, 1, 0},
                    .orthographic = true,
                    .orthographic_height = 7};
    return scene;
  }
};

TEST(Clip, decides_on_t_on_which_side_of_a_face_a_crossing_is) {
  constexpr std::size_t all = std::size_t{edge} * edge;
  for (const double far_away : {0.0, 0x1p20}) {
    const Ramp ramp(far_away);
    for (std::size_t v = 0; v < 2; ++v)
      for (const double z : {4.0, 5.0, 4.5})  // the first two are faces between cells
        for (const bool cuts_away : {false, true}) {
          const auto hits_at = [&](double isovalue, double sign) {
            const Clip clip{.planes = {{Vec3(far_away) + Vec3(0, 0, z), {0, 0, 3 * sign}}}, .cuts_away = cuts_away};
            return hit_count(picture_of(ramp.datasets, ramp.scene(v, isovalue, clip, far_away)).pixels);
          };
          const double above = cuts_away ? -1 : 1;
          EXPECT_EQ(hits_at(z + 0x1p-20, above), all);
          EXPECT_EQ(hits_at(z - 0x1p-20, above), 0);
          EXPECT_EQ(hits_at(z + 0x1p-20, -above), 0);
          EXPECT_EQ(hits_at(z - 0x1p-20, -above), all);
          // In the face itself: where one part of the ray ends on one side of the surface, the
          // other part begins on it.
          EXPECT_EQ(hits_at(z, above) + hits_at(z, -above), all);
        }
  }
}

TEST(Clip, draws_no_surface_in_its_faces) {
  const Shown shown;
  // Everything is inside: a field that is above the isovalue everywhere has no surface, wherever it
  // is clipped.
  for (std::size_t v = 0; v < 3; ++v)
    for (const Clip& clip : regions())
      EXPECT_EQ(
          hit_count(picture_of(shown.datasets, scene_of({surface(v, -3, render::Accuracy::float32)}, clip)).pixels), 0);
}

TEST(Clip, leaves_layers_whole_that_say_so) {
  const Shown shown;
  std::vector<Layer> layers{surface(0, 0.4, render::Accuracy::float32), surface(3, 0, render::Accuracy::float32)};
  layers[1].clipped = false;
  const Clip none_of_it{.box = Box3({5, 5, 5}, {6, 6, 6})};
  const Picture found = picture_of(shown.datasets, scene_of(layers, none_of_it)),
                expected = picture_of(shown.datasets, scene_of({layers[1]}));
  EXPECT_EQ(found.pixels.color, expected.pixels.color);
  EXPECT_EQ(found.statistics.rays_clipped, 0);
}

TEST(Clip, costs_nothing_where_it_takes_nothing_away) {
  const Shown shown;
  const std::vector<Layer> layers{surface(0, 0.4, render::Accuracy::float32),
                                  surface(1, 0.2, render::Accuracy::float32, 0.5)};
  const Picture without = picture_of(shown.datasets, scene_of(layers));
  for (const Clip& clip :
       {Clip{}, Clip{.box = Box3({-1, -1, -1}, {1, 1, 1})}, Clip{.planes = {{{0, 0, -4}, {0, 0, 1}}}},
        Clip{.box = Box3({2, 2, 2}, {3, 3, 3}), .cuts_away = true}}) {
    const Picture with = picture_of(shown.datasets, scene_of(layers, clip));
    EXPECT_EQ(with.pixels.color, without.pixels.color);
    EXPECT_EQ(with.statistics.rays_clipped, 0);
    EXPECT_EQ(with.statistics.rays_clipped_away, 0);
    EXPECT_EQ(with.statistics.cells_visited, without.statistics.cells_visited);
    EXPECT_EQ(with.statistics.rays_ruled_out, without.statistics.rays_ruled_out);
  }
}

TEST(Clip, leaves_out_rays_that_it_leaves_nothing_of) {
  const Shown shown;
  for (std::size_t v = 0; v < 3; ++v) {
    Layer layer = surface(v, 0.4, render::Accuracy::float64);
    for (const Mode mode : {Mode::isosurface, Mode::mip}) {
      layer.mode = mode;
      layer.window = {-2, 2};
      const Picture whole = picture_of(shown.datasets, scene_of({layer}));
      for (const Clip& clip : regions()) {
        const Picture with = picture_of(shown.datasets, scene_of({layer}, clip)),
                      slow = picture_of(shown.datasets, scene_of({layer}, clip), 1, false);
        EXPECT_EQ(with.pixels.depth, slow.pixels.depth);
        EXPECT_EQ(with.pixels.color, slow.pixels.color);
        EXPECT_GE(with.statistics.rays_ruled_out, whole.statistics.rays_ruled_out);
        EXPECT_EQ(slow.statistics.rays_ruled_out, 0);
      }
      const Clip small{.box = Box3({-0.2, -0.2, -0.2}, {0.1, 0.1, 0.1})};
      const Picture little = picture_of(shown.datasets, scene_of({layer}, small));
      EXPECT_GT(little.statistics.rays_ruled_out, whole.statistics.rays_ruled_out + edge * edge / 4);
      EXPECT_LT(little.statistics.macrocells_visited + little.statistics.cells_visited,
                whole.statistics.macrocells_visited + whole.statistics.cells_visited);
      EXPECT_GT(little.statistics.rays_clipped_away, 50);
    }
  }
}

TEST(Clip, shows_the_background_where_nothing_is_left) {
  const Shown shown;
  for (const Clip& clip : {Clip{.box = Box3({2, 2, 2}, {3, 3, 3})}, Clip{.planes = {{{0, 0, 2}, {0, 0, 1}}}},
                           Clip{.box = Box3({-2, -2, -2}, {3, 3, 3}), .cuts_away = true}}) {
    const Picture found = picture_of(shown.datasets, scene_of({surface(0, 0.4, render::Accuracy::float32)}, clip));
    EXPECT_EQ(hit_count(found.pixels), 0);
    EXPECT_EQ(found.statistics.rays_ruled_out, found.statistics.rays);
    EXPECT_EQ(found.pixels.color[0], 0.9F);
  }
}

TEST(Clip, keeps_the_order_of_clear_surfaces) {
  const Shown shown;
  std::vector<Layer> layers{
      surface(2, 0.5, render::Accuracy::float32, 0.3), surface(2, 0.3, render::Accuracy::float32, 0.5),
      surface(0, 0.4, render::Accuracy::float32, 0.2), surface(3, 0, render::Accuracy::float32, 0.4)};
  // Only ambient light: a pixel is then the mix of the layers' colours, and shows how often each
  // was hit.
  for (Layer& layer : layers) layer.material.ambient = 1, layer.material.specular = 0;
  layers[3].clipped = false;
  const Scene whole = scene_of(layers);
  struct Crossing {
    double t;
    std::size_t layer;
  };
  std::vector<std::vector<Crossing>> crossings(std::size_t{edge} * edge);
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const render::Dataset& dataset = shown.datasets[layers[l].dataset];
    render::RayCaster judge(dataset, layers[l].isovalue,
                            render::method_of(l == 3 ? render::Accuracy::float64 : render::Accuracy::exact));
    const std::vector<Ray> rays = camera_rays(dataset, whole.camera, edge, edge);
    for (std::size_t p = 0; p < rays.size(); ++p)
      for (const double t : crossings_on(judge, rays[p])) crossings[p].push_back({t, l});
  }
  for (auto& along : crossings)
    std::sort(along.begin(), along.end(), [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  const render::Dataset& grid = shown.datasets[0];
  const std::vector<Ray> rays = camera_rays(grid, whole.camera, edge, edge);
  for (const Clip& clip : regions()) {
    Scene scene = whole;
    scene.clip = clip;
    const Picture found = picture_of(shown.datasets, scene, 2);
    std::size_t checked = 0;
    for (std::size_t p = 0; p < rays.size(); ++p) {
      Vec3 light(0, 0, 0);
      double through = 1;
      bool is_clear_cut = true;
      for (std::size_t c = 0; c < crossings[p].size(); ++c) {
        const Crossing& crossing = crossings[p][c];
        const Layer& layer = layers[crossing.layer];
        is_clear_cut &= c == 0 || crossing.t - crossings[p][c - 1].t > 1e-4;
        const std::optional<bool> kept = is_kept(clip, world_from_ray_frame(grid).point(rays[p].at(crossing.t)));
        is_clear_cut &= kept.has_value();
        if (layer.clipped && !kept.value_or(false)) continue;
        light += through * layer.material.opacity * layer.material.color;
        through *= 1 - layer.material.opacity;
      }
      if (!is_clear_cut || through < 0.01) continue;
      ++checked;
      light += through * scene.background;
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(static_cast<double>(found.pixels.color[4 * p + static_cast<std::size_t>(c)]), light[c], 1e-5) << p;
    }
    EXPECT_GT(checked, rays.size() / 2);
  }
}

TEST(Clip, gives_the_same_bytes_for_any_number_of_threads_and_in_passes) {
  const Shown shown;
  std::vector<Layer> layers{surface(0, 0.4, render::Accuracy::float32), surface(1, 0.2, render::Accuracy::float32, 0.5),
                            surface(2, 0.3, render::Accuracy::float32, 0.7), surface(3, 0, render::Accuracy::float32)};
  layers[3].clipped = false;
  for (const Clip& clip : regions()) {
    Scene scene = scene_of(layers, clip);
    scene.lights.push_back({.kind = render::Light::Kind::point, .place = {-3, -2, 4}, .casts_shadows = true});
    const Picture one = picture_of(shown.datasets, scene), three = picture_of(shown.datasets, scene, 3);
    EXPECT_EQ(one.pixels.color, three.pixels.color);
    EXPECT_EQ(one.pixels.depth, three.pixels.depth);
    EXPECT_EQ(one.statistics.rays_clipped, three.statistics.rays_clipped);
    EXPECT_EQ(one.statistics.rays_clipped_away, three.statistics.rays_clipped_away);
    Framebuffer refined;
    render::RenderContext memory;
    render::refine(shown.datasets, scene, {.width = edge, .height = edge, .channels = all_channels, .threads = 2},
                   {.first_spacing = 4}, refined, memory);
    EXPECT_EQ(one.pixels.color, refined.color);
  }
}

TEST(Clip, refuses_what_is_no_region) {
  const Shown shown;
  const auto refuse = [&](const Clip& clip, const char* what) {
    expect_error(ErrorCode::usage, what,
                 [&] { picture_of(shown.datasets, scene_of({surface(0, 0.4, render::Accuracy::float32)}, clip)); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuse({.box = Box3({0, 0, 0}, {1, 0, 1})}, "expected one that is not empty");
  refuse({.box = Box3({0, 0, nan}, {1, 1, 1})}, "expected one that is not empty");
  refuse({.planes = {{{0, 0, 0}, {0, 0, 0}}}}, "expected finite numbers and a direction");
  refuse({.planes = {{{0, nan, 0}, {0, 0, 1}}}}, "expected finite numbers and a direction");
  refuse({.planes = std::vector<HalfSpace>(7)}, "7 clip planes; expected at most 6");
}

}  // namespace
}  // namespace rhoray::tests

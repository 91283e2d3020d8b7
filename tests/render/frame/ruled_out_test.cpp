#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "formats/base/error.h"
#include "render/ray_caster.h"
#include "render/render.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

/// Rays that certainly miss everything are not traced: pictures are the same as when all rays are
/// traced one by one.
namespace rhoray::tests {
namespace {

using render::Accuracy;
using render::Framebuffer;
using render::FrameOptions;
using render::FrameStatistics;
using render::Hit;
using render::Method;
using render::Mode;
using render::Scene;

/// Two balls in opposite corners of a box, one of them small.
Field two_balls() {
  return
      [](const Vec3& p) { return std::max(9 - (p - Vec3(12, 10, 13)).length(), 3 - (p - Vec3(40, 30, 33)).length()); };
}

Affine oriented() {
  return {{0.6, 0.8, 0}, {-1.6, 1.2, 0}, {0, 0, 0.5}, {1000, -2000, 500}};
}

/// NaN counts as equal to NaN.
bool same(double a, double b) {
  return std::memcmp(&a, &b, sizeof(double)) == 0 || (std::isnan(a) && std::isnan(b));
}

/// Counts the pixels that differ from the result of the ray itself.
int different_pixels(const Framebuffer& picture, const std::vector<Hit>& hits) {
  int different = 0;
  for (std::size_t pixel = 0; pixel < hits.size(); ++pixel) {
    const Hit& hit = hits[pixel];
    const bool is_same = picture.color[4 * pixel + 3] == (hit.is_miss() ? 0 : 1) &&
                         picture.depth[pixel] == static_cast<float>(hit.t) &&
                         picture.cell[pixel] == (hit.is_miss() ? Framebuffer::no_cell : hit.cell) &&
                         same(picture.value[pixel], hit.is_miss() ? std::nan("") : hit.value) &&
                         picture.roots[pixel] == hit.root_count && picture.iterations[pixel] == hit.iteration_count &&
                         (picture.error.empty() || same(picture.error[pixel], static_cast<float>(hit.error)));
    different += !is_same;
  }
  return different;
}

struct Shown {
  FrameStatistics statistics;
  Framebuffer picture;
  std::vector<Hit> hits;  ///< of all rays, one by one
};

Shown show(const render::Dataset& dataset, const Scene& scene, FrameOptions options) {
  Shown shown;
  const Method& method = scene.layers[0].method;
  options.channels = {.depth = true,
                      .normal = true,
                      .cell = true,
                      .value = true,
                      .error = proves(method),
                      .roots = true,
                      .iterations = true,
                      .cost = true};
  shown.statistics = render::render(dataset, scene, options, shown.picture);
  const std::vector<render::Ray> rays = render::camera_rays(dataset, scene.camera, options.width, options.height);
  shown.hits.resize(rays.size());
  render::RayCaster queries(dataset, scene.layers[0].isovalue, method);
  if (scene.layers[0].mode == Mode::mip)
    queries.largest_values(rays, shown.hits);
  else
    queries.first_crossings(rays, shown.hits);
  return shown;
}

/// From afar with much background, near, inside with most of the data behind the eye, and from a
/// face of the box.
std::vector<render::Camera> cameras_of(const render::Dataset& dataset) {
  const Box3 box = dataset.bounds();
  const Vec3 middle = box.center(), size = box.size();
  render::Camera far = fit_camera(box, render::named_view("iso"), 1.3);
  far.position = middle + 2.4 * (far.position - middle);
  render::Camera flat = far;
  flat.orthographic = true;
  flat.orthographic_height = 2.2 * size.length();
  return {far,
          flat,
          fit_camera(box, render::named_view("+x"), 1.3),
          {.position = middle, .target = box.max, .up = {0, 0, 1}, .vertical_fov_deg = 80},
          {.position = {box.min.x, middle.y, middle.z}, .target = middle, .up = {0, 1, 1}, .vertical_fov_deg = 120}};
}

TEST(RuledOut, rays_are_those_that_miss_and_pictures_stay_the_same) {
  const TracedDataset grid(sampled_volume<float>(
      {49, 43, 45}, oriented(), [](const Vec3& p) { return two_balls()(oriented().inverse().point(p)); }));
  const TracedDataset mesh(box_mesh({.cells = {12, 10, 11}, .box = Box3({0, 0, 0}, {48, 42, 44})}, two_balls()));
  for (const TracedDataset* traced : {&grid, &mesh})
    for (const Accuracy accuracy :
         {Accuracy::preview, Accuracy::float32, Accuracy::float64, Accuracy::certified, Accuracy::exact})
      for (const Mode mode : {Mode::isosurface, Mode::mip}) {
        const bool is_exact = accuracy == Accuracy::exact;
        if (mode == Mode::mip && accuracy != Accuracy::float64 && accuracy != Accuracy::certified) continue;
        const bool is_wide = mode == Mode::isosurface && accuracy != Accuracy::float64 && !is_exact;
        const FrameOptions options{.width = is_exact  ? 13
                                            : is_wide ? 133
                                                      : 53,
                                   .height = is_exact  ? 10
                                             : is_wide ? 101
                                                       : 41,
                                   .threads = 2};
        std::uint64_t ruled_out = 0, rays = 0, missed = 0;
        for (const render::Camera& camera : cameras_of(traced->dataset())) {
          Scene scene;
          scene.camera = camera;
          scene.layers[0].mode = mode;
          scene.layers[0].method = method_of(accuracy);
          scene.layers[0].window = {.lo = -30, .hi = 10};
          const Shown shown = show(traced->dataset(), scene, options);
          EXPECT_EQ(different_pixels(shown.picture, shown.hits), 0) << static_cast<int>(accuracy);
          const auto misses = static_cast<std::uint64_t>(
              std::count_if(shown.hits.begin(), shown.hits.end(), [](const Hit& hit) { return hit.is_miss(); }));
          EXPECT_EQ(shown.statistics.rays, shown.hits.size());
          EXPECT_EQ(shown.statistics.hits + misses, shown.hits.size());
          EXPECT_LE(shown.statistics.rays_ruled_out, misses);
          ruled_out += shown.statistics.rays_ruled_out, missed += misses, rays += shown.hits.size();
        }
        EXPECT_GT(missed, rays / 4);
        // Scalar kernels rule out rays by the volume's bounds alone; in small pictures blocks are
        // large.
        const bool has_boxes = is_wide && render::chosen_machine() != render::Machine::scalar;
        const std::uint64_t expected = has_boxes ? missed * 6 / 10 : is_exact ? 0 : missed / 16;
        EXPECT_GE(ruled_out, expected) << static_cast<int>(accuracy) << " of " << missed;
      }
}

TEST(RuledOut, all_rays_are_where_the_isovalue_is_passed_nowhere) {
  const TracedDataset grid(sampled_volume<float>({49, 43, 45}, {}, two_balls()));
  const TracedDataset mesh(box_mesh({.cells = {12, 10, 11}, .box = Box3({0, 0, 0}, {48, 42, 44})}, two_balls()));
  for (const TracedDataset* traced : {&grid, &mesh})
    for (const int spacing : {1, 4}) {
      Scene scene;
      scene.background = {0.25, 0.5, 0.75};
      scene.camera = fit_camera(traced->dataset().bounds(), render::named_view("iso"), 1);
      scene.layers[0].isovalue = 100;
      scene.layers[0].method = method_of(Accuracy::float32);
      const FrameOptions options{.width = 75, .height = 53, .channels = {.depth = true, .cell = true, .cost = true}};
      Framebuffer picture(75, 53, options.channels);
      std::fill(picture.color.begin(), picture.color.end(), -1.0F);
      render::RenderContext memory;
      const FrameStatistics statistics =
          render::refine(traced->dataset(), scene, options, {.first_spacing = spacing}, picture, memory);
      EXPECT_EQ(statistics.rays, 75U * 53U);
      EXPECT_EQ(statistics.machine, name_of(render::chosen_machine()));
      if (render::chosen_machine() != render::Machine::scalar) {
        EXPECT_EQ(statistics.rays_ruled_out, 75U * 53U);
        EXPECT_EQ(statistics.macrocells_visited + statistics.cells_visited, 0U);
      }
      for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel) {
        ASSERT_EQ(picture.color[4 * pixel], 0.25F);
        ASSERT_EQ(picture.color[4 * pixel + 2], 0.75F);
        ASSERT_EQ(picture.color[4 * pixel + 3], 0.0F);
        ASSERT_TRUE(std::isinf(picture.depth[pixel]));
        ASSERT_EQ(picture.cell[pixel], Framebuffer::no_cell);
        ASSERT_EQ(picture.cost[pixel], 0U);
      }
    }
}

TEST(RuledOut, no_rays_are_without_the_hierarchy) {
  const TracedDataset grid(sampled_volume<float>({20, 21, 22}, {}, two_balls()));
  Scene scene;
  scene.camera = cameras_of(grid.dataset()).front();
  scene.layers[0].window = {.lo = -30, .hi = 10};
  Framebuffer picture;
  for (const Mode mode : {Mode::isosurface, Mode::mip}) {
    scene.layers[0].mode = mode;
    const FrameOptions options{.width = 40, .height = 40, .use_hierarchy = false};
    EXPECT_EQ(render::render(grid.dataset(), scene, options, picture).rays_ruled_out, 0U);
  }
}

// The mask that rules rays out is computed again for each lattice of pixels.
TEST(RuledOut, rays_of_refined_pictures_are_about_as_many) {
  const TracedDataset grid(sampled_volume<float>({49, 43, 45}, {}, two_balls()));
  Scene scene;
  scene.camera = cameras_of(grid.dataset()).front();
  scene.layers[0].method = method_of(Accuracy::float32);
  const FrameOptions options{.width = 300, .height = 220};
  Framebuffer plain, refined;
  render::RenderContext memory;
  const FrameStatistics at_once = render::render(grid.dataset(), scene, options, plain);
  const FrameStatistics in_passes =
      render::refine(grid.dataset(), scene, options, {.first_spacing = 2}, refined, memory);
  EXPECT_EQ(plain.color, refined.color);
  EXPECT_GT(in_passes.rays_ruled_out, at_once.rays_ruled_out * 9 / 10);
  EXPECT_GT(at_once.hits, 300U);
}

TEST(RuledOut, layers_outside_the_view_are_not_looked_at_unless_they_shade_what_is_in_it) {
  const Affine beside{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {500, 0, 0}};
  const std::vector<render::Dataset> datasets = [&] {
    std::vector<render::Dataset> both;
    both.push_back(TracedDataset(sampled_volume<float>({49, 43, 45}, {}, two_balls())).dataset());
    both.push_back(TracedDataset(sampled_volume<float>({49, 43, 45}, beside, [&](const Vec3& p) {
                     return two_balls()(beside.inverse().point(p));
                   })).dataset());
    return both;
  }();
  Scene scene;
  scene.camera = fit_camera(datasets[0].bounds(), render::named_view("-y"), 1);
  const FrameOptions options{.width = 90, .height = 90, .channels = {.cell = true}};
  const auto drawn = [&](const Scene& shown) {
    Framebuffer picture;
    const FrameStatistics statistics = render::render(datasets, shown, options, picture);
    return std::pair{picture.color, statistics};
  };
  const auto alone = drawn(scene);
  EXPECT_GT(alone.second.hits, 100U);
  render::Layer far = scene.layers[0];
  far.dataset = 1;
  far.material.color_by = render::FieldColors{.field = "not there", .range = {.lo = 0, .hi = 1}};
  scene.layers.push_back(far);
  const auto with_far = drawn(scene);  // would be refused in view
  EXPECT_EQ(with_far.first, alone.first);
  EXPECT_EQ(with_far.second.cells_visited, alone.second.cells_visited);
  EXPECT_EQ(with_far.second.macrocells_visited, alone.second.macrocells_visited);

  scene.camera = fit_camera(datasets[1].bounds(), render::named_view("-y"), 1);
  EXPECT_THROW(drawn(scene), Error);

  // Low light from the side of the far volume: that volume occludes it, whether it is in view or
  // not.
  scene.layers[1].material.color_by.reset();
  scene.camera = fit_camera(datasets[0].bounds(), render::named_view("-y"), 1);
  scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, 0, 0}, .casts_shadows = true}};
  Scene without = scene;
  without.layers.pop_back();
  EXPECT_NE(drawn(scene).first, drawn(without).first);
}

}  // namespace
}  // namespace rhoray::tests

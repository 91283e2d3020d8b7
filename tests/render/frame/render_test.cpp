#include "render/render.h"
#include "render/triangles/facets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "formats/base/error.h"
#include "tests/render/support/allocation_count.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/equal_bytes.h"
#include "tests/support/expect_error.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::FrameOptions;
using render::FrameStatistics;
using render::Light;
using render::Method;
using render::Mode;
using render::Scene;

constexpr render::ChannelSet all_channels{.depth = true, .normal = true, .cell = true, .value = true};

bool same_bytes(const Framebuffer& a, const Framebuffer& b) {
  return a.width == b.width && a.height == b.height && equal_bytes(a.color, b.color) && equal_bytes(a.depth, b.depth) &&
         equal_bytes(a.normal, b.normal) && equal_bytes(a.cell, b.cell) && equal_bytes(a.value, b.value);
}

Scene scene_of(const render::Dataset& dataset, Mode mode, std::string_view view = "iso", double aspect = 1) {
  Scene scene;
  scene.layers[0].mode = mode;
  scene.camera = fit_camera(dataset.bounds(), render::named_view(view), aspect);
  scene.layers[0].isovalue = 0;
  scene.layers[0].window = {.lo = -10, .hi = 10};
  return scene;
}

Field blob() {
  return [](const Vec3& p) { return 7 - (p - Vec3(12, 10, 13)).length() + std::sin(p.x) * std::cos(1.3 * p.y); };
}
TEST(Render, gives_the_same_bytes_and_counts_for_any_number_of_threads) {
  TracedDataset grid(sampled_volume<float>({25, 22, 27}, {}, blob()));
  TracedDataset mesh(box_mesh({.cells = {8, 7, 9}, .box = Box3({0, 0, 0}, {24, 21, 26})}, blob()));
  for (const TracedDataset* traced : {&grid, &mesh})
    for (const Mode mode : {Mode::isosurface, Mode::mip})
      for (const auto& [width, height] : {std::pair(1, 1), {1, 7}, {33, 65}, {64, 32}, {131, 70}}) {
        const Scene scene = scene_of(traced->dataset(), mode, "iso", static_cast<double>(width) / height);
        FrameOptions options{.width = width, .height = height, .channels = all_channels, .threads = 1};
        Framebuffer one, many;
        const FrameStatistics first = render::render(traced->dataset(), scene, options, one);
        EXPECT_EQ(first.rays, static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height));
        EXPECT_GT(first.hits, 0U);
        for (const unsigned threads : {2U, 8U}) {
          options.threads = threads;
          const FrameStatistics again = render::render(traced->dataset(), scene, options, many);
          EXPECT_TRUE(same_bytes(one, many)) << width << " x " << height << ", " << threads << " threads";
          EXPECT_EQ(again.hits, first.hits);
          EXPECT_EQ(again.macrocells_visited, first.macrocells_visited);
          EXPECT_EQ(again.cells_visited, first.cells_visited);
          EXPECT_EQ(again.cells_solved, first.cells_solved);
          EXPECT_EQ(again.highlights_shaded, first.highlights_shaded);
        }
      }
}

/// Lookups that effects need in addition to hits do not change the hits, are counted, and are not
/// done for a scene without these effects.
TEST(Render, looks_up_normals_and_colours_for_scenes_that_ask_for_them_and_for_no_others) {
  TracedDataset grid(sampled_volume<float>({25, 22, 27}, {}, blob()));
  TracedDataset mesh(box_mesh({.cells = {8, 7, 9}, .box = Box3({0, 0, 0}, {24, 21, 26})}, blob()));
  for (const TracedDataset* traced : {&grid, &mesh})
    for (const auto accuracy : {render::Accuracy::float32, render::Accuracy::float64, render::Accuracy::certified}) {
      const render::Dataset& dataset = traced->dataset();
      Scene scene = scene_of(dataset, Mode::isosurface);
      scene.layers[0].method = method_of(accuracy);
      scene.layers[0].material.ambient = 1, scene.layers[0].material.specular = 0;
      FrameOptions options{.width = 61, .height = 47, .channels = all_channels};
      Framebuffer plain, looked_up, again;
      const FrameStatistics without = render::render(dataset, scene, options, plain);
      EXPECT_GT(without.hits, 100U);
      EXPECT_EQ(without.normals_smoothed + without.colors_looked_up, 0U);

      scene.layers[0].material.color_by = {.field = "value", .map = render::ColorMap::cubehelix, .range = {-3, 5}};
      scene.layers[0].material.normals = render::Normals::smooth;
      options.threads = 1;
      const FrameStatistics with = render::render(dataset, scene, options, looked_up);
      EXPECT_EQ(with.hits, without.hits);
      EXPECT_EQ(with.colors_looked_up, with.hits);
      EXPECT_EQ(with.normals_smoothed, with.hits);
      EXPECT_TRUE(equal_bytes(plain.depth, looked_up.depth) && equal_bytes(plain.cell, looked_up.cell));
      EXPECT_FALSE(equal_bytes(plain.normal, looked_up.normal));
      const Vec3 expected = color_of(render::ColorMap::cubehelix, 3.0 / 8);
      for (std::size_t pixel = 0; pixel < looked_up.pixel_count(); ++pixel) {
        if (looked_up.color[4 * pixel + 3] == 0) continue;
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(looked_up.color[4 * pixel + c], expected[static_cast<int>(c)], 2e-5);
      }
      options.threads = 3;
      render::render(dataset, scene, options, again);
      EXPECT_TRUE(same_bytes(looked_up, again));

      scene.layers[0].material.color_by = {};
      scene.layers[0].material.normals = {};
      const FrameStatistics after = render::render(dataset, scene, options, again);
      EXPECT_TRUE(same_bytes(plain, again));
      EXPECT_EQ(after.normals_smoothed + after.colors_looked_up, 0U);
    }
}

TEST(Render, refuses_colours_that_it_cannot_show) {
  TracedDataset mesh(box_mesh({}, blob()));
  Scene scene = scene_of(mesh.dataset(), Mode::isosurface);
  Framebuffer picture;
  const auto render_by = [&](const std::string& field, const Interval<double>& range) {
    scene.layers[0].material.color_by = {.field = field, .range = range};
    render::render(mesh.dataset(), scene, {.width = 4, .height = 4}, picture);
  };
  expect_error(ErrorCode::usage, "expected a finite range", [&] { render_by("value", {}); });
  expect_error(ErrorCode::usage, "no field 'colour'", [&] { render_by("colour", {0, 1}); });
  EXPECT_NO_THROW(render_by("value", {0, 0}));
}

TEST(Render, gives_the_same_picture_without_hierarchy_and_without_last_t) {
  const TracedDataset traced = TracedDataset(sampled_volume<float>({25, 22, 27}, {}, blob()));
  for (const Mode mode : {Mode::isosurface, Mode::mip})
    for (const Method& method : {Method{}, face_rule}) {
      // Along axes and diagonals, where rays pass several planes at once.
      for (const std::string_view view : {"iso", "+x", "-z"})
        for (const bool orthographic : {false, true}) {
          Scene scene = scene_of(traced.dataset(), mode, view);
          scene.layers[0].method = method;
          scene.camera.orthographic = orthographic;
          scene.camera.orthographic_height = 32;
          FrameOptions options{.width = 64, .height = 64, .channels = all_channels};
          Framebuffer reference, other;
          render::render(traced.dataset(), scene, options, reference);
          options.use_hierarchy = false;
          render::render(traced.dataset(), scene, options, other);
          EXPECT_TRUE(same_bytes(reference, other)) << "hierarchy, from " << view;
          options.use_hierarchy = true;
          options.use_last_t = false;
          render::render(traced.dataset(), scene, options, other);
          EXPECT_TRUE(same_bytes(reference, other)) << "last t, from " << view;
          options.time_phases = true;
          render::render(traced.dataset(), scene, options, other);
          EXPECT_TRUE(same_bytes(reference, other)) << "timed, from " << view;
        }
    }
}

TEST(Render, fills_the_channels_that_are_asked_for_and_no_others) {
  const TracedDataset traced(sampled_volume<double>({21, 21, 21}, {}, linear_field({1, 0, 0}, -7.25)));
  Scene scene = scene_of(traced.dataset(), Mode::isosurface, "-x");
  scene.background = {0.1, 0.2, 0.3};
  Framebuffer picture;
  render::render(traced.dataset(), scene, {.width = 40, .height = 30}, picture);
  EXPECT_EQ(picture.color.size(), 4U * 40 * 30);
  EXPECT_TRUE(picture.depth.empty() && picture.normal.empty() && picture.cell.empty() && picture.value.empty());
  render::render(traced.dataset(), scene, {.width = 40, .height = 30, .channels = all_channels}, picture);
  const std::size_t middle = 15 * 40 + 20, corner = 0;
  EXPECT_NEAR(picture.depth[middle], (7.25 - scene.camera.position.x), 0.1);
  EXPECT_EQ(picture.normal[3 * middle], -1) << "towards the eye, against the gradient";
  EXPECT_EQ(picture.value[middle], 0);
  EXPECT_EQ(picture.cell[middle] % 20, 7U);
  EXPECT_EQ(picture.color[4 * middle + 3], 1);
  EXPECT_TRUE(std::isinf(picture.depth[corner]));
  EXPECT_EQ(picture.normal[0], 0);
  EXPECT_TRUE(std::isnan(picture.value[corner]));
  EXPECT_EQ(picture.cell[corner], Framebuffer::no_cell);
  EXPECT_EQ(picture.color[0], 0.1F);
  EXPECT_EQ(picture.color[3], 0);
}

// A perspective and an orthographic camera both show a plane of known size where geometry predicts.
TEST(Render, shows_projections_in_the_colours_of_a_map) {
  TracedDataset grid(sampled_volume<float>({25, 22, 27}, {}, blob()));
  Scene scene = scene_of(grid.dataset(), Mode::mip);
  scene.background = {0, 0, 0};
  for (const auto& [name, map] : render::color_maps()) {
    scene.layers[0].map = map;
    Framebuffer picture;
    render::render(grid.dataset(), scene, {.width = 31, .height = 23, .channels = {.cell = true, .value = true}},
                   picture);
    std::size_t shown = 0;
    for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel) {
      if (picture.cell[pixel] == Framebuffer::no_cell) continue;
      const Vec3 expected = color_of(map, (picture.value[pixel] + 10) / 20);
      // ColorTable is within half a step of 8-bit sRGB, which is at most 0.005 of linear light.
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(picture.color[4 * pixel + c], expected[static_cast<int>(c)], 0.005) << name;
      ++shown;
    }
    EXPECT_GT(shown, 200U) << name;
  }
}

TEST(Render, shows_things_at_their_size_in_both_projections) {
  Affine map;
  map.origin = {-10, -10, -10};
  const TracedDataset traced(sampled_volume<double>({21, 21, 21}, map, [](const Vec3& p) { return 5 - p.length(); }));
  Scene scene = scene_of(traced.dataset(), Mode::isosurface);
  scene.camera = {.position = {0, -50, 0}, .target = {0, 0, 0}, .up = {0, 0, 1}};
  const int n = 200;
  const auto share_covered = [&] {
    Framebuffer picture;
    return static_cast<double>(render::render(traced.dataset(), scene, {.width = n, .height = n}, picture).hits) /
           (n * n);
  };
  scene.camera.orthographic = true;
  scene.camera.orthographic_height = 20;
  EXPECT_NEAR(share_covered(), std::numbers::pi * 25 / 400, 0.01);
  scene.camera.orthographic = false;
  scene.camera.vertical_fov_deg = 30;
  const double half = std::tan(15 * std::numbers::pi / 180), radius = std::tan(std::asin(5.0 / 50));
  EXPECT_NEAR(share_covered(), std::numbers::pi * radius * radius / (4 * half * half), 0.01);
}

TEST(Render, of_a_mirrored_volume_is_the_mirrored_picture) {
  // The same samples on an axis that points the other way.
  const Index3 count(24, 20, 22);
  const auto value = [](const Index3& at) {
    return static_cast<float>(
        blob()(Vec3(static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z))));
  };
  Affine centered;
  centered.origin = {-11.5, -9.5, -10.5};
  Affine mirrored = centered;
  mirrored.x_axis = -mirrored.x_axis;
  mirrored.origin.x = 11.5;
  const TracedDataset plain(volume_of<float>(count, value, centered)), mirror(volume_of<float>(count, value, mirrored));
  for (const Mode mode : {Mode::isosurface, Mode::mip}) {
    Scene scene = scene_of(plain.dataset(), mode, "-y");
    Framebuffer a, b;
    const FrameOptions options{.width = 61, .height = 47, .channels = all_channels};
    EXPECT_GT(render::render(plain.dataset(), scene, options, a).hits, 200U);
    render::render(mirror.dataset(), scene, options, b);
    int different = 0;
    for (std::size_t y = 0; y < 47; ++y)
      for (std::size_t x = 0; x < 61; ++x) {
        const std::size_t here = y * 61 + x, there = y * 61 + (60 - x);
        different += a.color[4 * here + 3] != b.color[4 * there + 3];
        if (a.color[4 * here + 3] == 0 || b.color[4 * there + 3] == 0) continue;
        EXPECT_NEAR(a.depth[here], b.depth[there], 1e-4);
        EXPECT_NEAR(a.color[4 * here], b.color[4 * there], 1e-4);
        EXPECT_NEAR(a.normal[3 * here], -b.normal[3 * there], 1e-4);
        EXPECT_NEAR(a.value[here], b.value[there], 1e-9);
      }
    EXPECT_EQ(different, 0);
  }
}

TEST(Render, says_for_which_machine_the_kernel_that_answered_is_compiled) {
  const TracedDataset grid(sampled_volume<float>({25, 22, 27}, {}, blob()));
  const TracedDataset mesh(box_mesh({.cells = {8, 7, 9}, .box = Box3({0, 0, 0}, {24, 21, 26})}, blob()));
  Framebuffer picture;
  const auto machine_of = [&](const TracedDataset& traced, const Method& method, bool use_hierarchy) {
    Scene scene = scene_of(traced.dataset(), Mode::isosurface);
    scene.layers[0].method = method;
    return render::render(traced.dataset(), scene, {.width = 20, .height = 20, .use_hierarchy = use_hierarchy}, picture)
        .machine;
  };
  const Method single = method_of(render::Accuracy::float32);
  EXPECT_EQ(machine_of(grid, single, true), name_of(render::chosen_machine()));
  EXPECT_EQ(machine_of(grid, single, false), "scalar") << "a wide kernel that leaves the question to the other";
  EXPECT_EQ(machine_of(grid, Method{}, true), "scalar");
  EXPECT_EQ(machine_of(mesh, single, true), name_of(render::chosen_machine()));
  EXPECT_EQ(machine_of(mesh, single, false), "scalar");
  EXPECT_EQ(machine_of(mesh, Method{}, true), "scalar");
}

TEST(Render, prepares_an_isovalue_of_a_mesh_once) {
  const TracedDataset mesh(box_mesh({.cells = {8, 7, 9}, .box = Box3({0, 0, 0}, {24, 21, 26})}, blob()));
  Scene scene = scene_of(mesh.dataset(), Mode::isosurface);
  scene.layers[0].method = method_of(render::Accuracy::float32);
  Framebuffer picture;
  const FrameStatistics first = render::render(mesh.dataset(), scene, {.width = 20, .height = 20}, picture);
  EXPECT_EQ(first.preparation_s > 0, render::chosen_machine() != render::Machine::scalar);
  EXPECT_LT(first.preparation_s, first.wall_s);
  const auto kept = mesh.dataset().implementation().facets;
  const auto& view = std::get<render::TetData>(mesh.dataset().implementation().view);
  const Box3& bounds = mesh.dataset().implementation().bounds_data;
  const auto facets = kept->of(view, bounds, scene.layers[0].isovalue, 1);
  render::render(mesh.dataset(), scene, {.width = 20, .height = 20}, picture);
  EXPECT_EQ(kept->of(view, bounds, scene.layers[0].isovalue, 1), facets);
  scene.layers[0].method = {};
  EXPECT_EQ(render::render(mesh.dataset(), scene, {.width = 20, .height = 20}, picture).preparation_s, 0);
}

TEST(Render, shades_no_highlight_that_the_scene_does_not_call_for) {
  const TracedDataset traced(sampled_volume<float>({25, 22, 27}, {}, blob()));
  Scene scene = scene_of(traced.dataset(), Mode::isosurface);
  Framebuffer picture;
  const FrameOptions options{.width = 50, .height = 50};
  const FrameStatistics glossy = render::render(traced.dataset(), scene, options, picture);
  EXPECT_GT(glossy.hits, 100U);
  EXPECT_EQ(glossy.highlights_shaded, glossy.hits);
  scene.layers[0].material.specular = 0;
  EXPECT_EQ(render::render(traced.dataset(), scene, options, picture).highlights_shaded, 0U);
  scene.layers[0].material.specular = 1;
  scene.layers[0].mode = Mode::mip;
  EXPECT_EQ(render::render(traced.dataset(), scene, options, picture).highlights_shaded, 0U);
}

TEST(Render, allocates_nothing_per_ray) {
  const TracedDataset grid(sampled_volume<float>({25, 22, 27}, {}, blob()));
  const TracedDataset mesh(box_mesh({.cells = {8, 7, 9}, .box = Box3({0, 0, 0}, {24, 21, 26})}, blob()));
  for (const TracedDataset* traced : {&grid, &mesh})
    for (const Mode mode : {Mode::isosurface, Mode::mip}) {
      Scene scene = scene_of(traced->dataset(), mode);
      const Box3 box = traced->dataset().bounds();
      scene.camera =
          render::fit_camera(box, {.target = box.center()}, 1);  // the only pixel of a picture shows the blob
      scene.lights.push_back({.kind = Light::Kind::directional, .place = {1, 2, 3}, .casts_shadows = true});
      scene.occlusion = {.samples = 2, .radius = 5};
      const auto allocations_of = [&](int edge) {
        Framebuffer picture;
        FrameOptions options{.width = edge, .height = edge, .channels = all_channels, .threads = 1};
        // The first frame also allocates the thread pool's own memory.
        render::render(traced->dataset(), scene, options, picture);
        const std::size_t before = allocation_count();
        render::render(traced->dataset(), scene, options, picture);
        return allocation_count() - before;
      };
      // One tile each: from one ray to a thousand.
      EXPECT_EQ(allocations_of(1), allocations_of(32));
      EXPECT_GT(allocations_of(1), 0U) << "the frame's own memory: is anything counted?";
      EXPECT_LE(allocations_of(160), allocations_of(1) + 25) << "at most what 25 tiles may need";
    }
}

TEST(Render, measures_the_phases_when_asked) {
  const TracedDataset traced(sampled_volume<float>({25, 22, 27}, {}, blob()));
  const Scene scene = scene_of(traced.dataset(), Mode::isosurface);
  Framebuffer picture;
  FrameOptions options{.width = 100, .height = 100, .threads = 1};
  const FrameStatistics untimed = render::render(traced.dataset(), scene, options, picture);
  EXPECT_EQ(untimed.phases.traversal, 0);
  EXPECT_EQ(untimed.phases.intersection, 0);
  options.time_phases = true;
  const FrameStatistics timed = render::render(traced.dataset(), scene, options, picture);
  EXPECT_GT(timed.phases.traversal, 0);
  EXPECT_GT(timed.phases.intersection, 0);
  EXPECT_GT(timed.phases.shading, 0);
  EXPECT_LE(timed.phases.traversal + timed.phases.intersection + timed.phases.shading, 1.01 * timed.wall_s);
}

TEST(Render, refuses_pictures_and_scenes_that_make_no_sense) {
  const TracedDataset traced(sampled_volume<float>({25, 22, 27}, {}, blob()));
  const Scene good = scene_of(traced.dataset(), Mode::isosurface), mip = scene_of(traced.dataset(), Mode::mip);
  const auto refused = [&](const Scene& scene, int width, int height) {
    Framebuffer picture;
    try {
      render::render(traced.dataset(), scene, {.width = width, .height = height}, picture);
      return false;
    } catch (const Error& error) {
      return error.code() == ErrorCode::usage;
    }
  };
  EXPECT_FALSE(refused(good, 4, 4));
  EXPECT_TRUE(refused(good, 0, 4));
  EXPECT_TRUE(refused(good, 4, -1));
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    Scene scene = good;
    scene.layers[0].isovalue = bad;
    EXPECT_TRUE(refused(scene, 4, 4));
    scene = mip;
    scene.layers[0].window.hi = bad;
    EXPECT_TRUE(refused(scene, 4, 4));
  }
  Scene scene = mip;
  scene.layers[0].window = {};
  EXPECT_TRUE(refused(scene, 4, 4));
  scene = good;
  scene.camera.target = scene.camera.position;
  EXPECT_TRUE(refused(scene, 4, 4));
}

}  // namespace
}  // namespace rhoray::tests

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/agreement/pictures.h"

/// Transparent surfaces in one pass along the rays, compared with the code path that traces every
/// crossing as a query of its own.
namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::FrameStatistics;
using render::Layer;
using render::Scene;

constexpr int edge = 96;

double waves(const Vec3& p) {
  return std::sin(5 * p.x + 1) + std::sin(4 * p.y) * std::cos(6 * p.z) + 0.2 * p.z;
}

double distance(const Vec3& p) {
  return 1 - p.length();
}

/// Thin sheets, far more on a ray than a list of crossings holds.
double sheets(const Vec3& p) {
  return std::sin(60 * (p.x + 0.1 * p.y * p.y)) * 100;
}

struct Shown {
  TemporaryFolder folder;
  std::vector<render::Dataset> datasets;

  Shown() {
    const Box3 box{{-1, -1, -1}, {1, 1, 1}};
    const Index3 few(27, 26, 25), many(97, 93, 91);
    datasets.push_back(packed(folder, "waves.rho", sampled_volume<float>(few, lattice_over(box, few), waves)));
    datasets.push_back(packed(folder, "distance.rho", sampled_volume<float>(many, lattice_over(box, many), distance)));
    datasets.push_back(
        packed(folder, "sheets.rho", sampled_volume<std::int16_t>(many, lattice_over(box, many), sheets)));
    preprocess::NeutralMesh mesh = box_mesh({.cells = {9, 9, 9}, .box = box, .jitter = 0.1});
    add_point_field(mesh, "value", waves);
    datasets.push_back(packed(folder, "mesh.rho", mesh));
  }
};

Layer surface(std::size_t dataset, double isovalue, const Vec3& color, double opacity) {
  Layer layer{.dataset = dataset, .isovalue = isovalue, .method = render::method_of(render::Accuracy::float32)};
  layer.material.color = color;
  layer.material.opacity = opacity;
  return layer;
}

Scene scene_of(const std::vector<Layer>& layers) {
  Scene scene;
  scene.layers = layers;
  scene.camera =
      render::fit_camera({{-1, -1, -1}, {1, 1, 1}}, {.azimuth_deg = 33, .elevation_deg = 21, .zoom = 1.1}, 1);
  scene.background = {0.9, 0.8, 0.7};
  return scene;
}

struct Picture {
  Framebuffer pixels;
  FrameStatistics statistics;
};

Picture picture_of(const std::vector<render::Dataset>& datasets, const Scene& scene, bool one_pass,
                   unsigned threads = 1) {
  Picture picture;
  picture.statistics = render::render(
      datasets, scene,
      {.width = edge, .height = edge, .channels = all_channels, .threads = threads, .one_pass = one_pass},
      picture.pixels);
  return picture;
}

/// When less light is left, tracing ends; but for several layers the reference also shows what it
/// has already found in the others. In a pixel with one crossing too many or too few before that,
/// the difference is a hundred times larger.
constexpr float least_light = 1.0F / 1024;

/// Expects first hits that are equal bit for bit, and colours that differ at most by the last
/// light. A few pixels may differ, in which a surface is grazed or two surfaces meet within the
/// rounding error of a crossing.
void expect_the_same(const Picture& found, const Picture& reference, std::size_t few) {
  EXPECT_EQ(found.pixels.depth, reference.pixels.depth);
  EXPECT_EQ(found.pixels.normal, reference.pixels.normal);
  EXPECT_EQ(found.pixels.cell, reference.pixels.cell);
  EXPECT_EQ(found.pixels.roots, reference.pixels.roots);
  EXPECT_EQ(found.pixels.iterations, reference.pixels.iterations);
  std::size_t different = 0;
  for (std::size_t p = 0; p < found.pixels.pixel_count(); ++p) {
    bool is_same = true;
    for (std::size_t c = 0; c < 4; ++c)
      is_same &= std::abs(found.pixels.color[4 * p + c] - reference.pixels.color[4 * p + c]) < least_light;
    different += !is_same;
  }
  EXPECT_LE(different, few);
  EXPECT_NEAR(static_cast<double>(found.statistics.clear_crossings),
              static_cast<double>(reference.statistics.clear_crossings),
              static_cast<double>(few) + 1e-2 * static_cast<double>(reference.statistics.clear_crossings));
  EXPECT_GT(found.statistics.clear_crossings, 2000U);
}

std::vector<std::vector<Layer>> scenes() {
  return {{surface(0, 0.4, {1, 0, 0}, 0.5)},
          {surface(0, 0.4, {1, 0, 0}, 0.5), surface(0, 0.55, {0, 1, 0}, 0.3)},
          {surface(1, 0.3, {1, 0, 0}, 0.5), surface(1, 0.3 + 0.001 / 48, {0, 1, 0}, 0.5)},
          {surface(1, 0.3, {1, 0, 0}, 0.5), surface(0, 0.7, {0, 1, 0}, 0.4), surface(1, 0.6, {0, 0, 1}, 0.2),
           surface(1, 0.5, {0, 1, 1}, 0.6)},
          {surface(1, 0.3, {1, 0, 0}, 0.5), surface(0, 0.7, {0, 1, 0}, 0.4), surface(1, 0.6, {0, 0, 1}, 0.2),
           surface(1, 0.5, {0, 1, 1}, 0.6), surface(0, 0.4, {1, 1, 0}, 0.1)},
          {surface(3, 0.4, {1, 0, 0}, 0.5), surface(3, 0.55, {0, 1, 0}, 0.3)},
          {surface(3, 0.4, {1, 0, 0}, 0.5), surface(0, 0.4, {0, 1, 0}, 0.5), surface(3, 0.4001, {0, 0, 1}, 0.5)},
          {surface(0, 0.4, {1, 0, 0}, 0.5), surface(1, 0.6, {0.2, 0.2, 0.2}, 1)}};
}

TEST(OnePass, shows_what_is_shown_crossing_by_crossing) {
  const Shown shown;
  for (const std::vector<Layer>& layers : scenes()) {
    SCOPED_TRACE(layers.size());
    const Scene scene = scene_of(layers);
    const Picture found = picture_of(shown.datasets, scene, true), reference = picture_of(shown.datasets, scene, false);
    expect_the_same(found, reference, edge * edge / 1000);
    EXPECT_LT(found.statistics.macrocells_visited, reference.statistics.macrocells_visited);
  }
}

// Lists of crossings keep entries of other rays, and of data with more cells. These were looked up.
TEST(OnePass, has_smooth_normals_whatever_its_memory_held_before) {
  const Shown shown;
  render::RenderContext memory;
  for (const std::size_t dataset : {1U, 0U, 3U, 0U}) {
    std::vector<Layer> layers{surface(dataset, 0.4, {1, 0, 0}, 0.5), surface(dataset, 0.55, {0, 1, 0}, 0.3)};
    for (Layer& layer : layers) layer.material.normals = render::Normals::smooth;
    const Scene scene = scene_of(layers);
    const Picture found = picture_of(shown.datasets, scene, true), reference = picture_of(shown.datasets, scene, false);
    expect_the_same(found, reference, edge * edge / 1000);
    Framebuffer kept;
    render::render(shown.datasets, scene, {.width = edge, .height = edge, .channels = all_channels, .threads = 1}, kept,
                   memory);
    EXPECT_EQ(kept.color, found.pixels.color);
  }
}

TEST(OnePass, goes_on_where_a_ray_crosses_more_than_a_list_holds) {
  const Shown shown;
  const Scene scene = scene_of({surface(2, 0, {1, 0, 0}, 0.1), surface(2, 12.3, {0, 1, 0}, 0.1)});
  const Picture found = picture_of(shown.datasets, scene, true), reference = picture_of(shown.datasets, scene, false);
  expect_the_same(found, reference, edge * edge / 100);
  EXPECT_GT(found.statistics.clear_crossings, 20U * found.statistics.hits) << "rays no longer cross that many";
}

TEST(OnePass, ends_where_the_light_does) {
  const Shown shown;
  const Scene dark = scene_of({surface(2, 0, {1, 0, 0}, 0.9)}), clear = scene_of({surface(2, 0, {1, 0, 0}, 0.5)});
  const Picture found = picture_of(shown.datasets, dark, true), more = picture_of(shown.datasets, clear, true);
  expect_the_same(found, picture_of(shown.datasets, dark, false), edge * edge / 1000);
  EXPECT_LT(2 * found.statistics.cells_solved, more.statistics.cells_solved);
  // 0.1^4 is less than 1/1024.
  EXPECT_LE(found.statistics.clear_crossings, 4 * found.statistics.hits);
}

/// When only colours are needed, cells, roots and iterations are not written.
TEST(OnePass, shows_the_same_where_no_channels_are_asked_for) {
  const Shown shown;
  for (const std::vector<Layer>& layers : scenes()) {
    const Scene scene = scene_of(layers);
    const Picture with_channels = picture_of(shown.datasets, scene, true);
    Framebuffer colors;
    const FrameStatistics statistics =
        render::render(shown.datasets, scene, {.width = edge, .height = edge, .threads = 1}, colors);
    EXPECT_EQ(colors.color, with_channels.pixels.color);
    EXPECT_EQ(statistics.clear_crossings, with_channels.statistics.clear_crossings);
    EXPECT_TRUE(colors.cell.empty());
  }
}

TEST(OnePass, is_cut_by_a_clip_region) {
  const Shown shown;
  Scene scene = scene_of({surface(0, 0.4, {1, 0, 0}, 0.5), surface(0, 0.55, {0, 1, 0}, 0.3)});
  for (const bool cuts_away : {false, true}) {
    scene.clip = render::Clip{.box = Box3{{-0.5, -0.6, -0.7}, {0.6, 0.5, 0.4}}};
    scene.clip->cuts_away = cuts_away;
    expect_the_same(picture_of(shown.datasets, scene, true), picture_of(shown.datasets, scene, false),
                    edge * edge / 500);
  }
}

TEST(OnePass, gives_the_same_picture_for_any_threads_and_order_of_layers) {
  const Shown shown;
  for (std::vector<Layer> layers : scenes()) {
    const Picture one = picture_of(shown.datasets, scene_of(layers), true);
    std::reverse(layers.begin(), layers.end());
    const Picture three = picture_of(shown.datasets, scene_of(layers), true, 3);
    EXPECT_EQ(one.pixels.color, three.pixels.color);
    EXPECT_EQ(one.statistics.clear_crossings, three.statistics.clear_crossings);
  }
}

}  // namespace
}  // namespace rhoray::tests

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "render/render.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/equal_bytes.h"
#include "tests/support/expect_error.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::ChannelSet;
using render::Framebuffer;
using render::FrameOptions;
using render::FrameStatistics;
using render::Mode;
using render::RenderContext;
using render::Scene;

constexpr ChannelSet all_channels{
    .depth = true, .normal = true, .cell = true, .value = true, .roots = true, .iterations = true};

bool same_bytes(const Framebuffer& a, const Framebuffer& b) {
  return equal_bytes(a.color, b.color) && equal_bytes(a.depth, b.depth) && equal_bytes(a.normal, b.normal) &&
         equal_bytes(a.cell, b.cell) && equal_bytes(a.value, b.value) && equal_bytes(a.roots, b.roots) &&
         equal_bytes(a.iterations, b.iterations);
}

Field blob() {
  return [](const Vec3& p) { return 7 - (p - Vec3(12, 10, 13)).length() + std::sin(p.x) * std::cos(1.3 * p.y); };
}

Scene scene_of(const render::Dataset& dataset, Mode mode, double aspect) {
  Scene scene;
  scene.layers[0].mode = mode;
  scene.camera = fit_camera(dataset.bounds(), render::named_view("iso"), aspect);
  scene.layers[0].window = {.lo = -10, .hi = 10};
  return scene;
}

TEST(Refine, ends_with_the_plain_frame_bit_for_bit) {
  const TracedDataset grid(sampled_volume<float>({25, 22, 27}, {}, blob()));
  const TracedDataset mesh(box_mesh({.cells = {8, 7, 9}, .box = Box3({0, 0, 0}, {24, 21, 26})}, blob()));
  for (const TracedDataset* traced : {&grid, &mesh})
    for (const Mode mode : {Mode::isosurface, Mode::mip})
      for (const auto& [width, height] : {std::pair(1, 1), {2, 9}, {131, 70}})
        for (const int spacing : {1, 2, 8})
          for (const unsigned threads : {1U, 3U}) {
            const Scene scene = scene_of(traced->dataset(), mode, static_cast<double>(width) / height);
            const FrameOptions options{.width = width, .height = height, .channels = all_channels, .threads = threads};
            Framebuffer plain, refined;
            const FrameStatistics once = render::render(traced->dataset(), scene, options, plain);
            RenderContext memory;
            std::vector<int> spacings;
            const FrameStatistics all = render::refine(traced->dataset(), scene, options,
                                                       {.first_spacing = spacing,
                                                        .pass_done =
                                                            [&](int done) {
                                                              spacings.push_back(done);
                                                              return true;
                                                            }},
                                                       refined, memory);
            EXPECT_TRUE(same_bytes(plain, refined)) << width << " x " << height << " from " << spacing;
            EXPECT_EQ(all.rays, once.rays);
            EXPECT_EQ(all.hits, once.hits);
            EXPECT_EQ(all.highlights_shaded, once.highlights_shaded);
            std::vector<int> expected{spacing};
            while (expected.back() > 1) expected.push_back(expected.back() / 2);
            EXPECT_EQ(spacings, expected);
          }
}

// After a pass, each pixel shows what the plain frame shows at the traced pixel to its left and
// above.
TEST(Refine, shows_real_rays_at_every_pass) {
  const TracedDataset traced(sampled_volume<float>({25, 22, 27}, {}, blob()));
  constexpr int width = 117, height = 75;
  const Scene scene = scene_of(traced.dataset(), Mode::isosurface, static_cast<double>(width) / height);
  const FrameOptions options{.width = width, .height = height, .channels = {.depth = true, .cell = true}};
  Framebuffer plain, shown;
  render::render(traced.dataset(), scene, options, plain);
  RenderContext memory;
  int passes = 0;
  const auto check = [&](int spacing) {
    ++passes;
    int wrong = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const auto here = static_cast<std::size_t>(y * width + x);
        const auto there = static_cast<std::size_t>((y - y % spacing) * width + x - x % spacing);
        wrong += shown.depth[here] != plain.depth[there] || shown.cell[here] != plain.cell[there] ||
                 std::memcmp(&shown.color[4 * here], &plain.color[4 * there], 4 * sizeof(float)) != 0;
      }
    EXPECT_EQ(wrong, 0) << "at a spacing of " << spacing;
    return true;
  };
  render::refine(traced.dataset(), scene, options, {.first_spacing = 4, .pass_done = check}, shown, memory);
  EXPECT_EQ(passes, 3);
}

TEST(Refine, ends_when_it_is_told_to) {
  const TracedDataset traced(sampled_volume<float>({25, 22, 27}, {}, blob()));
  const Scene scene = scene_of(traced.dataset(), Mode::isosurface, 1);
  const FrameOptions options{.width = 256, .height = 256, .threads = 2};
  Framebuffer picture;
  RenderContext memory;
  const FrameStatistics quarter = render::refine(
      traced.dataset(), scene, options, {.first_spacing = 2, .pass_done = [](int) { return false; }}, picture, memory);
  EXPECT_EQ(quarter.rays, 128U * 128U);

  std::stop_source source;
  const auto stop_in_second_pass = [&](int) {
    source.request_stop();
    return true;
  };
  const FrameStatistics stopped = render::refine(
      traced.dataset(), scene, options,
      {.first_spacing = 2, .pass_done = stop_in_second_pass, .watch = source.get_token()}, picture, memory);
  EXPECT_EQ(stopped.rays, 128U * 128U);
  const FrameStatistics nothing = render::refine(traced.dataset(), scene, options,
                                                 {.first_spacing = 2, .watch = source.get_token()}, picture, memory);
  EXPECT_EQ(nothing.rays, 0U);
  EXPECT_EQ(nothing.hits, 0U);
}

TEST(Refine, refuses_spacings_that_do_not_halve) {
  const TracedDataset traced(sampled_volume<float>({9, 9, 9}, {}, blob()));
  RenderContext memory;
  for (const int spacing : {0, -1, 3, 32})
    expect_error(ErrorCode::usage, "expected 1, 2, 4, 8 or 16", [&] {
      Framebuffer picture;
      render::refine(traced.dataset(), scene_of(traced.dataset(), Mode::isosurface, 1), {.width = 8, .height = 8},
                     {.first_spacing = spacing}, picture, memory);
    });
}

TEST(RenderContext, changes_no_picture_and_no_count) {
  const TracedDataset grid(sampled_volume<float>({25, 22, 27}, {}, blob()));
  const TracedDataset mesh(box_mesh({.cells = {8, 7, 9}, .box = Box3({0, 0, 0}, {24, 21, 26})}, blob()));
  RenderContext memory;
  Framebuffer kept;
  for (const unsigned threads : {1U, 4U, 2U})
    for (const int edge : {64, 45})
      for (const TracedDataset* traced : {&grid, &mesh})
        for (const Mode mode : {Mode::isosurface, Mode::mip})
          for (const ChannelSet& channels : {all_channels, ChannelSet{}}) {
            Scene scene = scene_of(traced->dataset(), mode, 1);
            // Wide kernels use single precision; each frame has another isovalue.
            if (edge == 45) scene.layers[0].method = method_of(render::Accuracy::float32);
            scene.layers[0].isovalue = 0.1 * threads;
            const FrameOptions options{.width = edge, .height = edge, .channels = channels, .threads = threads};
            Framebuffer fresh;
            const FrameStatistics first = render::render(traced->dataset(), scene, options, fresh);
            const FrameStatistics again = render::render(traced->dataset(), scene, options, kept, memory);
            EXPECT_TRUE(same_bytes(fresh, kept));
            EXPECT_EQ(again.rays, first.rays);
            EXPECT_EQ(again.hits, first.hits);
            EXPECT_EQ(again.cells_visited, first.cells_visited);
            EXPECT_EQ(again.highlights_shaded, first.highlights_shaded);
          }
}

}  // namespace
}  // namespace rhoray::tests

// Memory that datasets and contexts keep between calls, and freeing it.
#include <gtest/gtest.h>

#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"

namespace rhoray::tests {
namespace {

constexpr Size size{96, 72};

using Shown = decltype(Layer::show);

/// Everything that is prepared: occluders of a lamp with shadows, smooth normals.
Scene shaded(const Dataset& data, const Shown& show, const std::string& field = {}) {
  Scene scene{.layers = {{.data = data, .show = show, .field = field, .material = {.normals = Normals::smooth}}},
              .lights = {{.kind = Light::Kind::directional, .place = {1, -2, 3}, .casts_shadows = true}}};
  scene.camera = fit_camera(scene, size);
  return scene;
}

TEST(PreparedData, are_counted_freed_and_prepared_again_with_the_same_bits) {
  const Dataset mesh = ball_mesh(8);
  for (const auto& [data, show] : std::vector<std::pair<Dataset, Shown>>{
           {mesh, Isosurface{0.5}}, {gyroid_grid(), Isosurface{0.1}}, {mesh.boundary(), Triangles{}}}) {
    const Scene scene = shaded(data, show);
    data.drop_prepared();
    EXPECT_EQ(data.prepared_bytes(), 0U);
    RenderContext context;
    Picture before, after;
    context.render(scene, {.size = size, .channels = {.depth = true}}, before);
    EXPECT_GT(data.prepared_bytes(), 0U);
    for (const bool drops_first : {true, false}) {
      if (drops_first) data.drop_prepared();
      context.trim();
      data.drop_prepared();
      EXPECT_EQ(data.prepared_bytes(), 0U);
      context.render(scene, {.size = size, .channels = {.depth = true}}, after);
      EXPECT_TRUE(bits_of(before) == bits_of(after));
    }
    data.drop_prepared();
    context.trim();
    EXPECT_EQ(data.prepared_bytes(), 0U) << "what the context kept goes back to nobody";
  }
}

TEST(PreparedData, are_those_of_all_fields_and_of_the_last_isovalues) {
  const Dataset mesh = ball_mesh(8);
  mesh.drop_prepared();
  RenderContext context;
  Picture picture;
  std::uint64_t before = 0;
  for (const double isovalue : {0.5, 0.6, 0.7, 0.8}) {
    context.render(shaded(mesh, Isosurface{isovalue}), {.size = size}, picture);
    EXPECT_GT(mesh.prepared_bytes(), before);
    before = mesh.prepared_bytes();
  }
  for (int k = 0; k < 20; ++k) context.render(shaded(mesh, Isosurface{0.5 + 0.01 * k}), {.size = size}, picture);
  EXPECT_LT(mesh.prepared_bytes(), 3 * before) << "only the last ones are kept";
  mesh.drop_prepared();
  context.render(shaded(mesh, Isosurface{0.1}, "x"), {.size = size}, picture);
  EXPECT_GT(mesh.prepared_bytes(), 0U);
  mesh.drop_prepared();
  EXPECT_EQ(mesh.prepared_bytes(), 0U);
}

TEST(PreparedData, may_be_freed_while_they_are_used) {
  const Dataset mesh = ball_mesh(8);
  const Scene scene = shaded(mesh, Isosurface{0.5});
  const std::string expected = bits_of(rendered(scene, {.size = size}));
  const std::jthread other([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) mesh.drop_prepared();
  });
  RenderContext context;
  Picture picture;
  for (int time = 0; time < 10; ++time) {
    context.render(scene, {.size = size}, picture);
    EXPECT_TRUE(bits_of(picture) == expected);
  }
}

TEST(TrimmedContext, draws_windows_again_and_is_not_trimmed_during_a_call) {
  const Scene scene = certified_scene(gyroid_grid(), 0.1, size);
  const RenderOptions options{.size = size, .window = Rect{32, 32, 32, 32}};
  const std::string expected = bits_of(rendered(scene, options));
  RenderContext context;
  Picture picture;
  for (int time = 0; time < 3; ++time) {
    context.trim();
    context.render(scene, options, picture);
    EXPECT_TRUE(bits_of(picture) == expected);
  }
  bool was_called = false;
  context.refine(scene, {.size = size},
                 {.pass_done =
                      [&](int) {
                        expect_refused(ErrorCode::usage, "during another call", [&] { context.trim(); });
                        return was_called = true;
                      }},
                 picture);
  EXPECT_TRUE(was_called);
}

}  // namespace
}  // namespace rhoray::tests

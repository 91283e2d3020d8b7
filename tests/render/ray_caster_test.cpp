#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stop_token>
#include <variant>

#include "render/grid/occupancy.h"
#include "render/ray_caster.h"
#include "render/render.h"
#include "render/triangles/facets.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/expect_error.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

TEST(RayCaster, answers_the_rays_of_a_camera_as_render_does) {
  const Affine turned{{0, 2, 0}, {-1, 0, 0}, {0, 0, 3}, {10, 20, 30}};
  const TracedDataset grid(sampled_volume<float>({9, 8, 7}, turned, distance_field({7, 28, 38})));
  const TracedDataset mesh(box_mesh({.cells = {3, 3, 3}}, distance_field({0.5, 0.5, 0.5})));
  for (const auto& [dataset, isovalue] : {std::pair{&grid.dataset(), 6.0}, {&mesh.dataset(), 0.4}}) {
    render::Scene scene;
    scene.layers[0].isovalue = isovalue;
    scene.camera = render::fit_camera(dataset->bounds(), render::named_view("iso"), 1.5);
    const render::FrameOptions options{.width = 60, .height = 40, .channels = {.depth = true, .cell = true}};
    render::Framebuffer picture;
    render::render(*dataset, scene, options, picture);

    const auto rays = render::camera_rays(*dataset, scene.camera, 60, 40);
    ASSERT_EQ(rays.size(), picture.pixel_count());
    const std::vector<std::uint32_t> pixels{2399, 0, 61};
    const auto some = render::camera_rays(*dataset, scene.camera, 60, 40, pixels);
    ASSERT_EQ(some.size(), pixels.size());
    for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(some[i].direction, rays[pixels[i]].direction);
    std::uint64_t visits = 0;
    for (const unsigned threads : {1U, 3U}) {
      std::vector<render::Hit> hits(rays.size());
      render::RayCaster queries(*dataset, isovalue, {}, threads);
      queries.first_crossings(rays, hits);
      EXPECT_TRUE(visits == 0 || visits == queries.counters().visits());
      visits = queries.counters().visits();
      std::size_t hit_count = 0;
      for (std::size_t r = 0; r < rays.size(); ++r) {
        EXPECT_EQ(static_cast<float>(hits[r].t), picture.depth[r]);
        EXPECT_EQ(hits[r].is_miss() ? render::Framebuffer::no_cell : hits[r].cell, picture.cell[r]);
        hit_count += !hits[r].is_miss();
      }
      EXPECT_GT(hit_count, 100U);
    }
  }
  EXPECT_EQ(render::world_from_ray_frame(grid.dataset()), turned);
}

TEST(RayCaster, prepares_what_first_crossings_need_until_it_is_stopped) {
  const TracedDataset grid(sampled_volume<float>({9, 8, 7}, {}, distance_field({4, 4, 3})));
  const TracedDataset mesh(box_mesh({.cells = {3, 3, 3}}, distance_field({0.5, 0.5, 0.5})));
  std::stop_source stop;
  stop.request_stop();
  const std::stop_token stopped = stop.get_token();
  // Only what is kept can be had with a token that was stopped.
  const auto blocks_of_grid = [&] {
    const render::LoadedDataset& loaded = grid.dataset().implementation();
    return loaded.occupancies->of(std::get<render::UniformGrid>(loaded.view).ranges(), 2.5, stopped);
  };
  const auto facets_of_mesh = [&] {
    const render::LoadedDataset& loaded = mesh.dataset().implementation();
    return loaded.facets->of(std::get<render::TetData>(loaded.view), loaded.bounds_data, 0.4, 1, stopped);
  };
  const render::RayCaster in_grid(grid.dataset(), 2.5, render::method_of(render::Accuracy::float32));
  const render::RayCaster in_mesh(mesh.dataset(), 0.4, render::method_of(render::Accuracy::float32));
  for (const render::RayCaster* caster : {&in_grid, &in_mesh}) {
    expect_error(ErrorCode::interrupted, "interrupted",
                 [&] { caster->prepare_first_crossings(render::Machine::baseline, 1, stopped); });
    caster->prepare_first_crossings(render::Machine::scalar, 1, {});  // needs nothing
  }
  expect_error(ErrorCode::interrupted, "interrupted", blocks_of_grid);
  expect_error(ErrorCode::interrupted, "interrupted", facets_of_mesh);
  for (const render::RayCaster* caster : {&in_grid, &in_mesh})
    caster->prepare_first_crossings(render::Machine::baseline, 2, {});
  EXPECT_NE(blocks_of_grid(), nullptr);
  EXPECT_NE(facets_of_mesh(), nullptr);
}

TEST(RayCaster, takes_rays_in_the_frame_of_the_samples_and_of_any_length) {
  const Affine turned{{0, 2, 0}, {-1, 0, 0}, {0, 0, 3}, {10, 20, 30}};
  const TracedDataset grid(volume_of<float>(
      {5, 5, 5}, [](const Index3& at) { return static_cast<float>(at.x); }, turned));
  const std::vector<render::Ray> rays{{{-1, 2, 2}, {2, 0, 0}}, {{-1, 2, 2}, {-1, 0, 0}}};
  std::vector<render::Hit> hits(2);
  render::RayCaster(grid.dataset(), 2.5, {}).first_crossings(rays, hits);
  EXPECT_DOUBLE_EQ(hits[0].t, 1.75);
  EXPECT_DOUBLE_EQ(hits[0].gradient.x, 1);
  EXPECT_TRUE(hits[1].is_miss());
}

TEST(RayCaster, refuses_an_isovalue_that_is_not_finite) {
  const TracedDataset grid(volume_of<float>({2, 2, 2}, [](const Index3& at) { return static_cast<float>(at.x); }));
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double isovalue : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity})
    expect_error(ErrorCode::usage, "isovalue", [&] { render::RayCaster(grid.dataset(), isovalue, {}); });
}

}  // namespace
}  // namespace rhoray::tests

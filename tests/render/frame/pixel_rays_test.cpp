#include "render/frame/pixel_rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace rhoray::tests {
namespace {

using render::Camera;
using render::CameraRays;
using render::Machine;
using render::PixelLattice;
using render::PixelRays;
using render::RayBatch;
using render::Tile;

const Affine world_from_data{{0.7, 0.1, 0}, {-0.2, 1.3, 0.4}, {0.3, 0, -2.1}, {12, -7, 3.3}};

/// Computes the camera's geometry one ray at a time, with the order of operations that determines
/// the bits.
render::Ray by_formula(const Camera& camera, int width, int height, int x, int y) {
  const Vec3 forward = (camera.target - camera.position).normalized();
  const Vec3 right = forward.cross(camera.up).normalized();
  const double half_height =
      camera.orthographic ? camera.orthographic_height / 2 : std::tan(camera.vertical_fov_deg * std::numbers::pi / 360);
  const Vec3 across = right * (half_height * width / height), down = forward.cross(right) * half_height;
  const Vec3 offset = ((2 * x + 1.0) / width - 1) * across + ((2 * y + 1.0) / height - 1) * down;
  const Vec3 origin = camera.orthographic ? camera.position + offset : camera.position;
  const Vec3 direction = camera.orthographic ? forward : (forward + offset).normalized();
  const Affine data_from_world = world_from_data.inverse();
  return {.origin = data_from_world.point(origin), .direction = data_from_world.vector(direction)};
}

TEST(PixelRays, are_the_cameras_rays_to_the_last_bit_on_every_machine) {
  for (const Machine machine : {Machine::scalar, Machine::baseline, Machine::avx2, Machine::avx512}) {
    if (!has_machine(machine)) continue;
    for (const bool orthographic : {false, true})
      for (const PixelLattice& lattice :
           {PixelLattice{.width = 83, .height = 61},
            PixelLattice{.x_first = 1, .y_first = 2, .spacing = 4, .width = 301, .height = 222}}) {
        const Camera camera{
            .position = {3, -40.5, 9}, .target = {0.3, 1, 2}, .orthographic = orthographic, .orthographic_height = 55};
        const CameraRays single(camera, lattice.width, lattice.height);
        const PixelRays wide(single, world_from_data.inverse(), lattice, machine);
        RayBatch batch(render::tile_capacity);
        wide.begin(batch);
        std::size_t count = 0;
        for (const Tile& tile : render::tiles_in_order(lattice.columns(), lattice.rows())) {
          wide.fill(tile, batch);
          ASSERT_EQ(batch.count, tile.count());
          for_each_run(tile, [&](const render::Run& run) {
            for (int i = 0; i < run.count; ++i, ++count) {
              const int x = lattice.x_first + (run.x + i) * lattice.spacing;
              const int y = lattice.y_first + run.y * lattice.spacing;
              const render::Ray expected = by_formula(camera, lattice.width, lattice.height, x, y);
              const render::Ray got = batch[run.first + static_cast<std::size_t>(i)];
              ASSERT_EQ(got.origin, expected.origin) << name_of(machine) << ": " << x << ", " << y;
              ASSERT_EQ(got.direction, expected.direction) << name_of(machine) << ": " << x << ", " << y;
              ASSERT_EQ(got.direction, world_from_data.inverse().vector(single.through_pixel(x, y).direction));
              ASSERT_EQ(got.t_min, 0);
              ASSERT_EQ(got.t_max, std::numeric_limits<double>::infinity());
            }
          });
        }
        EXPECT_EQ(count, static_cast<std::size_t>(lattice.columns()) * static_cast<std::size_t>(lattice.rows()));
      }
  }
}

}  // namespace
}  // namespace rhoray::tests

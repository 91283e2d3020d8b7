#include "render/frame/pixels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::Machine;
using render::Scene;
using render::Tile;

constexpr double infinity = std::numeric_limits<double>::infinity();
const Affine world_from_data{{0.7, 0.1, 0}, {-0.2, 1.3, 0.4}, {0.3, 0, -2.1}, {12, -7, 3.3}};

/// Synthetic rays and hits for one tile: every second one a hit, some without a gradient.
std::unique_ptr<render::LayerWork> made_up_hits(const Tile& tile) {
  auto worker = std::make_unique<render::LayerWork>();
  Dice dice(20261121);
  worker->rays.count = tile.count();
  for (std::size_t r = 0; r < tile.count(); ++r) {
    worker->rays.set(r, {.origin = {0, 0, 0}, .direction = world_from_data.inverse().vector(dice.direction())});
    render::Hit hit;
    if (dice.coin()) {
      hit.t = dice.between(1, 100), hit.value = dice.between(-1, 2), hit.cell = static_cast<std::uint64_t>(r);
      if (dice.below(8) != 0) hit.gradient = dice.direction() * dice.between(1e-9, 1e9);
    } else {
      // For a miss a kernel need not write any other member.
      hit.gradient = Vec3(std::nan(""), infinity, 1);
    }
    worker->hits.set(r, hit);
  }
  return worker;
}

Framebuffer picture_of(const Scene& scene, const Tile& tile, Machine machine, const render::ChannelSet& channels) {
  const auto work = made_up_hits(tile);
  const render::LayerShading shading{.layer = scene.layers[0],
                                     .effects = effects_called_for(scene, scene.layers[0]),
                                     .facing = render::Facing(world_from_data),
                                     .lights = lights_of(scene, world_from_data),
                                     .fog = scene.fog,
                                     .proves = false,
                                     .machine = machine};
  const auto colors = std::make_unique<render::TileColors>();
  render::WorkerCounts counts;
  fill_background(scene.background, work->rays.count, *colors);
  shade_hits(shading, *work, {}, counts, *colors);
  Framebuffer picture(tile.x_end, tile.y_end, channels);
  const render::PixelLattice lattice{.width = tile.x_end, .height = tile.y_end};
  write_colors(lattice, tile, *colors, picture);
  std::vector<Vec3> normals;
  for (std::size_t r = 0; r < work->rays.count; ++r)
    normals.push_back(shading.facing.normal(work->hits[r].gradient, work->rays[r].direction));
  write_channels(lattice, tile, work->hits, normals.data(), picture);
  return picture;
}

// Operations that round exactly and are not fused are the same everywhere.
TEST(Pixels, have_the_same_bits_on_every_machine) {
  struct Shown {
    render::Mode mode;
    bool has_lights = false;
    double shininess = 40;
  };
  for (const auto& [mode, has_lights, shininess] : {Shown{render::Mode::isosurface},
                                                    {render::Mode::isosurface, false, 39.5},
                                                    {render::Mode::isosurface, true},
                                                    {render::Mode::isosurface, true, 39.5},
                                                    {render::Mode::mip}})
    for (const Tile tile : {Tile{0, 32, 0, 32}, Tile{0, 29, 0, 13}}) {
      Scene scene;
      scene.layers[0].mode = mode;
      scene.layers[0].window = {0, 1};
      scene.layers[0].material.shininess = shininess;
      if (has_lights) {
        scene.lights = {{},
                        {.kind = render::Light::Kind::directional, .place = {1, -2, 3}, .color = {1, 0.5, 0.2}},
                        {.kind = render::Light::Kind::point, .place = {10, -2, 13}}};
        scene.fog = render::Fog{.color = {0, 0, 1}, .range = {.lo = 0, .hi = 60}};
      }
      const Framebuffer scalar = picture_of(scene, tile, Machine::scalar, {.normal = true});
      for (const Machine machine : {Machine::baseline, Machine::avx2, Machine::avx512}) {
        if (!has_machine(machine)) continue;
        const Framebuffer wide = picture_of(scene, tile, machine, {.normal = true});
        EXPECT_EQ(std::memcmp(wide.color.data(), scalar.color.data(), scalar.color.size() * sizeof(float)), 0)
            << name_of(machine);
        EXPECT_EQ(std::memcmp(wide.normal.data(), scalar.normal.data(), scalar.normal.size() * sizeof(float)), 0)
            << name_of(machine);
      }
    }
}

TEST(Pixels, are_the_formulas_in_double_within_a_quarter_step_of_16_bit_colour) {
  Scene scene;
  scene.background = {0.25, 0.5, 0.75};
  const Tile tile{0, 29, 0, 27};
  const Framebuffer picture = picture_of(scene, tile, render::chosen_machine(), {.depth = true, .cell = true});
  const auto worker = made_up_hits(tile);
  int hits = 0, without_gradient = 0;
  render::for_each_run(tile, [&](const render::Run& run) {
    for (int i = 0; i < run.count; ++i) {
      const std::size_t r = run.first + static_cast<std::size_t>(i);
      const std::size_t pixel = static_cast<std::size_t>(run.y * 29 + run.x + i);
      const render::Hit hit = worker->hits[r];
      Vec3 color = scene.background;
      if (!hit.is_miss()) {
        const bool has_gradient = hit.gradient != Vec3(0, 0, 0);
        const Vec3 normal = world_from_data.gradient(hit.gradient).normalized();
        const double cosine =
            has_gradient ? std::abs(normal.dot(world_from_data.vector(worker->rays[r].direction))) : 1;
        const render::Material& surface = scene.layers[0].material;
        const double highlight = surface.specular * std::pow(cosine, surface.shininess);
        color =
            (surface.ambient + (1 - surface.ambient) * cosine) * surface.color + Vec3(highlight, highlight, highlight);
        ++hits, without_gradient += !has_gradient;
      }
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(picture.color[4 * pixel + static_cast<std::size_t>(c)], color[c], 4e-6);
      ASSERT_EQ(picture.color[4 * pixel + 3], hit.is_miss() ? 0 : 1);
      ASSERT_EQ(picture.depth[pixel], static_cast<float>(hit.t));
      ASSERT_EQ(picture.cell[pixel], hit.is_miss() ? Framebuffer::no_cell : hit.cell);
    }
  });
  EXPECT_GT(hits, 300);
  EXPECT_GT(without_gradient, 20);
}

}  // namespace
}  // namespace rhoray::tests

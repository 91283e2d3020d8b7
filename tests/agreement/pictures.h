#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string_view>

#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "render/render.h"
#include "tests/support/equal_bytes.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

constexpr render::ChannelSet all_channels{.depth = true, .normal = true, .cell = true, .value = true};

inline render::Dataset packed(const TemporaryFolder& folder, std::string_view name,
                              const preprocess::NeutralVolume& volume,
                              const preprocess::PackVolumeOptions& options = {}) {
  preprocess::pack_volume(volume, folder / name, options);
  return render::Dataset::load(folder / name);
}

inline render::Dataset packed(const TemporaryFolder& folder, std::string_view name, const preprocess::NeutralMesh& mesh,
                              const preprocess::PackMeshOptions& options = {}) {
  preprocess::pack_mesh(mesh, folder / name, options);
  return render::Dataset::load(folder / name);
}

/// A scene of the whole volume, seen from a direction that is parallel to nothing in it.
inline render::Scene oblique_scene(const render::Dataset& volume, double isovalue, bool orthographic = false) {
  render::Scene scene;
  scene.layers[0].isovalue = isovalue;
  scene.layers[0].window = volume.field().range;
  scene.camera = render::fit_camera(
      volume.bounds(), {.azimuth_deg = 33, .elevation_deg = 21, .zoom = 1.1, .orthographic = orthographic}, 1);
  return scene;
}

/// The same scene, seen straight along y. Rays run in faces and along edges of the lattice where
/// the size of the picture makes them do so.
inline render::Scene straight_scene(const render::Dataset& volume, double isovalue) {
  render::Scene scene = oblique_scene(volume, isovalue);
  scene.camera = render::fit_camera(volume.bounds(), {.azimuth_deg = 0, .elevation_deg = 0, .orthographic = true}, 1);
  return scene;
}

inline render::Framebuffer picture(const render::Dataset& volume, const render::Scene& scene,
                                   render::FrameOptions options = {}) {
  if (options.width == render::FrameOptions{}.width) options.width = options.height = 96;
  options.channels = all_channels;
  render::Framebuffer framebuffer;
  render::render(volume, scene, options, framebuffer);
  return framebuffer;
}

inline std::size_t hit_count(const render::Framebuffer& framebuffer) {
  return static_cast<std::size_t>(std::count_if(framebuffer.cell.begin(), framebuffer.cell.end(),
                                                [](std::uint64_t id) { return id != render::Framebuffer::no_cell; }));
}

inline void expect_same_bits(const render::Framebuffer& a, const render::Framebuffer& b) {
  EXPECT_TRUE(equal_bytes(a.color, b.color));
  EXPECT_TRUE(equal_bytes(a.depth, b.depth));
  EXPECT_TRUE(equal_bytes(a.normal, b.normal));
  EXPECT_TRUE(equal_bytes(a.cell, b.cell));
  EXPECT_TRUE(equal_bytes(a.value, b.value));
}

/// Small whole numbers without order: every cell is crossed, and many values equal a whole-numbered
/// isovalue.
template <class T>
preprocess::NeutralVolume noise_volume(const Index3& count, int largest, std::uint64_t seed,
                                       const Affine& world_from_grid = {}) {
  std::mt19937_64 random(seed);
  return volume_of<T>(
      count, [&](const Index3&) { return static_cast<T>(random() % static_cast<std::uint64_t>(largest + 1)); },
      world_from_grid);
}

}  // namespace rhoray::tests

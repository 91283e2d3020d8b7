#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "render/frame/camera_rays.h"
#include "tests/agreement/pictures.h"
#include "tests/support/meshes.h"

/// Scenes with lights, and helpers to read their pictures.
namespace rhoray::tests::lit {

using render::Framebuffer;
using render::Layer;
using render::Light;
using render::Scene;

inline constexpr int edge = 96;
inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline const Box3 cube{{-1, -1, -1}, {1, 1, 1}};

inline Light sun(const Vec3& towards, const Vec3& color = {1, 1, 1}) {
  return {.kind = Light::Kind::directional, .place = towards, .color = color, .casts_shadows = true};
}

inline Light lamp(const Vec3& place) {
  return {.kind = Light::Kind::point, .place = place, .casts_shadows = true};
}

inline Layer matte(std::size_t dataset, double isovalue) {
  Layer layer{.dataset = dataset, .isovalue = isovalue, .method = render::method_of(render::Accuracy::float32)};
  layer.material = {.color = {1, 1, 1}, .ambient = 0.25, .specular = 0};
  return layer;
}

inline Scene scene_of(const std::vector<Layer>& layers, const std::vector<Light>& lights, const Box3& box = cube) {
  Scene scene;
  scene.layers = layers;
  scene.lights = lights;
  scene.camera = render::fit_camera(box, {.azimuth_deg = 33, .elevation_deg = 31, .zoom = 1.1}, 1);
  scene.background = {0, 0, 0};
  return scene;
}

struct Picture {
  Framebuffer pixels;
  render::FrameStatistics statistics;

  bool is_hit(std::size_t p) const { return pixels.depth[p] < static_cast<float>(infinity); }
  Vec3 normal(std::size_t p) const {
    return {pixels.normal[3 * p], pixels.normal[3 * p + 1], pixels.normal[3 * p + 2]};
  }
  float red(std::size_t p) const { return pixels.color[4 * p]; }
};

inline Picture picture_of(const std::vector<render::Dataset>& datasets, const Scene& scene, unsigned threads = 1) {
  Picture picture;
  picture.statistics = render::render(
      datasets, scene, {.width = edge, .height = edge, .channels = all_channels, .threads = threads}, picture.pixels);
  return picture;
}

inline Affine scaled(Affine map, double scale) {
  for (Vec3* axis : {&map.x_axis, &map.y_axis, &map.z_axis, &map.origin}) *axis *= scale;
  return map;
}

/// Returns a field on [-1, 1]^3 times `scale`, as a grid and as a mesh, with its values times
/// `steepness`.
inline std::vector<render::Dataset> both_kinds(const TemporaryFolder& folder, const Field& field, std::int64_t cells,
                                               double scale = 1, double steepness = 1) {
  const Field of_world = [&](const Vec3& p) { return steepness * field(p / scale); };
  const Index3 samples(cells + 1, cells + 1, cells + 1);
  std::vector<render::Dataset> datasets;
  datasets.push_back(packed(folder, "grid.rho",
                            sampled_volume<double>(samples, scaled(lattice_over(cube, samples), scale), of_world)));
  preprocess::NeutralMesh mesh =
      box_mesh({.cells = {cells, cells, cells}, .box = {scale * cube.min, scale * cube.max}});
  add_point_field(mesh, "value", of_world);
  datasets.push_back(packed(folder, "mesh.rho", mesh));
  return datasets;
}

inline double ball(const Vec3& p) {
  return 0.7 - p.length();
}

inline constexpr double scales[] = {1, 1e-20, 1e20};

inline double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z);
}

/// A ball of radius 0.4 about the origin over a floor at z = -0.75, each a volume of its own.
inline std::vector<render::Dataset> ball_over_floor(const TemporaryFolder& folder, bool floor_is_mesh) {
  std::vector<render::Dataset> datasets;
  // The field is a sum of squares: between samples its interpolant is too large by at most 3/4 h^2,
  // which changes the ball's radius by 3/8 h^2 / r.
  const Index3 samples(81, 81, 81);
  const Box3 around{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
  datasets.push_back(
      packed(folder, "ball.rho",
             sampled_volume<double>(samples, lattice_over(around, samples), [](const Vec3& p) { return -p.dot(p); })));
  const Field height = linear_field({0, 0, 1});
  const Index3 few(7, 7, 7);
  const Box3 wide{{-3, -3, -1}, {3, 3, -0.4}};
  if (floor_is_mesh) {
    preprocess::NeutralMesh mesh = box_mesh({.cells = {5, 5, 3}, .box = wide});
    add_point_field(mesh, "value", height);
    datasets.push_back(packed(folder, "floor.rho", mesh));
  } else {
    datasets.push_back(packed(folder, "floor.rho", sampled_volume<double>(few, lattice_over(wide, few), height)));
  }
  return datasets;
}

inline Vec3 place_of(const Scene& scene, const Picture& picture, std::size_t p) {
  const render::CameraRays rays(scene.camera, edge, edge);
  return rays.through_pixel(static_cast<int>(p % edge), static_cast<int>(p / edge))
      .at(static_cast<double>(picture.pixels.depth[p]));
}

}  // namespace rhoray::tests::lit

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "preprocess/pack_surface.h"
#include "render/render.h"
#include "tests/agreement/pictures.h"
#include "tests/support/surfaces.h"

/// Volumes of all kinds, clip regions of all kinds, and the expected result of clipping.
namespace rhoray::tests::clipped {

using render::Clip;
using render::Framebuffer;
using render::HalfSpace;
using render::Layer;
using render::Mode;
using render::Scene;

inline constexpr int edge = 80;
inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline const Box3 cube{{-1, -1, -1}, {1, 1, 1}};

inline double waves(const Vec3& p) {
  return std::sin(5 * p.x + 1) + std::sin(4 * p.y) * std::cos(6 * p.z) + 0.2 * p.z;
}

struct Shown {
  TemporaryFolder folder;
  /// A grid, a mesh, a sparse grid with rotated axes, and a ball of triangles.
  std::vector<render::Dataset> datasets;

  Shown() {
    const Index3 samples(25, 25, 25);
    Affine turned = lattice_over(cube, samples);
    std::swap(turned.x_axis, turned.z_axis);
    preprocess::NeutralMesh mesh = box_mesh({.cells = {9, 9, 9}, .box = cube, .jitter = 0.1});
    add_point_field(mesh, "value", waves);
    datasets.push_back(packed(folder, "grid.rho", sampled_volume<float>(samples, lattice_over(cube, samples), waves)));
    datasets.push_back(packed(folder, "mesh.rho", mesh));
    datasets.push_back(packed(folder, "turned.rho",
                              sampled_volume<float>(samples, turned,
                                                    [](const Vec3& p) {
                                                      return p.x > 0.8 ? std::numeric_limits<double>::quiet_NaN()
                                                                       : 1 - p.length();
                                                    }),
                              {.order = preprocess::SampleOrder::sparse}));
    preprocess::pack_surface(moved(round_surface(3), Vec3(0), 0.8), folder / "ball.rho");
    datasets.push_back(render::Dataset::load(folder / "ball.rho"));
  }
};

inline Layer surface(std::size_t dataset, double isovalue, render::Accuracy accuracy, double opacity = 1) {
  Layer layer{.dataset = dataset, .isovalue = isovalue, .method = render::method_of(accuracy)};
  if (dataset == 3) layer.mode = Mode::triangles;
  layer.material.color = {0.2 + 0.2 * static_cast<double>(dataset), 0.6, 0.3};
  layer.material.opacity = opacity;
  return layer;
}

inline Scene scene_of(const std::vector<Layer>& layers, const std::optional<Clip>& clip = {},
                      bool orthographic = false) {
  Scene scene;
  scene.layers = layers;
  scene.clip = clip;
  scene.camera =
      render::fit_camera(cube, {.azimuth_deg = 33, .elevation_deg = 21, .zoom = 1.1, .orthographic = orthographic}, 1);
  scene.background = {0.9, 0.8, 0.7};
  return scene;
}

struct Picture {
  Framebuffer pixels;
  render::FrameStatistics statistics;
};

inline Picture picture_of(const std::vector<render::Dataset>& datasets, const Scene& scene, unsigned threads = 1,
                          bool use_hierarchy = true) {
  Picture picture;
  picture.statistics = render::render(
      datasets, scene,
      {.width = edge, .height = edge, .channels = all_channels, .threads = threads, .use_hierarchy = use_hierarchy},
      picture.pixels);
  return picture;
}

inline const std::vector<HalfSpace> oblique{{.point = {0.1, 0, 0.2}, .normal = {1, -2, 0.5}},
                                            {.point = {-0.2, 0.3, 0}, .normal = {0.3, 1, 2}}};

/// Regions of all kinds.
inline std::vector<Clip> regions() {
  std::vector<Clip> all{{.planes = {oblique[0]}},
                        {.planes = oblique},
                        {.box = Box3({-0.5, -0.7, -2}, {0.6, 0.4, 0.5})},
                        {.box = Box3({-0.5, -0.7, -2}, {0.6, 0.4, 0.5}), .planes = oblique}};
  for (std::size_t i = 0, count = all.size(); i < count; ++i) {
    all.push_back(all[i]);
    all.back().cuts_away = true;
  }
  return all;
}

inline bool lies_in(const Clip& clip, const Vec3& place, double slack) {
  if (clip.box)
    for (int axis = 0; axis < 3; ++axis)
      if (!(place[axis] >= clip.box->min[axis] - slack && place[axis] <= clip.box->max[axis] + slack)) return false;
  return std::all_of(clip.planes.begin(), clip.planes.end(),
                     [&](const HalfSpace& half) { return half.normal.normalized().dot(place - half.point) >= -slack; });
}

/// Whether a point is shown; nothing when it is in a face, to rounding.
inline std::optional<bool> is_kept(const Clip& clip, const Vec3& place, double slack = 1e-5) {
  const bool surely_in = lies_in(clip, place, -slack), maybe_in = lies_in(clip, place, slack);
  if (surely_in != maybe_in) return std::nullopt;
  return surely_in != clip.cuts_away;
}

}  // namespace rhoray::tests::clipped

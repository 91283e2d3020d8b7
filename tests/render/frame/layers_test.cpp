#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "formats/base/error.h"
#include "render/ray_caster.h"
#include "tests/agreement/pictures.h"

/// Scenes of several layers: the nearest surface is shown, transparent surfaces in their order, MIP
/// layers blended over them.
namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::Layer;
using render::Mode;
using render::Scene;
using render::StartSide;

constexpr int edge = 72;
constexpr double infinity = std::numeric_limits<double>::infinity();

double waves(const Vec3& p) {
  return std::sin(5 * p.x + 1) + std::sin(4 * p.y) * std::cos(6 * p.z) + 0.2 * p.z;
}

struct Shown {
  TemporaryFolder folder;
  /// A grid, a mesh at the same position, a grid with rotated axes.
  std::vector<render::Dataset> datasets;

  Shown() {
    const Box3 box{{-1, -1, -1}, {1, 1, 1}};
    const Index3 samples(25, 25, 25);
    Affine turned = lattice_over(box, samples);
    std::swap(turned.x_axis, turned.z_axis);
    preprocess::NeutralMesh mesh = box_mesh({.cells = {9, 9, 9}, .box = box, .jitter = 0.1});
    add_point_field(mesh, "value", waves);
    datasets.push_back(packed(folder, "grid.rho", sampled_volume<float>(samples, lattice_over(box, samples), waves)));
    datasets.push_back(packed(folder, "mesh.rho", mesh));
    datasets.push_back(packed(folder, "turned.rho",
                              sampled_volume<float>(samples, turned, [](const Vec3& p) { return 1 - p.length(); })));
  }
};

Scene scene_of(const std::vector<Layer>& layers) {
  Scene scene;
  scene.layers = layers;
  scene.camera =
      render::fit_camera({{-1, -1, -1}, {1, 1, 1}}, {.azimuth_deg = 33, .elevation_deg = 21, .zoom = 1.1}, 1);
  scene.background = {0.9, 0.8, 0.7};
  return scene;
}

Framebuffer picture_of(const std::vector<render::Dataset>& datasets, const Scene& scene, unsigned threads = 1,
                       render::FrameStatistics* statistics = nullptr) {
  Framebuffer out;
  const auto found = render::render(datasets, scene,
                                    {.width = edge, .height = edge, .channels = all_channels, .threads = threads}, out);
  if (statistics != nullptr) *statistics = found;
  return out;
}

Layer surface(std::size_t dataset, double isovalue, const Vec3& color, double opacity = 1) {
  Layer layer{.dataset = dataset, .isovalue = isovalue, .method = render::method_of(render::Accuracy::float32)};
  layer.material.color = color;
  layer.material.opacity = opacity;
  return layer;
}

TEST(Layers, show_the_nearest_surface) {
  const Shown shown;
  const std::vector<Layer> layers{surface(0, 0.9, {1, 0, 0}), surface(1, 0.2, {0, 1, 0}), surface(2, 0.35, {0, 0, 1})};
  std::vector<Framebuffer> alone;
  for (const Layer& layer : layers) alone.push_back(picture_of(shown.datasets, scene_of({layer})));
  const Framebuffer all = picture_of(shown.datasets, scene_of(layers));
  std::vector<std::size_t> shown_of(layers.size() + 1);
  for (std::size_t p = 0; p < all.pixel_count(); ++p) {
    std::size_t nearest = 0;
    for (std::size_t l = 1; l < layers.size(); ++l)
      if (alone[l].depth[p] < alone[nearest].depth[p]) nearest = l;
    const Framebuffer& from = alone[nearest];
    ++shown_of[from.depth[p] < infinity ? nearest : layers.size()];
    // A ray that ends at a surface behind is cut into other pieces, so its root is rounded
    // differently.
    for (std::size_t c = 0; c < 4; ++c) ASSERT_NEAR(all.color[4 * p + c], from.color[4 * p + c], 1e-5) << p;
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(all.normal[3 * p + c], from.normal[3 * p + c], 1e-5) << p;
    ASSERT_FLOAT_EQ(all.depth[p], from.depth[p]) << p;
    ASSERT_EQ(all.cell[p], from.cell[p]);
  }
  for (const std::size_t count : shown_of) EXPECT_GT(count, 100);
}

TEST(Layers, may_come_in_any_order) {
  const Shown shown;
  std::vector<Layer> layers{surface(0, 0.9, {1, 0, 0}), surface(1, 0.2, {0, 1, 0}, 0.4),
                            surface(2, 0.35, {0, 0, 1}, 0.7), surface(2, 0.6, {1, 1, 0})};
  const Framebuffer first = picture_of(shown.datasets, scene_of(layers));
  std::reverse(layers.begin(), layers.end());
  const Framebuffer reversed = picture_of(shown.datasets, scene_of(layers), 3);
  // A ray ends at the nearest opaque layer traced before. Its end may change a crossing in front of
  // it by its last digit: observed with the scalar and the baseline kernels, in one pixel or two.
  std::size_t differing = 0;
  for (std::size_t i = 0; i < first.color.size(); ++i) {
    differing += first.color[i] != reversed.color[i];
    ASSERT_NEAR(first.color[i], reversed.color[i], 1e-6F);
  }
  EXPECT_LE(differing, first.color.size() / 1000);
  EXPECT_EQ(first.depth, reversed.depth);
}

/// Returns all crossings on a ray, one layer after another, from exact arithmetic: each is traced
/// behind the last.
struct Crossing {
  double t;
  std::size_t layer;
};
std::vector<Crossing> crossings_on(const std::vector<render::Dataset>& datasets, const std::vector<Layer>& layers,
                                   const render::Camera& camera, std::size_t pixel) {
  std::vector<Crossing> all;
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const render::Dataset& dataset = datasets[layers[l].dataset];
    render::RayCaster judge(dataset, layers[l].isovalue, render::method_of(render::Accuracy::exact));
    render::Ray ray = camera_rays(dataset, camera, edge, edge)[pixel];
    for (;;) {
      const render::Hit hit = judge.first_crossing(ray);
      if (hit.is_miss()) break;
      all.push_back({hit.t, l});
      ray.t_min = hit.t + 1e-7;
    }
  }
  std::sort(all.begin(), all.end(), [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  return all;
}

TEST(ClearLayers, are_seen_in_their_exact_order) {
  const Shown shown;
  // Only ambient light: a pixel is then the mix of the layers' colours, and shows how often each
  // was hit.
  std::vector<Layer> layers{surface(2, 0.5, {1, 0, 0}, 0.3), surface(2, 0.5 + 0.001 / 12, {0, 1, 0}, 0.5),
                            surface(0, 0.4, {0, 0, 1}, 0.2)};
  for (Layer& layer : layers) layer.material.ambient = 1, layer.material.specular = 0;
  const Scene scene = scene_of(layers);
  render::FrameStatistics statistics;
  const Framebuffer found = picture_of(shown.datasets, scene, 2, &statistics);
  std::size_t crossings = 0, checked = 0, close = 0;
  for (std::size_t p = 0; p < found.pixel_count(); p += 7) {
    const std::vector<Crossing> all = crossings_on(shown.datasets, layers, scene.camera, p);
    bool is_clear_cut = true;
    for (std::size_t c = 1; c < all.size(); ++c) {
      // A grazed surface, or two that meet: rounding decides.
      is_clear_cut &= all[c].t - all[c - 1].t > 2e-6;
      close += all[c].t - all[c - 1].t < 1e-3 && all[c].layer != all[c - 1].layer;
    }
    if (!is_clear_cut) continue;
    Vec3 light(0, 0, 0);
    double through = 1;
    for (const Crossing& crossing : all) {
      const render::Material& s = layers[crossing.layer].material;
      light += through * s.opacity * s.color;
      through *= 1 - s.opacity;
      if (through < 1.0 / 1024) break;
    }
    light += through * scene.background;
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(found.color[4 * p + static_cast<std::size_t>(c)], light[c], 2e-3) << p << " of " << all.size();
    ASSERT_NEAR(found.color[4 * p + 3], 1 - through, 2e-3);
    if (!all.empty()) {
      ASSERT_NEAR(found.depth[p], all.front().t, 1e-4);
    }
    crossings += all.size(), ++checked;
  }
  EXPECT_GT(checked, 600);
  EXPECT_GT(crossings, 500);
  EXPECT_GT(close, 100) << "the shells no longer lie close to each other";
  EXPECT_GT(statistics.rays_through, 1500);
}

TEST(ClearLayers, cost_nothing_where_there_are_none) {
  const Shown shown;
  render::FrameStatistics statistics;
  picture_of(shown.datasets, scene_of({surface(0, 0.9, {1, 0, 0}), surface(1, 0.2, {0, 1, 0})}), 1, &statistics);
  EXPECT_EQ(statistics.rays_through, 0);
}

TEST(ClearLayers, that_hold_back_nothing_are_not_traced) {
  const Shown shown;
  render::FrameStatistics with, without;
  const Framebuffer a =
      picture_of(shown.datasets, scene_of({surface(0, 0.9, {1, 0, 0}), surface(1, 0.2, {0, 1, 0}, 0)}), 1, &with);
  const Framebuffer b = picture_of(shown.datasets, scene_of({surface(0, 0.9, {1, 0, 0})}), 1, &without);
  EXPECT_EQ(a.color, b.color);
  EXPECT_EQ(with.cells_visited, without.cells_visited);
  const Framebuffer none = picture_of(shown.datasets, scene_of({surface(1, 0.2, {0, 1, 0}, 0)}), 1, &with);
  EXPECT_EQ(with.cells_visited + with.macrocells_visited + with.hits, 0);
  EXPECT_EQ(none.color[0], 0.9F);
}

TEST(LargestValues, are_added_over_surfaces_up_to_the_nearest) {
  const Shown shown;
  Layer veil{.dataset = 0, .mode = Mode::mip, .window = shown.datasets[0].field().range};
  const Layer wall = surface(2, 0.45, {0.3, 0.3, 0.3});
  const Scene scene = scene_of({veil, wall});
  const Framebuffer both = picture_of(shown.datasets, scene), behind = picture_of(shown.datasets, scene_of({wall}));
  render::RayCaster queries(shown.datasets[0], 0, {});
  const auto rays = camera_rays(shown.datasets[0], scene.camera, edge, edge);
  std::size_t cut = 0;
  for (std::size_t p = 0; p < both.pixel_count(); ++p) {
    render::Ray ray = rays[p];
    if (behind.depth[p] < infinity) ray.t_max = behind.depth[p], ++cut;
    render::Hit hit;
    queries.largest_values({&ray, 1}, {&hit, 1});
    double share = 0;
    if (!hit.is_miss()) {
      const double code = (hit.value - veil.window.lo) / (veil.window.hi - veil.window.lo);
      share = code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const double color = behind.color[4 * p + c];
      ASSERT_NEAR(both.color[4 * p + c], color + share * (1 - color), 2e-5) << p;
    }
  }
  EXPECT_GT(cut, 400);
}

TEST(Layers, are_refused_where_they_make_no_sense) {
  const Shown shown;
  Framebuffer out;
  const auto refused = [&](const std::vector<Layer>& layers) {
    try {
      render::render(shown.datasets, scene_of(layers), {.width = 4, .height = 4}, out);
    } catch (const Error& error) {
      return error.code() == ErrorCode::usage;
    }
    return false;
  };
  EXPECT_TRUE(refused({}));
  EXPECT_TRUE(refused({surface(3, 0, {1, 1, 1})}));
  EXPECT_TRUE(refused({surface(0, 0, {1, 1, 1}), surface(0, std::nan(""), {1, 1, 1})}));
  EXPECT_TRUE(refused({surface(0, 0, {1, 1, 1}, 1.5)}));
  EXPECT_TRUE(refused({surface(0, 0, {1, 1, 1}, std::nan(""))}));
  EXPECT_TRUE(refused(std::vector<Layer>(255, surface(0, 0, {1, 1, 1}))));
  EXPECT_FALSE(refused({surface(0, 0, {1, 1, 1}), surface(1, 0, {1, 1, 1}, 0.5)}));
}

}  // namespace
}  // namespace rhoray::tests

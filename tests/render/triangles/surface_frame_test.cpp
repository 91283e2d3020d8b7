#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/pack_surface.h"
#include "render/ray_caster.h"
#include "tests/agreement/pictures.h"
#include "tests/support/expect_error.h"
#include "tests/support/surfaces.h"

/// Surfaces in pictures: alone, and among the layers of other volumes.
namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::Layer;
using render::Mode;
using render::Scene;

constexpr int edge = 64;
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Shown {
  TemporaryFolder folder;
  /// A ball of triangles of radius 0.8, a grid whose field is 1 - distance.
  std::vector<render::Dataset> datasets;

  explicit Shown(int depth = 4) {
    preprocess::pack_surface(moved(round_surface(depth), Vec3(0), 0.8), folder / "ball.rho");
    datasets.push_back(render::Dataset::load(folder / "ball.rho"));
    const Index3 samples(25, 25, 25);
    datasets.push_back(packed(folder, "grid.rho",
                              sampled_volume<float>(samples, lattice_over({{-1, -1, -1}, {1, 1, 1}}, samples),
                                                    [](const Vec3& p) { return 1 - p.length(); })));
  }
};

Layer triangles(const Vec3& color, double opacity = 1, render::Accuracy accuracy = render::Accuracy::float32) {
  Layer layer{.dataset = 0, .mode = Mode::triangles, .method = render::method_of(accuracy)};
  layer.material.color = color;
  layer.material.opacity = opacity;
  return layer;
}

Layer isosurface(double isovalue, const Vec3& color, double opacity = 1) {
  Layer layer{.dataset = 1, .isovalue = isovalue, .method = render::method_of(render::Accuracy::float32)};
  layer.material.color = color;
  layer.material.opacity = opacity;
  return layer;
}

Scene scene_of(const std::vector<Layer>& layers) {
  Scene scene;
  scene.layers = layers;
  scene.camera = render::fit_camera({{-1, -1, -1}, {1, 1, 1}}, {.azimuth_deg = 33, .elevation_deg = 21}, 1);
  return scene;
}

Framebuffer picture_of(const Shown& shown, const Scene& scene, render::FrameStatistics* statistics = nullptr,
                       bool use_hierarchy = true) {
  Framebuffer out;
  const auto found = render::render(
      shown.datasets, scene,
      {.width = edge, .height = edge, .channels = all_channels, .threads = 1, .use_hierarchy = use_hierarchy}, out);
  if (statistics != nullptr) *statistics = found;
  return out;
}

TEST(Surfaces, are_volumes_without_fields) {
  const Shown shown;
  const render::Dataset& ball = shown.datasets[0];
  EXPECT_TRUE(ball.is_surface());
  EXPECT_FALSE(ball.is_mesh());
  EXPECT_FALSE(shown.datasets[1].is_surface());
  EXPECT_TRUE(ball.field_names().empty());
  EXPECT_EQ(ball.field().name, "");
  EXPECT_FALSE(ball.field("value"));
  EXPECT_EQ(ball.bounds(), Box3(Vec3(-0.8), Vec3(0.8)));
  EXPECT_TRUE(ball.isosurface_bounds(0.5).isEmpty());
  EXPECT_EQ(render::default_method(ball, Mode::triangles), render::method_of(render::Accuracy::float32));
}

TEST(Surfaces, are_seen_where_they_are) {
  const Shown shown(6);
  const Scene scene = scene_of({triangles({1, 0, 0})});
  const Framebuffer found = picture_of(shown, scene);
  const std::vector<render::Ray> rays = camera_rays(shown.datasets[0], scene.camera, edge, edge);
  std::size_t hits = 0;
  for (std::size_t p = 0; p < found.pixel_count(); ++p) {
    const Vec3 &o = rays[p].origin, &d = rays[p].direction;
    const double b = o.dot(d), distance = (o - b * d).length();
    // The ball of flat triangles is slightly smaller.
    if (std::abs(distance - 0.8) < 2e-3) continue;
    ASSERT_EQ(found.depth[p] < infinity, distance < 0.8) << p;
    if (distance > 0.8) continue;
    ++hits;
    const double t = -b - std::sqrt(0.64 - distance * distance);
    const double slant = std::abs((o + t * d).dot(d)) / 0.8;
    ASSERT_NEAR(found.depth[p], t, 4e-4 / slant) << p;
    EXPECT_TRUE(std::isnan(found.value[p]));
    const Vec3 normal(found.normal[3 * p], found.normal[3 * p + 1], found.normal[3 * p + 2]);
    EXPECT_GT(normal.dot((o + t * d).normalized()), 0.999);
  }
  EXPECT_GT(hits, 600U);
}

TEST(Surfaces, are_the_same_at_double_with_and_without_the_tree) {
  const Shown shown;
  const Scene wide = scene_of({triangles({1, 0, 0})}),
              scalar = scene_of({triangles({1, 0, 0}, 1, render::Accuracy::float64)});
  const Framebuffer in_float = picture_of(shown, wide), in_double = picture_of(shown, scalar);
  const Framebuffer without_tree = picture_of(shown, scalar, nullptr, false);
  EXPECT_EQ(in_double.color, without_tree.color);
  EXPECT_EQ(in_double.depth, without_tree.depth);
  std::size_t others = 0;
  for (std::size_t p = 0; p < in_float.pixel_count(); ++p)
    others += in_float.cell[p] != in_double.cell[p] || in_float.depth[p] != in_double.depth[p] ? 1 : 0;
  EXPECT_LT(others, 4U);
}

TEST(Surfaces, hide_and_are_hidden_among_other_layers) {
  const Shown shown(2);
  // The isosurface is a ball of radius 0.79: in front of the middles of triangles, behind their
  // corners.
  const Layer red = triangles({1, 0, 0}), blue = isosurface(0.215, {0, 0, 1});
  const Framebuffer of_triangles = picture_of(shown, scene_of({red})), of_field = picture_of(shown, scene_of({blue}));
  const Framebuffer both = picture_of(shown, scene_of({red, blue}));
  std::size_t nearer[2] = {0, 0};
  for (std::size_t p = 0; p < both.pixel_count(); ++p) {
    const bool is_red = of_triangles.depth[p] < of_field.depth[p];
    const Framebuffer& first = is_red ? of_triangles : of_field;
    ASSERT_FLOAT_EQ(both.depth[p], first.depth[p]) << p;
    for (std::size_t c = 0; c < 4; ++c) ASSERT_NEAR(both.color[4 * p + c], first.color[4 * p + c], 1e-4) << p;
    if (first.depth[p] < infinity) ++nearer[is_red ? 0 : 1];
  }
  EXPECT_GT(nearer[0], 20U);
  EXPECT_GT(nearer[1], 20U);
}

TEST(Surfaces, may_be_seen_through_once_for_each_crossing) {
  const Shown shown;
  // Only ambient light: a pixel is then a mix of colours that shows how often each layer was hit.
  std::vector<Layer> layers{triangles({1, 0, 0}, 0.5), isosurface(0.6, {0, 0, 1})};
  for (Layer& layer : layers) layer.material.ambient = 1, layer.material.specular = 0;
  render::FrameStatistics statistics;
  const Scene scene = scene_of(layers);
  const Framebuffer found = picture_of(shown, scene, &statistics);
  const Framebuffer of_ball = picture_of(shown, scene_of({triangles({1, 0, 0})}));
  const Framebuffer inside = picture_of(shown, scene_of({layers[1]}));
  std::size_t through_one = 0, through_two = 0;
  for (std::size_t p = 0; p < found.pixel_count(); ++p) {
    if (!(of_ball.depth[p] < infinity)) continue;
    const float* color = found.color.data() + 4 * p;
    if (inside.depth[p] < infinity) {
      ++through_one;
      ASSERT_NEAR(color[0], 0.5, 1e-5) << p;
      ASSERT_NEAR(color[2], 0.5, 1e-5) << p;
    } else {
      ++through_two;
      ASSERT_NEAR(color[0], 1, 1e-5) << p;
      ASSERT_NEAR(color[1], 0.25, 1e-5) << p;
    }
  }
  EXPECT_GT(through_one, 100U);
  EXPECT_GT(through_two, 300U);
  EXPECT_GT(statistics.rays_through, through_two);
}

TEST(Surfaces, are_not_asked_about_when_they_hold_back_no_light) {
  const Shown shown;
  render::FrameStatistics statistics;
  const Framebuffer found =
      picture_of(shown, scene_of({triangles({1, 0, 0}, 0), isosurface(0.5, {0, 0, 1})}), &statistics);
  const Framebuffer alone = picture_of(shown, scene_of({isosurface(0.5, {0, 0, 1})}));
  EXPECT_EQ(found.color, alone.color);
  EXPECT_EQ(statistics.rays_through, 0U);
}

TEST(Surfaces, have_smooth_normals_that_are_those_of_the_ball) {
  const Shown shown(3);
  Layer layer = triangles({1, 0, 0});
  const Framebuffer flat = picture_of(shown, scene_of({layer}));
  layer.material.normals = render::Normals::smooth;
  const Scene scene = scene_of({layer});
  render::FrameStatistics statistics;
  const Framebuffer smooth = picture_of(shown, scene, &statistics);
  const std::vector<render::Ray> rays = camera_rays(shown.datasets[0], scene.camera, edge, edge);
  EXPECT_EQ(smooth.depth, flat.depth);
  EXPECT_EQ(statistics.normals_smoothed, statistics.hits);
  double worst_flat = 1, worst_smooth = 1;
  for (std::size_t p = 0; p < smooth.pixel_count(); ++p) {
    if (!(smooth.depth[p] < infinity)) continue;
    const Vec3 outward = rays[p].at(static_cast<double>(smooth.depth[p])).normalized();
    // Near the border a mean normal may point away from the eye.
    if (outward.dot(rays[p].direction) > -0.3) continue;
    const auto normal = [&](const Framebuffer& of) {
      return Vec3(of.normal[3 * p], of.normal[3 * p + 1], of.normal[3 * p + 2]);
    };
    worst_flat = std::min(worst_flat, outward.dot(normal(flat)));
    worst_smooth = std::min(worst_smooth, outward.dot(normal(smooth)));
  }
  EXPECT_LT(worst_flat, 0.995);
  EXPECT_GT(worst_smooth, 0.9995);
}

TEST(Surfaces, refuse_what_asks_for_a_field) {
  const Shown shown;
  const auto refused = [&](Layer layer, const std::string& with) {
    expect_error(ErrorCode::usage, with, [&] { picture_of(shown, scene_of({layer})); });
  };
  Layer layer = triangles({1, 0, 0});
  layer.mode = Mode::isosurface;
  refused(layer, "triangles");
  layer.mode = Mode::mip;
  refused(layer, "triangles");
  layer.mode = Mode::triangles;
  layer.dataset = 1;
  refused(layer, "no triangles");
  layer.dataset = 0;
  layer.method = render::method_of(render::Accuracy::certified);
  refused(layer, "float and double");
  layer = triangles({1, 0, 0});
  layer.material.color_by = render::FieldColors{.field = "a", .range = {0, 1}};
  refused(layer, "no fields");
  expect_error(ErrorCode::usage, "no fields", [&] { render::Dataset::load(shown.folder / "ball.rho", "value"); });
}

}  // namespace
}  // namespace rhoray::tests

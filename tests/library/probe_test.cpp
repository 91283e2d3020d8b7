// RenderContext::probe: all hits of the ray through a point of a picture.
#include <gtest/gtest.h>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"

namespace rhoray::tests {
namespace {

/// A picture of 9 x 9 pixels, one unit apart. The ray of pixel (4, 4) is (x, 0.6, 1.4) and goes
/// along +x from x = -5; columns go along -y, rows along -z.
constexpr Size size{9, 9};
constexpr Camera along_x{.position = {-5, 0.6, 1.4}, .target = {0, 0.6, 1.4}, .orthographic_height = 9};

/// Values 0, 1, 0, 1, ... along x: a ray along x crosses 0.5 in the middle of each of the 20 cells.
Dataset stripes() {
  const Samples<std::uint8_t> samples = samples_of<std::uint8_t>(21, 3, 3, [](auto i, auto, auto) { return i % 2; });
  GridArrays grid{.fields = {samples.field("stripes")}};
  grid.fields[0].unit = "K";
  return pack(grid, AxisOrder::zyx);
}

Scene scene_of(std::vector<Layer> layers) {
  return {.layers = std::move(layers), .camera = along_x};
}

std::vector<double> xs_of(const std::vector<ProbeHit>& hits) {
  std::vector<double> xs;
  for (const ProbeHit& hit : hits) xs.push_back(hit.position.x);
  return xs;
}

TEST(Probe, finds_all_crossings_of_a_field_with_a_known_answer) {
  const Scene scene = scene_of({{.data = stripes(), .show = Isosurface{0.5}, .method = Accuracy::preview}});
  const std::vector<ProbeHit> hits = RenderContext().probe(scene, size, 4, 4);
  ASSERT_EQ(hits.size(), 20U);
  for (std::size_t i = 0; i < 20; ++i) {
    const double x = 0.5 + static_cast<double>(i);
    ASSERT_TRUE(hits[i].error);
    EXPECT_LE(distance(hits[i].position, {x, 0.6, 1.4}), *hits[i].error);
    EXPECT_LT(*hits[i].error, 1e-11);
    EXPECT_LE(std::abs(hits[i].depth - (5 + x)), *hits[i].error);
    EXPECT_EQ(hits[i].cell, 20 * 2 + i);
    EXPECT_EQ(hits[i].layer, 0U);
    EXPECT_EQ(hits[i].value, 0.5);
    EXPECT_FALSE(hits[i].value_error);
    EXPECT_EQ(hits[i].unit, "K");
  }
  EXPECT_EQ(xs_of(RenderContext().probe(scene, size, 4, 4, 7)), xs_of({hits.begin(), hits.begin() + 7}));
}

TEST(Probe, goes_through_any_point_of_the_picture) {
  const Scene scene = scene_of({{.data = stripes(), .show = Isosurface{0.5}}});
  RenderContext context;
  const ProbeHit hit = context.probe(scene, size, 3.75, 4.5, 1).at(0);
  EXPECT_NEAR(hit.position.y, 0.6 + 0.25, 1e-12);
  EXPECT_NEAR(hit.position.z, 1.4 - 0.5, 1e-12);
  for (const double edge : {-0.5, 8.5}) {
    EXPECT_TRUE(context.probe(scene, size, edge, 4).empty());
    EXPECT_TRUE(context.probe(scene, size, 4, edge).empty());
  }
}

TEST(Probe, begins_where_the_picture_at_level_exact_shows_the_surface) {
  const Dataset grid = gyroid_grid();
  constexpr Size small{40, 30};
  Scene scene{.layers = {{.data = grid, .show = Isosurface{0.1}, .method = Accuracy::exact}}};
  scene.camera = fit_camera(scene, small);
  const Picture picture = rendered(scene, {.size = small, .channels = {.depth = true, .cell = true}});
  RenderContext context;
  std::size_t hit_count = 0, pixel = 0;
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x, ++pixel) {
      const std::vector<ProbeHit> hits = context.probe(scene, small, x, y);
      ASSERT_EQ(hits.empty(), picture.cell()[pixel] == no_cell) << x << ", " << y;
      if (hits.empty()) continue;
      ++hit_count;
      EXPECT_EQ(static_cast<float>(hits[0].depth), picture.depth()[pixel]);
      EXPECT_EQ(hits[0].cell, picture.cell()[pixel]);
    }
  EXPECT_GT(hit_count, 300U);
  EXPECT_LT(hit_count, pixel - 100);
}

TEST(Probe, agrees_with_ray_casters) {
  const Dataset mesh = ball_mesh();
  Scene scene = scene_of({{.data = mesh, .show = Isosurface{0.9}, .field = "radius"}});
  scene.camera->position.z = scene.camera->target.z = 0.4;
  MadeRays rays;
  rays.add({-5, 0.6, 0.4}, {1, 0, 0});
  const RayCaster caster(mesh, Isosurface{0.9}, Accuracy::exact, "radius");
  RayScratch scratch;
  AllHits all;
  caster.all_hits(rays.rays(), all, scratch);
  std::vector<double> first(1);
  caster.first_hits(rays.rays(), {.t = first}, scratch);
  const std::vector<ProbeHit> hits = RenderContext().probe(scene, size, 4, 4);
  ASSERT_EQ(hits.size(), 2U);
  ASSERT_EQ(all.t.size(), 2U);
  EXPECT_EQ(hits[0].depth, first[0]);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(hits[i].depth, all.t[i]);
    EXPECT_EQ(hits[i].cell, all.cell[i]);
    EXPECT_GE(hits[i].error.value(), all.error[i]);
  }
}

/// The octahedron |x| + |y| + |z| = 1 around a ball, with a slice through the middle, and a
/// projection. The ray is (x, 0.1, 0.2).
class ProbeOfLayers : public testing::Test {
 protected:
  std::vector<ProbeHit> hits() const { return RenderContext().probe(scene, {1, 1}, 0, 0); }

  Dataset mesh = ball_mesh();
  Scene scene{.layers = {{.data = mesh, .show = Isosurface{0.5}, .field = "radius"},
                         {.data = octahedron(), .show = Triangles{}},
                         {.data = mesh, .show = Slice{.plane = {.normal = {1, 0, 0}}}, .field = "x"},
                         {.data = mesh, .show = MaximumProjection{}, .field = "radius"}},
              .camera = Camera{.position = {-5, 0.1, 0.2}, .target = {0, 0.1, 0.2}, .orthographic_height = 1}};
};

TEST_F(ProbeOfLayers, come_in_their_order_along_the_ray) {
  const std::vector<ProbeHit> found = hits();
  ASSERT_EQ(found.size(), 6U);
  std::vector<std::size_t> layers;
  for (const ProbeHit& hit : found) layers.push_back(hit.layer);
  EXPECT_EQ(layers, (std::vector<std::size_t>{3, 1, 0, 2, 0, 1}));
  // The largest distance from the middle in front of the octahedron is at the mesh's face.
  EXPECT_NEAR(found[0].position.x, -1, 1e-12);
  FieldSampler sampler(mesh, "radius");
  const std::vector<double> point{-1, 0.1, 0.2};
  std::vector<double> value(1);
  sampler.at({std::span<const double>(point), {1, 3}}, value);
  ASSERT_TRUE(found[0].value_error);
  EXPECT_LT(*found[0].value_error, 1e-12);
  EXPECT_NEAR(found[0].value, value[0], 1e-14);
  EXPECT_FALSE(found[0].error);
  for (const auto& [i, x] : {std::pair<std::size_t, double>{1, -0.7}, {5, 0.7}}) {
    EXPECT_NEAR(found[i].position.x, x, 1e-12);
    EXPECT_TRUE(std::isnan(found[i].value));
    EXPECT_FALSE(found[i].error);
  }
  EXPECT_NEAR(found[3].position.x, 0, 1e-12);
  EXPECT_NEAR(found[3].value, 0, 1e-12);
  EXPECT_FALSE(found[3].error);
  EXPECT_TRUE(found[2].error && found[4].error);
}

TEST_F(ProbeOfLayers, leave_out_those_that_are_not_shown) {
  scene.layers[1].material.opacity = 0;
  const std::vector<ProbeHit> found = hits();
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[1].layer, 0U);
}

TEST_F(ProbeOfLayers, end_projections_at_opaque_surfaces_only) {
  // The field "x" rises along the ray.
  scene.layers = {scene.layers[0], {.data = mesh, .show = MaximumProjection{}, .field = "x"}};
  std::vector<ProbeHit> found = hits();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].layer, 0U);
  EXPECT_EQ(found[1].layer, 1U);
  EXPECT_NEAR(found[1].value, found[0].position.x, 1e-12);
  scene.layers[0].material.opacity = 0.5;
  found = hits();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[2].layer, 1U);
  EXPECT_NEAR(found[2].value, 1, 1e-12);
}

TEST_F(ProbeOfLayers, have_the_value_that_colours_triangles) {
  scene.layers = {{.data = mesh.boundary(), .show = Triangles{}, .material = {.color_by = FieldColors{.field = "x"}}}};
  const std::vector<ProbeHit> found = hits();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].value, -1, 1e-12);
  EXPECT_NEAR(found[1].value, 1, 1e-12);
}

TEST(Probe, leaves_out_what_is_clipped) {
  Scene scene = scene_of({{.data = stripes(), .show = Isosurface{0.5}},
                          {.data = stripes(), .show = Slice{.plane = {.point = {5, 0, 0}, .normal = {1, 0, 0}}}},
                          {.data = stripes(), .show = MaximumProjection{}}});
  scene.layers[0].material.opacity = scene.layers[1].material.opacity = 0.5;
  scene.clip = Clip{.box = Box3{{3.2, -9, -9}, {5.7, 9, 9}}};
  RenderContext context;
  EXPECT_EQ(xs_of(context.probe(scene, size, 4, 4)), (std::vector<double>{3.5, 4.5, 5, 5, 5.5}));
  scene.clip->is_inverted = true;
  const std::vector<ProbeHit> outside = context.probe(scene, size, 4, 4, 6);
  EXPECT_EQ(xs_of(outside), (std::vector<double>{0.5, 1, 1.5, 2.5, 6.5, 7.5}));
  scene.layers[0].is_clipped = false;
  EXPECT_EQ(context.probe(scene, size, 4, 4).size(), 21U);
}

TEST(Probe, refuses_points_that_are_not_in_the_picture) {
  const Scene scene = scene_of({{.data = stripes(), .show = Isosurface{0.5}}});
  RenderContext context;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {-0.75, 8.75, nan, infinity, -infinity}) {
    const std::string words = "expected a point of the picture, (-0.5, -0.5) to (8.5, 8.5)";
    expect_refused(ErrorCode::usage, words, [&] { context.probe(scene, size, bad, 4); });
    expect_refused(ErrorCode::usage, words, [&] { context.probe(scene, size, 4, bad); });
  }
  expect_refused(ErrorCode::usage, "max_hits is 0; expected at least 1", [&] { context.probe(scene, size, 4, 4, 0); });
  expect_refused(ErrorCode::usage, "expected sides from 1", [&] { context.probe(scene, {0, 9}, 0, 4); });
  Scene without_camera = scene;
  without_camera.camera.reset();
  expect_refused(ErrorCode::usage, "Scene::camera: not set", [&] { context.probe(without_camera, size, 4, 4); });
  EXPECT_EQ(context.probe(scene, size, 4, 4).size(), 20U);
}

}  // namespace
}  // namespace rhoray::tests

// Scenes and options that make no sense are refused, and the picture stays as it was.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

/// A scene of a grid, and a context that has rendered it.
class BadScenes : public testing::Test {
 protected:
  BadScenes() {
    scene_.camera = fit_camera(scene_, options_.size, {});
    context_.render(scene_, options_, picture_);
    before_ = bits_of(picture_);
  }

  /// @param spoil  (Scene&, RenderOptions&)
  void refuse(const std::string& words, const std::function<void(Scene&, RenderOptions&)>& spoil) {
    Scene scene = scene_;
    RenderOptions options = options_;
    spoil(scene, options);
    expect_refused(ErrorCode::usage, words, [&] { context_.render(scene, options, picture_); });
    EXPECT_TRUE(bits_of(picture_) == before_) << words;
    EXPECT_EQ(picture_.size(), options_.size);
  }

  Dataset grid_ = gyroid_grid();
  Dataset mesh_ = ball_mesh();
  Scene scene_{.layers = {{.data = grid_, .show = Isosurface{0}}}};
  RenderOptions options_{.size = {40, 30}, .channels = {.depth = true}};
  RenderContext context_;
  Picture picture_;
  std::string before_;
};

TEST_F(BadScenes, without_camera_or_layers) {
  refuse("Scene::camera: not set", [](Scene& scene, auto&) { scene.camera.reset(); });
  refuse("Scene::layers: found none", [](Scene& scene, auto&) { scene.layers.clear(); });
  refuse("255", [](Scene& scene, auto&) { scene.layers.resize(255, scene.layers[0]); });
  expect_refused(ErrorCode::usage, "Scene::layers: found none", [] { fit_camera(Scene{}, {8, 8}); });
}

TEST_F(BadScenes, whose_layers_do_not_fit_their_data) {
  refuse("layer 0: Isosurface::isovalue: found ", [](Scene& scene, auto&) { scene.layers[0].show = Isosurface{}; });
  refuse("layer 0: Isosurface::isovalue: found ",
         [](Scene& scene, auto&) { scene.layers[0].show = Isosurface{infinite}; });
  refuse("layer 1: ", [&](Scene& scene, auto&) { scene.layers.push_back({.data = mesh_, .show = Isosurface{}}); });
  refuse("no field 'gyriod'", [](Scene& scene, auto&) { scene.layers[0].field = "gyriod"; });
  refuse("layer 0", [](Scene& scene, auto&) { scene.layers[0].show = Triangles{}; });
  refuse("layer 0", [&](Scene& scene, auto&) { scene.layers[0] = {.data = mesh_, .show = Triangles{}}; });
  refuse("layer 0", [&](Scene& scene, auto&) { scene.layers[0] = {.data = octahedron(), .show = Isosurface{0}}; });
  refuse("layer 0",
         [&](Scene& scene, auto&) { scene.layers[0] = {.data = octahedron(), .show = MaximumProjection{}}; });
  for (const Dataset& triangles : {octahedron(), mesh_.boundary()})
    for (const Method& method : {Method(Accuracy::preview), Method(Accuracy::certified), Method(Accuracy::exact),
                                 Method::paper(), Method::sampled(0.5)})
      refuse(": triangles are traced only at float32 and float64", [&](Scene& scene, auto&) {
        scene.layers[0] = {.data = triangles, .show = Triangles{}, .method = method};
      });
  refuse("part",
         [&](Scene& scene, auto&) { scene.layers[0] = {.data = mesh_, .show = Isosurface{1}, .field = "part"}; });
}

TEST_F(BadScenes, whose_colours_are_not_known) {
  refuse("layer 0: colour map 'virdis'; expected viridis",
         [](Scene& scene, auto&) { scene.layers[0].show = MaximumProjection{{.colormap = "virdis"}}; });
  refuse("colour map ''", [](Scene& scene, auto&) {
    scene.layers[0].material.color_by = FieldColors{"gyroid", {.colormap = ""}};
  });
  refuse("nothing", [](Scene& scene, auto&) { scene.layers[0].material.color_by = FieldColors{"nothing", {}}; });
  for (const Interval& range : {Interval{2, 1}, Interval{nan, 1}, Interval{0, infinite}})
    refuse("layer 0", [&](Scene& scene, auto&) { scene.layers[0].show = MaximumProjection{{.range = range}}; });
  refuse("layer 0", [](Scene& scene, auto&) {
    scene.layers[0].show = MaximumProjection{{.range = Interval{-1, 1}, .is_logarithmic = true}};
  });
  for (const int levels : {-1, 1, 1 << 20})
    refuse("layer 0", [&](Scene& scene, auto&) { scene.layers[0].show = MaximumProjection{{.levels = levels}}; });
}

/// Every number of a scene is checked: one that is not a number is refused.
TEST_F(BadScenes, with_numbers_that_are_not_finite) {
  const HalfSpace plane{.point = {0, 4, 4}, .normal = {0, 1, 0}};
  scene_.layers.push_back({.data = grid_, .show = Slice{.plane = plane, .threshold = Interval{-1, 1}}});
  scene_.lights = {{.kind = Light::Kind::point, .place = {1, 2, 3}, .casts_shadows = true, .size = 1},
                   {.kind = Light::Kind::directional, .place = {1, 2, 3}, .casts_shadows = true, .size = 1}};
  scene_.occlusion.radius = 1;
  scene_.fog = Fog{.range = {1, 50}};
  scene_.clip = Clip{.box = Box3{{-9, -9, -9}, {9, 9, 9}}, .planes = {plane}};
  context_.render(scene_, options_, picture_);
  before_ = bits_of(picture_);
  const auto slice = [](Scene& scene) -> Slice& { return std::get<Slice>(scene.layers[1].show); };
  struct Number {
    const char* refusal;  ///< how it begins
    std::function<double&(Scene&)> of;
  };
  const Number numbers[] = {
      {"layer 0: Material::color: found", [](Scene& s) -> double& { return s.layers[0].material.color.y; }},
      {"layer 0: Material::ambient: found", [](Scene& s) -> double& { return s.layers[0].material.ambient; }},
      {"layer 0: Material::specular: found", [](Scene& s) -> double& { return s.layers[0].material.specular; }},
      {"layer 0: Material::shininess: found", [](Scene& s) -> double& { return s.layers[0].material.shininess; }},
      {"layer 0: Material::opacity: found", [](Scene& s) -> double& { return s.layers[0].material.opacity; }},
      {"layer 1: a slice through", [&](Scene& s) -> double& { return slice(s).plane.point.y; }},
      {"layer 1: a slice through", [&](Scene& s) -> double& { return slice(s).plane.normal.z; }},
      {"light 0: a light at", [](Scene& s) -> double& { return s.lights[0].place.x; }},
      {"light 0: a light of colour", [](Scene& s) -> double& { return s.lights[0].color.x; }},
      {"light 0: a light of size", [](Scene& s) -> double& { return s.lights[0].size; }},
      {"light 1: a light from the direction", [](Scene& s) -> double& { return s.lights[1].place.x; }},
      {"light 1: a light of size", [](Scene& s) -> double& { return s.lights[1].size; }},
      {"Occlusion::radius: found", [](Scene& s) -> double& { return s.occlusion.radius; }},
      {"Fog::color: found", [](Scene& s) -> double& { return s.fog->color.z; }},
      {"Fog::range: found", [](Scene& s) -> double& { return s.fog->range.lo; }},
      {"Fog::range: found", [](Scene& s) -> double& { return s.fog->range.hi; }},
      {"a clip box from", [](Scene& s) -> double& { return s.clip->box->min.x; }},
      {"a clip box from", [](Scene& s) -> double& { return s.clip->box->max.z; }},
      {"clip plane 0: through", [](Scene& s) -> double& { return s.clip->planes[0].point.x; }},
      {"clip plane 0: through", [](Scene& s) -> double& { return s.clip->planes[0].normal.x; }},
      {"Scene::background: found", [](Scene& s) -> double& { return s.background->x; }},
      {"camera", [](Scene& s) -> double& { return s.camera->position.x; }},
      {"camera", [](Scene& s) -> double& { return s.camera->target.x; }},
      {"camera", [](Scene& s) -> double& { return s.camera->up.x; }},
      {"field of view", [](Scene& s) -> double& { return s.camera->vertical_fov_deg; }}};
  for (const auto& [refusal, of] : numbers) {
    refuse(refusal, [&, &of = of](Scene& scene, auto&) { of(scene) = nan; });
    if (std::string(refusal) == "a clip box from") continue;  // open boxes are fine
    refuse(refusal, [&, &of = of](Scene& scene, auto&) { of(scene) = infinite; });
  }
  refuse("height", [](Scene& scene, auto&) { scene.camera->orthographic_height = nan; });
  refuse("height", [](Scene& scene, auto&) { scene.camera->orthographic_height = 0; });
  refuse("layer 1: Slice::threshold: found", [&](Scene& scene, auto&) { slice(scene).threshold = Interval{nan, 1}; });
}

TEST_F(BadScenes, with_numbers_out_of_range) {
  const auto refuse_material = [&](const std::string& words, const Material& material) {
    refuse(words, [&](Scene& scene, auto&) { scene.layers[0].material = material; });
  };
  refuse_material("Material::ambient: found 1.5", {.ambient = 1.5});
  refuse_material("Material::specular: found -0.5", {.specular = -0.5});
  refuse_material("Material::shininess: found 0.5; expected 1 to 10000", {.shininess = 0.5});
  refuse_material("layer 0: Material::opacity: found ", {.opacity = 1.5});
  refuse_material("layer 0: Material::opacity: found ", {.opacity = -0.5});
  refuse("Light::samples: found 0; expected 1 to 4096", [](Scene& scene, auto&) { scene.lights[0].samples = 0; });
  refuse("Light::samples: found 5000", [](Scene& scene, auto&) { scene.lights[0].samples = 5000; });
  refuse("light 0: a light from the direction",
         [](Scene& scene, auto&) { scene.lights[0] = {.kind = Light::Kind::directional, .place = {}}; });
  refuse("Occlusion::samples: found 0", [](Scene& scene, auto&) { scene.occlusion = {.samples = 0, .radius = 1}; });
  refuse("Occlusion::radius: found -1", [](Scene& scene, auto&) { scene.occlusion = {.samples = 4, .radius = -1}; });
  refuse("Fog::range: found 5 to 1", [](Scene& scene, auto&) { scene.fog = Fog{.range = {5, 1}}; });
  refuse("7 clip planes", [](Scene& scene, auto&) {
    scene.clip = Clip{.planes = std::vector<HalfSpace>(7, {.normal = {0, 0, 1}})};
  });
  refuse("a clip box from", [](Scene& scene, auto&) { scene.clip = Clip{.box = Box3{{1, 0, 0}, {0, 1, 1}}}; });
  refuse("field of view", [](Scene& scene, auto&) { scene.camera->vertical_fov_deg = 0; });
  refuse("field of view", [](Scene& scene, auto&) { scene.camera->vertical_fov_deg = 180; });
  refuse("camera", [](Scene& scene, auto&) { scene.camera->target = scene.camera->position; });
  refuse("camera", [](Scene& scene, auto&) {
    scene.camera = Camera{.position = {0, 0, 5}, .target = {}, .up = {0, 0, 1}};
  });
}

TEST_F(BadScenes, in_which_something_was_not_set) {
  refuse("light 0: a light at (nan, nan, nan)",
         [](Scene& scene, auto&) { scene.lights = {{.kind = Light::Kind::point}}; });
  refuse("light 1: a light from the direction (nan, nan, nan)",
         [](Scene& scene, auto&) { scene.lights.push_back({.kind = Light::Kind::directional}); });
  refuse("layer 0: a slice through (0, 0, 0) with the normal (0, 0, 0)",
         [](Scene& scene, auto&) { scene.layers[0].show = Slice{}; });
  refuse("Fog::range: found 0 to 0; expected a finite range with lo < hi",
         [](Scene& scene, auto&) { scene.fog = Fog{}; });
  for (const bool is_inverted : {false, true})
    refuse("Scene::clip: found neither a box nor planes",
           [&](Scene& scene, auto&) { scene.clip = Clip{.is_inverted = is_inverted}; });
  refuse("clip plane 1: through (0, 0, 0) with the normal (0, 0, 0)", [](Scene& scene, auto&) {
    scene.clip = Clip{.planes = {{.normal = {0, 0, 1}}, HalfSpace{}}};
  });
}

TEST_F(BadScenes, with_numbers_that_are_no_enumerators) {
  for (const int number : {-1, 5, 99}) {
    refuse("Accuracy: found " + std::to_string(number) + "; expected a number from 0 to 4",
           [&](Scene& scene, auto&) { scene.layers[0].method = static_cast<Accuracy>(number); });
    refuse("Light::kind: found " + std::to_string(number) + "; expected a number from 0 to 2",
           [&](Scene& scene, auto&) { scene.lights[0].kind = static_cast<Light::Kind>(number); });
    refuse("layer 0: Material::normals: found " + std::to_string(number) + "; expected a number from 0 to 1",
           [&](Scene& scene, auto&) { scene.layers[0].material.normals = static_cast<Normals>(number); });
  }
}

TEST_F(BadScenes, drawn_with_bad_options) {
  for (const Size& size : {Size{0, 30}, Size{40, -1}, Size{70000, 30}, Size{40, 65537}})
    refuse("RenderOptions::size: found " + std::to_string(size.width) + " x " + std::to_string(size.height),
           [&](Scene&, RenderOptions& options) { options.size = size; });
  for (const int samples : {0, -1, 65}) {
    refuse("samples", [&](Scene&, RenderOptions& options) { options.max_samples = samples; });
    refuse(std::to_string(samples), [&](Scene&, RenderOptions& options) { options.max_samples = samples; });
  }
  constexpr int most = std::numeric_limits<int>::max();
  for (const Rect& window : {Rect{0, 0, 41, 30}, Rect{-1, 0, 10, 10}, Rect{0, 0, 0, 10}, Rect{39, 29, 1, 2},
                             Rect{most, 0, 2, 1}, Rect{1, 1, most, most}, Rect{5, 5, -1, -1}})
    refuse("window", [&](Scene&, RenderOptions& options) { options.window = window; });
  refuse("error", [](Scene&, RenderOptions& options) { options.channels.error = true; });
  for (const int spacing : {0, 3, 32, -8})
    expect_refused(ErrorCode::usage, "Passes::first_spacing: found " + std::to_string(spacing),
                   [&] { context_.refine(scene_, options_, {.first_spacing = spacing}, picture_); });
  EXPECT_TRUE(bits_of(picture_) == before_);
}

TEST_F(BadScenes, for_a_camera) {
  EXPECT_NO_THROW(fit_camera(Box3{{0, 0, 0}, {1, 1, 1}}, {8, 8}));
  const Box3 box{{0, 0, 0}, {1, 1, 1}};
  expect_refused(ErrorCode::usage, "the box is empty", [] { fit_camera(Box3{{1, 0, 0}, {0, 1, 1}}, {8, 8}); });
  expect_refused(ErrorCode::usage, "", [] { fit_camera(Box3{{nan, 0, 0}, {1, 1, 1}}, {8, 8}); });
  expect_refused(ErrorCode::usage, "", [] { fit_camera(Box3{{0, 0, 0}, {1, infinite, 1}}, {8, 8}); });
  expect_refused(ErrorCode::usage, "expected at least 1 x 1", [&] { fit_camera(box, {0, 8}); });
  for (const View& view :
       {View{.azimuth_deg = nan}, View{.elevation_deg = infinite}, View{.zoom = 0}, View{.zoom = nan},
        View{.vertical_fov_deg = 0}, View{.vertical_fov_deg = 180}, View{.vertical_fov_deg = nan}}) {
    expect_refused(ErrorCode::usage, "", [&] { fit_camera(box, {8, 8}, view); });
    expect_refused(ErrorCode::usage, "", [&] { fit_camera(scene_, {8, 8}, view); });
  }
}

TEST_F(BadScenes, of_methods_and_windows) {
  for (const double step : {0.0, -1.0, 1e5, nan})
    expect_refused(ErrorCode::usage, "Method::sampled: steps of", [&] { Method::sampled(step); });
  for (const Size& size : {Size{0, 5}, Size{5, -1}, Size{std::numeric_limits<int>::max(), 5}, Size{5, 65537}})
    expect_refused(ErrorCode::usage, "expected numbers above 0, and sides of the picture up to 65536",
                   [&] { windows(size); });
  EXPECT_EQ(windows({65536, 65536}, std::numeric_limits<int>::max()).size(), 1U);
  expect_refused(ErrorCode::usage, "in windows of 0", [] { windows({5, 5}, 0); });
}

TEST_F(BadScenes, whose_texture_is_no_file_of_colours) {
  const TemporaryFolder folder;
  gyroid_grid({.file = folder / "grid.rho"});
  write_file(folder / "text.txt", "no colours");
  expect_refused(ErrorCode::invalid, "grid.rho", [&] { Texture::open(folder / "grid.rho"); });
  expect_refused(ErrorCode::unsupported, "text.txt: is not a packed file", [&] { Texture::open(folder / "text.txt"); });
  expect_refused(ErrorCode::unreadable, "none.rho", [&] { Texture::open(folder / "none.rho"); });
}

TEST_F(BadScenes, to_choose_a_method_for) {
  const auto choose = [&](std::size_t layer, const Goal& goal, Scene scene) {
    return [=] { choose_method(scene, layer, {40, 30}, goal); };
  };
  expect_refused(ErrorCode::usage, "Goal: no numbers", choose(0, {}, scene_));
  for (const double bad : {0.0, -1.0, nan, infinite}) {
    expect_refused(ErrorCode::usage, "Goal::max_error: found", choose(0, {.max_error = bad}, scene_));
    expect_refused(ErrorCode::usage, "Goal::budget_ms: found", choose(0, {.budget_ms = bad}, scene_));
  }
  expect_refused(ErrorCode::usage, "choose_method: layer 1 of 1", choose(1, {.max_error = 0.1}, scene_));
  scene_.layers[0].show = Slice{};
  expect_refused(ErrorCode::usage, "layer 0 is neither an isosurface nor a projection",
                 choose(0, {.max_error = 0.1}, scene_));
  scene_.camera.reset();
  expect_refused(ErrorCode::usage, "Scene::camera: not set", choose(0, {.max_error = 0.1}, scene_));
}

TEST_F(BadScenes, to_check) {
  EXPECT_EQ(self_check(scene_, picture_, {.pixels = 50, .threads = 100000}).random.missed, 0U);
  expect_refused(ErrorCode::usage, "the picture is empty or a window", [&] { self_check(scene_, {}); });
  RenderOptions options = options_;
  options.window = Rect{0, 0, 32, 30};
  expect_refused(ErrorCode::usage, "the picture is empty or a window",
                 [&] { self_check(scene_, rendered(scene_, options)); });
  expect_refused(ErrorCode::usage, "no channel `depth`", [&] {
    self_check(scene_, rendered(scene_, {.size = {40, 30}}));
  });
  expect_refused(ErrorCode::usage, "SelfCheckOptions::pixels: found 0",
                 [&] { self_check(scene_, picture_, {.pixels = 0}); });
  Scene projection = scene_;
  projection.layers[0].show = MaximumProjection{};
  expect_refused(ErrorCode::usage, "no channel `value`", [&] { self_check(projection, picture_); });
  scene_.layers.push_back(scene_.layers[0]);
  scene_.layers[0].material.opacity = 0.5;
  expect_refused(ErrorCode::usage, "self_check: ", [&] { self_check(scene_, picture_); });
  scene_.layers = {{.data = octahedron(), .show = Triangles{}}};
  expect_refused(ErrorCode::usage, "self_check: ", [&] { self_check(scene_, picture_); });
}

TEST(Accuracies, are_chosen_and_checked) {
  Scene scene = certified_scene(gyroid_grid(), 0.2, {64, 48});
  const MethodChoice choice = choose_method(scene, 0, {64, 48}, {.max_error = 1e-3});
  EXPECT_TRUE(choice.meets_goal);
  EXPECT_LE(choice.error, 1e-3);
  EXPECT_FALSE(choice.sentence.empty());
  const RenderOptions options{.size = {64, 48}, .channels = {.depth = true, .error = true}};
  const SelfCheck check = self_check(scene, rendered(scene, options), {.pixels = 100});
  EXPECT_EQ(check.broken, "");
  EXPECT_NE(check.promise, "");
  EXPECT_GT(check.edges.shown, 0U);
  EXPECT_EQ(check.random.pixels, 100U);
  EXPECT_EQ(check.random.beyond_bound + check.random.missed + check.random.false_hits, 0U);
  // A picture of another isovalue does not pass.
  Scene other = certified_scene(scene.layers[0].data, 0.4, {64, 48});
  other.camera = scene.camera;
  EXPECT_NE(self_check(scene, rendered(other, options), {.pixels = 100}).broken, "");
}

}  // namespace
}  // namespace rhoray::tests

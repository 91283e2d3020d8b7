// The library and the program draw the same pixels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

/// Packs the data once for all tests.
class SameBytes : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    gyroid_grid({.file = *folder_ / "grid.rho"});
    ball_mesh(6, {.file = *folder_ / "mesh.rho"});
    octahedron({.file = *folder_ / "octahedron.rho"});
    const Samples<std::int16_t> samples = samples_of<std::int16_t>(
        14, 12, 10, [](auto i, auto j, auto k) { return 100 * (i - 6) * (j - 6) + 30 * k * k; });
    GridArrays grid{.fields = {samples.field("saddle")}};
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < 14 - 2 * axis; ++i)
        grid.positions[axis].push_back(0.5 * static_cast<double>(i) + 0.04 * static_cast<double>(i * i));
    pack(grid, AxisOrder::zyx, {.file = *folder_ / "rectilinear.rho"});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static Dataset opened(std::string_view name) { return Dataset::open(*folder_ / name); }
  static const TemporaryFolder& folder() { return *folder_; }

  /// Compares the library's picture with that which the program makes of the scene's document, and
  /// with that which the library makes of it.
  static void expect_same_pixels(Scene scene, const RenderOptions& options) {
    if (!scene.camera) scene.camera = fit_camera(scene, options.size, {.azimuth_deg = 55, .elevation_deg = 25});
    const Picture picture = rendered(scene, options);
    const SceneDocument document = to_document(scene, options);
    EXPECT_THAT(document.warnings(), testing::IsEmpty());
    const PngPixels drawn = drawn_by_program(document.json(), folder().path());
    EXPECT_EQ(drawn.width, options.size.width);
    EXPECT_EQ(drawn.height, options.size.height);
    EXPECT_EQ(drawn.channels, picture.srgb8_channels());
    EXPECT_TRUE(drawn.bytes == srgb_of(picture)) << document.json();
    const ResolvedScene again = resolve(document, files_in("/"));
    EXPECT_TRUE(bits_of(rendered(again.scene, options)) == bits_of(picture)) << document.json();
    EXPECT_EQ(again.options.size, options.size);
    EXPECT_EQ(again.options.max_samples, options.max_samples);
    EXPECT_EQ(to_document(again.scene, again.options).json(), document.json());
  }

 private:
  static inline TemporaryFolder* folder_ = nullptr;
};

constexpr Size size{96, 64};

TEST_F(SameBytes, of_an_isosurface_of_a_grid_at_every_accuracy) {
  for (const Accuracy accuracy :
       {Accuracy::preview, Accuracy::float32, Accuracy::float64, Accuracy::certified, Accuracy::exact})
    expect_same_pixels({.layers = {{.data = opened("grid.rho"), .show = Isosurface{0.2}, .method = accuracy}}},
                       {.size = size});
}

TEST_F(SameBytes, of_other_methods_and_of_the_default) {
  const Dataset grid = opened("grid.rho");
  for (const std::optional<Method>& method :
       {std::optional<Method>(), std::optional(Method::sampled(0.25)), std::optional(Method::sampled(0.5, true)),
        std::optional(Method::paper())})
    expect_same_pixels({.layers = {{.data = grid, .show = Isosurface{-0.1}, .method = method}}}, {.size = size});
}

TEST_F(SameBytes, of_a_rectilinear_grid) {
  expect_same_pixels({.layers = {{.data = opened("rectilinear.rho"), .show = Isosurface{500}}}},
                     {.size = size, .max_samples = 8});
}

TEST_F(SameBytes, of_a_mesh_coloured_by_another_field) {
  Scene scene{.layers = {{.data = opened("mesh.rho"),
                          .show = Isosurface{0.7},
                          .field = "radius",
                          .material = {.color_by = FieldColors{"x", {.colormap = "coolwarm", .levels = 5}},
                                       .normals = Normals::smooth}}}};
  expect_same_pixels(scene, {.size = size, .max_samples = 4});
  scene.layers[0].material = {.color_by = FieldColors{"part", {.range = Interval{0, 3}}}};
  expect_same_pixels(scene, {.size = size});
}

TEST_F(SameBytes, of_the_boundary_of_a_mesh_and_of_a_part_of_it) {
  const Dataset mesh = opened("mesh.rho");
  expect_same_pixels({.layers = {{.data = mesh.boundary(), .show = Triangles{}}}}, {.size = size, .max_samples = 16});
  expect_same_pixels({.layers = {{.data = mesh.boundary("part", 2), .show = Triangles{}}}}, {.size = size});
  expect_same_pixels(
      {.layers = {{.data = mesh.boundary("part", 1), .show = Triangles{}, .material = {.color = {1, 0, 0}}},
                  {.data = mesh.boundary("part", 2), .show = Triangles{}}}},
      {.size = size});
}

TEST_F(SameBytes, of_triangles) {
  expect_same_pixels({.layers = {{.data = opened("octahedron.rho"), .show = Triangles{}}}}, {.size = size});
}

TEST_F(SameBytes, of_projections) {
  expect_same_pixels({.layers = {{.data = opened("grid.rho"), .show = MaximumProjection{}}}}, {.size = size});
  expect_same_pixels(
      {.layers = {{.data = opened("mesh.rho"), .show = MaximumProjection{{.range = Interval{0.5, 1.5}}}}},
       .background = std::nullopt},
      {.size = size});
}

TEST_F(SameBytes, of_a_texture) {
  const std::string colors = RHORAY_SOURCE_DIR "/tests/formats/released/1.4-colors.rho";
  const Samples<float> samples = gyroid_samples();
  pack({.fields = {samples.field("gyroid")}, .spacing = {0.05, 0.1, 0.4}, .origin = {0, -2.25, 2.5}}, AxisOrder::zyx,
       {.file = folder() / "textured.rho"});
  Scene scene{.layers = {{.data = opened("textured.rho"), .show = Isosurface{0.2}}}};
  scene.camera = fit_camera(scene, size);
  const RenderOptions options{.size = size};
  std::string document = to_document(scene, options).json();
  const Picture plain = rendered(scene, options);
  scene.layers[0].material.texture = Texture::open(colors);
  const Picture textured = rendered(scene, options);
  EXPECT_TRUE(bits_of(textured) != bits_of(plain));
  expect_refused(ErrorCode::usage, "layer 0 has a texture, which a document names by a file",
                 [&] { to_document(scene, options); });
  const std::string of_data = R"("data":{)", of_layer = R"("layers":[{)";
  document.insert(document.find(of_data) + of_data.size(), R"("colors":{"file":")" + colors + R"("},)");
  document.insert(document.find(of_layer) + of_layer.size(), R"("texture":"colors",)");
  EXPECT_TRUE(drawn_by_program(document, folder().path()).bytes == srgb_of(textured)) << document;
  scene.layers[0].material.color_by = FieldColors{"gyroid", {}};
  expect_refused(ErrorCode::usage, "layer 0: a texture, " + colors + ", and colours by 'gyroid'",
                 [&] { rendered(scene, options); });
}

TEST_F(SameBytes, of_slices) {
  const HalfSpace plane{.point = {0, 5, 5}, .normal = {1, 2, -1}};
  expect_same_pixels({.layers = {{.data = opened("grid.rho"), .show = Slice{.plane = plane}},
                                 {.data = opened("grid.rho"),
                                  .show = Slice{.plane = {.point = {0, 0, 6}, .normal = {0, 0, 1}},
                                                .colors = {.colormap = "magma_r"},
                                                .threshold = Interval{-0.5, 0.5},
                                                .is_lit = true}}}},
                     {.size = size});
}

TEST_F(SameBytes, of_transparent_layers_with_lights_shadows_occlusion_fog_and_clipping) {
  Scene scene{
      .layers =
          {{.data = opened("grid.rho"), .show = Isosurface{0.6}, .material = {.color = {0.8, 0.1, 0.1}}},
           {.data = opened("grid.rho"),
            .show = Isosurface{0.1},
            .material = {.color = {0.1, 0.3, 0.8}, .ambient = 0.3, .specular = 0.7, .shininess = 5, .opacity = 0.4},
            .is_clipped = false},
           {.data = opened("octahedron.rho"), .show = Triangles{}, .material = {.opacity = 0.5}}},
      .lights =
          {{.color = {0.3, 0.3, 0.3}},
           {.kind = Light::Kind::directional, .place = {1, -2, 3}, .casts_shadows = true, .size = 4, .samples = 4},
           {.kind = Light::Kind::point, .place = {9, -9, 20}, .color = {0, 0.5, 0}, .casts_shadows = true}},
      .occlusion = {.samples = 4, .radius = 3},
      .fog = Fog{.color = {0.5, 0.5, 0.6}, .range = {20, 60}},
      .clip = Clip{.box = Box3{{-2, 2, 3}, {7, 9, 11}}, .planes = {{.point = {0, 5, 0}, .normal = {0.2, 1, 0}}}},
      .background = Vec3{0.2, 0.3, 0.1}};
  expect_same_pixels(scene, {.size = size, .max_samples = 4});
  scene.clip->is_inverted = true;
  scene.camera = fit_camera(scene, size, {.azimuth_deg = -20, .zoom = 1.5, .is_orthographic = true});
  expect_same_pixels(scene, {.size = size});
}

/// Small documents in the manner of data/scenes. They leave open what the program chooses.
TEST_F(SameBytes, of_documents_that_leave_choices_open) {
  const char* const documents[] = {
      R"({"data": {"g": {"file": "grid.rho"}}, "layers": [{"type": "isosurface"}], "image": {"size": [80, 60]}})",
      R"({"data": {"g": {"file": "grid.rho"}}, "layers": [{"type": "isosurface", "isovalue": ["p20", 0, "p80"]}],
          "image": {"size": [80, 60]}})",
      R"({"data": {"g": {"file": "grid.rho"}, "m": {"file": "mesh.rho", "field": "x"}}, "style": "paper",
          "layers": [{"type": "isosurface", "data": "m", "isovalue": 0.1}, {"type": "boundary", "data": "m", "opacity": 0.3},
                     {"type": "slice", "data": "g", "axis": "z"}], "image": {"size": [80, 60]}})",
      R"({"data": {"m": {"file": "mesh.rho", "field": "part", "label": 1}}, "layers": [{"type": "boundary"}],
          "camera": {"view": "-y", "zoom": 1.2}, "image": {"size": [70, 50], "antialias": 16}})",
      R"({"data": {"g": {"file": "rectilinear.rho"}}, "layers": [{"type": "mip", "colormap": "inferno"}],
          "accuracy": "certified", "image": {"size": [80, 60]}})",
      R"({"data": {"g": {"file": "grid.rho"}}, "style": "presentation",
          "layers": [{"type": "isosurface", "isovalue": "p70"}, {"type": "isosurface", "isovalue": 99}],
          "clip": {"planes": [{"point": [0, 5, 5], "normal": [0, 1, 0.5]}]}, "image": {"size": [80, 60]}})"};
  for (const char* const text : documents) {
    const PngPixels drawn = drawn_by_program(text, folder().path());
    const ResolvedScene resolved = resolve(SceneDocument::read(folder() / "drawn.json"), files_in(folder().path()));
    EXPECT_EQ(resolved.options.size, (Size{drawn.width, drawn.height}));
    const Picture picture = rendered(resolved.scene, resolved.options);
    EXPECT_TRUE(srgb_of(picture) == drawn.bytes) << text;
  }
}

TEST_F(SameBytes, in_a_png_file) {
  const Scene scene = certified_scene(opened("grid.rho"), 0, size);
  const Picture picture = rendered(scene, {.size = size});
  picture.save_png(folder() / "saved.png");
  EXPECT_TRUE(read_png(folder() / "saved.png").bytes == srgb_of(picture));
  expect_refused(ErrorCode::usage, "saved.png", [&] { picture.save_png(folder() / "saved.png"); });
  picture.save_png(folder() / "saved.png", true);
  expect_refused(ErrorCode::usage, "the picture is empty", [&] { Picture().save_png(folder() / "empty.png"); });
  EXPECT_FALSE(std::filesystem::exists(folder() / "empty.png"));
}

TEST_F(SameBytes, of_srgb_need_room_for_every_byte) {
  const Picture picture = rendered(certified_scene(opened("grid.rho"), 0, size), {.size = size});
  std::vector<std::uint8_t> bytes(3 * 96 * 64 - 1);
  expect_refused(ErrorCode::usage, "found room for 18431 bytes; expected 18432", [&] { picture.to_srgb8(bytes); });
}

}  // namespace
}  // namespace rhoray::tests

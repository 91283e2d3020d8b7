#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "render/document.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;
using Json = nlohmann::ordered_json;

constexpr const char* ball_scene = R"({
  "data": {"data": {"file": "ball.rho"}},
  "layers": [{"type": "isosurface", "isovalue": "p90", "color": "#336699", "specular": 0.1, "shininess": 12, "ambient": 0.3}],
  "camera": {"view": "-x", "zoom": 1.7},
  "image": {"size": [40, 30], "background": [0.1, 0.2, 0.3]}
})";

const std::vector<std::string> ball_options{
    "--iso",       "p90", "--surface-color", "#336699", "--specular",   "0.1",
    "--shininess", "12",  "--ambient",       "0.3",     "--view",       "-x",
    "--zoom",      "1.7", "--size",          "40x30",   "--background", "0.1,0.2,0.3"};

std::vector<std::string> words(std::vector<std::string> first, const std::vector<std::string>& more) {
  first.insert(first.end(), more.begin(), more.end());
  return first;
}

/// Whether --explain reports an effect of the first layer as called for.
bool is_called_for(const Json& explanation, const std::string& effect) {
  for (const Json& row : explanation["layers"][0]["effects"])
    if (row["effect"] == effect) return row["called_for"];
  throw std::runtime_error("no effect " + effect);
}

std::string metadata(const std::filesystem::path& picture, const std::string& name) {
  const auto file = OIIO::ImageInput::open(picture.string());
  if (!file) throw std::runtime_error(OIIO::geterror());
  return file->spec().get_string_attribute(name);
}

std::vector<std::uint8_t> pixels(const std::filesystem::path& picture) {
  const auto file = OIIO::ImageInput::open(picture.string());
  if (!file) throw std::runtime_error(OIIO::geterror());
  const OIIO::ImageSpec& spec = file->spec();
  std::vector<std::uint8_t> bytes(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
  if (!file->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, bytes.data()))
    throw std::runtime_error(file->geterror());
  return bytes;
}

TEST(SceneCommand, draws_the_picture_that_options_draw) {
  const Workbench bench;
  bench.make_ball();
  write_file(bench / "ball.json", ball_scene);
  const RunResult options = bench.rhoray(words({"render", "ball.rho", "-o", "p.png"}, ball_options));
  ASSERT_EQ(options.exit_code, 0) << options.err;
  const std::string by_options = read_file(bench / "p.png");
  std::filesystem::remove(bench / "p.png");
  const RunResult document = bench.rhoray({"render", "ball.json", "-o", "p.png"});
  ASSERT_EQ(document.exit_code, 0) << document.err;
  EXPECT_TRUE(read_file(bench / "p.png") == by_options) << "pixels and metadata are the same, byte for byte";
  EXPECT_EQ(line_after(document.err, "reproduce: "), line_after(options.err, "reproduce: "));
}

TEST(SceneCommand, is_known_by_its_name_its_content_or_as_text) {
  const Workbench bench;
  bench.make_ball();
  write_file(bench / "ball.json", ball_scene);
  write_file(bench / "ball.scene", std::string("\n ") + ball_scene);
  ASSERT_EQ(bench.rhoray({"render", "ball.json"}).exit_code, 0);
  const std::string first = read_file(bench / "ball.png");
  ASSERT_EQ(bench.rhoray({"render", "ball.scene", "--force"}).exit_code, 0);
  EXPECT_TRUE(read_file(bench / "ball.png") == first);
  ASSERT_EQ(bench.rhoray({"render", ball_scene, "-o", "ball.png", "--force"}).exit_code, 0);
  EXPECT_TRUE(read_file(bench / "ball.png") == first);
  EXPECT_THAT(bench.rhoray({"render", ball_scene}).err, HasSubstr("name the picture with -o"));
}

TEST(SceneCommand, finds_files_beside_the_document) {
  const Workbench bench;
  bench.make_ball();
  std::filesystem::create_directory(bench / "scenes");
  std::filesystem::rename(bench / "ball.rho", bench / "scenes/ball.rho");
  write_file(bench / "scenes/ball.json", ball_scene);
  const RunResult result = bench.rhoray({"render", "scenes/ball.json", "-o", "ball.png"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(line_after(result.err, "reproduce: "), HasSubstr("render scenes/ball.rho"));
}

TEST(SceneCommand, takes_size_accuracy_and_camera_from_options_beside_a_document) {
  const Workbench bench;
  bench.make_ball();
  write_file(bench / "ball.json", ball_scene);
  const auto scene = [&](const std::vector<std::string>& options) {
    const RunResult result = bench.rhoray(words({"render", "ball.json", "--print-scene"}, options));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(result.out);
  };
  const Json plain = scene({});
  EXPECT_EQ(plain["layers"][0]["accuracy"], "float");
  const Json other = scene({"--size", "8x6", "--accuracy", "exact", "--view", "+z", "--background", "0,0,0"});
  EXPECT_EQ(other["image"]["size"], Json({8, 6}));
  EXPECT_EQ(other["image"]["background"], Json({0.0, 0.0, 0.0}));
  EXPECT_EQ(other["layers"][0]["accuracy"], "exact");
  EXPECT_EQ(other["camera"]["up"], Json({0.0, 1.0, 0.0}));
  EXPECT_EQ(other["camera"]["fov"], plain["camera"]["fov"]) << "the document's zoom stays";

  write_file(bench / "aimed.json", plain.dump());
  const RunResult turned = bench.rhoray({"render", "aimed.json", "--view", "+x", "--print-scene"});
  EXPECT_NE(Json::parse(turned.out)["camera"]["position"], plain["camera"]["position"])
      << "a view beside a document replaces its place of the eye";
  const RunResult refused = bench.rhoray({"render", "ball.json", "--iso", "3", "-o", "x.png"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--iso: not allowed with the scene ball.json"));
  EXPECT_FALSE(std::filesystem::exists(bench / "x.png"));
}

TEST(SceneCommand, keeps_the_scene_in_the_picture_and_says_it_in_json) {
  const Workbench bench;
  bench.make_ball();
  std::filesystem::create_directory(bench / "pictures");
  const RunResult first = bench.rhoray(words({"render", "ball.rho", "-o", "pictures/p.png", "--json"}, ball_options));
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const std::string kept = metadata(bench / "pictures/p.png", "rhoray:scene");
  EXPECT_EQ(Json::parse(kept)["data"]["data"]["file"], "../ball.rho") << "seen from the picture";
  const Json told = Json::parse(first.out)["scene"];
  EXPECT_EQ(told["data"]["data"]["file"], "ball.rho");
  EXPECT_EQ(told["layers"], Json::parse(kept)["layers"]);

  const std::string bytes = read_file(bench / "pictures/p.png");
  write_file(bench / "pictures/kept.json", kept);
  ASSERT_EQ(bench.rhoray({"render", "pictures/kept.json", "-o", "pictures/again.exr"}).exit_code, 0);
  ASSERT_EQ(bench.rhoray(words({"render", "ball.rho", "-o", "pictures/first.exr"}, ball_options)).exit_code, 0);
  const auto pixels = [&](const char* name) {
    const auto file = OIIO::ImageInput::open((bench / name).string());
    std::vector<float> values(40 * 30 * 4);
    EXPECT_TRUE(file->read_image(0, 0, 0, 4, OIIO::TypeDesc::FLOAT, values.data()));
    return values;
  };
  EXPECT_EQ(pixels("pictures/again.exr"), pixels("pictures/first.exr"));
}

TEST(SceneCommand, draws_several_layers_of_several_files_and_ends_with_a_command_that_draws_them_again) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  write_file(bench / "two.json", R"({"data": {"b": {"file": "ball.rho"}, "x": {"file": "box.rho", "field": "length"}},
    "layers": [{"type": "isosurface", "data": "b", "isovalue": [60, "p99"], "opacity": 0.5},
               {"type": "isosurface", "data": "x", "isovalue": 0.5}], "image": {"size": [40, 30]}})");
  for (const std::vector<std::string>& look :
       {std::vector<std::string>{"two.json"},
        {"ball.rho", "--iso", "60,120,9000", "--opacity", "0.3", "--size", "40x30"}}) {
    SCOPED_TRACE(look[0]);
    const RunResult first = bench.rhoray(words({"render", "-o", "p.png"}, look));
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const std::string bytes = read_file(bench / "p.png"), command = line_after(first.err, "reproduce: ");
    EXPECT_THAT(command, testing::StartsWith("rhoray render '{\"data\":"));
    std::filesystem::remove(bench / "p.png");
    const RunResult again = bench.shell(command);
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_TRUE(read_file(bench / "p.png") == bytes);
    EXPECT_EQ(line_after(again.err, "reproduce: "), command);
    std::filesystem::remove(bench / "p.png");
  }
}

TEST(SceneCommand, draws_nothing_of_a_surface_that_holds_back_no_light) {
  const Workbench bench;
  bench.make_ball();
  const RunResult result = bench.rhoray({"render", "ball.rho", "--opacity", "0", "--size", "8x8", "-o", "p.png"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("the picture is empty"));
}

TEST(SceneCommand, reads_the_documents_that_are_published) {
  const Workbench bench;
  bench.make_ball();
  std::filesystem::create_directories(bench / "scenes");
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(RHORAY_SOURCE_DIR "/data/scenes")) {
    const std::filesystem::path name = entry.path().filename();
    if (name.extension() != ".json" || name == "scene.schema.json") continue;
    SCOPED_TRACE(name);
    std::filesystem::copy_file(entry.path(), bench / ("scenes/" + name.string()));
    const Json scene = Json::parse(read_file(entry.path()));
    for (const Json& data : scene["data"]) {
      const std::filesystem::path file = bench.path() / "scenes" / data["file"].get<std::string>();
      std::filesystem::create_directories(file.lexically_normal().parent_path());
      std::filesystem::copy_file(bench / "ball.rho", file.lexically_normal(),
                                 std::filesystem::copy_options::skip_existing);
    }
    const render::SceneDocument document = render::read_scene(bench / ("scenes/" + name.string()));
    EXPECT_TRUE(document.warnings.empty()) << document.warnings.front();
    ++count;
  }
  EXPECT_GE(count, 8);
}

TEST(SceneCommand, warns_of_unknown_keys_and_draws) {
  const Workbench bench;
  bench.make_ball();
  write_file(
      bench / "w.json",
      R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip"}], "image": {"size": [8, 8], "sise": 3}})");
  const RunResult result = bench.rhoray({"render", "w.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(line_after(result.err, "warning: "), "w.json: /image/sise: unknown key, ignored; did you mean size?");
}

TEST(SceneCommand, explains_each_layer_and_effect_without_drawing) {
  const Workbench bench;
  bench.make_ball();
  write_file(bench / "e.json", R"({"data": {"b": {"file": "ball.rho"}, "box": {"file": "ball.raw"}},
    "layers": [{"type": "isosurface", "data": "b", "isovalue": [100, 9000], "specular": 0, "accuracy": "double"},
               {"type": "mip", "data": "b"}, {"type": "mip", "data": "box", "visible": false}]})");
  const RunResult result = bench.rhoray({"render", "e.json", "--explain"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* line :
       {"layer 0: isosurface 100 of 'ball' in ball.rho\n", "  method double (requested), one ray at a time\n",
        "  diffuse: a surface is lit\n", "  no specular: specular is 0\n", "layer 1: largest values from 0.0208",
        "  intensity: a projection shows values", "isovalue 9000 is outside the range",
        "/layers/2: not traced: \"visible\" is false\n",
        "data \"box\": ball.raw is not opened; no visible layer uses it\n"})
    EXPECT_THAT(result.out, HasSubstr(line));
  EXPECT_FALSE(std::filesystem::exists(bench / "e.png"));
  const Json json = Json::parse(bench.rhoray({"render", "e.json", "--explain", "--json"}).out);
  EXPECT_FALSE(is_called_for(json, "specular"));
}

TEST(SceneCommand, explains_the_kernels_that_are_then_taken) {
  const Workbench bench;
  bench.make_ball();
  for (const char* accuracy : {"float", "double", "certified"})
    for (const char* mode : {"iso", "mip"}) {
      SCOPED_TRACE(concat(accuracy, " ", mode));
      const std::vector<std::string> look{"render", "ball.rho", "--mode", mode,         "--accuracy", accuracy,
                                          "--size", "64x64",    "--json", "--progress", "none"};
      const Json told = Json::parse(bench.rhoray(words(look, {"--explain"})).out);
      const Json drawn = Json::parse(bench.rhoray(words(look, {"-o", "k.png", "--force"})).out);
      EXPECT_EQ(told["layers"][0]["kernel"], drawn["statistics"]["machine"]);
      EXPECT_EQ(is_called_for(told, "specular"), drawn["statistics"]["highlights_shaded"].get<int>() > 0);
    }
}

TEST(SceneCommand, explains_the_effects_that_are_then_counted) {
  const Workbench bench;
  bench.make_box();
  for (const std::vector<std::string>& look : {std::vector<std::string>{"--specular", "0"},
                                               {"--normals", "smooth"},
                                               {"--color-by", "height"},
                                               {"--opacity", "0.5"}}) {
    SCOPED_TRACE(look[0]);
    const std::vector<std::string> all =
        words({"render", "box.rho", "--field", "length", "--size", "16x12", "--json"}, look);
    const Json told = Json::parse(bench.rhoray(words(all, {"--explain"})).out);
    const Json counts = Json::parse(bench.rhoray(words(all, {"-o", "p.png", "--force"})).out)["statistics"];
    for (const auto& [effect, counter] : {std::pair{"specular", "highlights_shaded"},
                                          {"smooth normals", "normals_smoothed"},
                                          {"colour by field", "colors_looked_up"},
                                          {"transparency", "rays_through"}})
      EXPECT_EQ(is_called_for(told, effect), counts[counter].get<int>() > 0) << effect;
  }
}

/// A document of the ball with these members in addition to its layer.
std::string ball_with(const std::string& members) {
  return concat(R"({"data": {"data": {"file": "ball.rho"}}, "layers": [{"type": "isosurface", "isovalue": 100}],
    "image": {"size": [40, 30]}, )",
                members, "}");
}

TEST(SceneCommand, lights_as_options_do) {
  const Workbench bench;
  bench.make_ball();
  const struct {
    std::vector<std::string> options;
    const char* members;
  } cases[] = {
      {{"--shadows"}, R"("lights": [{"type": "directional", "azimuth": -30, "elevation": 40, "from": "camera",
         "intensity": 0.9, "shadows": true}, {"type": "directional", "azimuth": 50, "from": "camera",
         "intensity": 0.3}])"},
      {{"--light", "70,10"}, R"("lights": [{"type": "directional", "azimuth": 70, "elevation": 10, "intensity": 0.9},
         {"type": "directional", "azimuth": 50, "from": "camera", "intensity": 0.3}])"},
      {{"--light", "70,10", "--light-size", "8"}, R"("lights": [{"type": "directional", "azimuth": 70, "elevation": 10,
         "intensity": 0.9, "shadows": true, "angular_diameter": 8}, {"type": "directional", "azimuth": 50,
         "from": "camera", "intensity": 0.3}])"},
      {{"--style", "fast"}, R"("style": "fast")"},
      {{"--style", "presentation"}, R"("style": "presentation")"},
      {{"--ao"}, R"("effects": {"ambient_occlusion": {"samples": 16}})"},
      {{"--fog", "30,90"}, R"("effects": {"fog": {"range": [30, 90]}})"}};
  /// Bytes of p.png: the pixels, and the scene and command stored in it.
  const auto picture = [&](const std::vector<std::string>& first, const std::vector<std::string>& more = {}) {
    const RunResult result = bench.rhoray(words(words(first, {"-o", "p.png", "--force"}), more));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_file(bench / "p.png");
  };
  const std::vector<std::string> plain{"render", "ball.rho", "--iso", "100", "--size", "40x30"};
  for (const auto& [options, members] : cases) {
    SCOPED_TRACE(options[0]);
    const std::string by_options = picture(plain, options);
    EXPECT_TRUE(picture({"render", ball_with(members)}) == by_options) << "the same, byte for byte";
    const std::vector<std::uint8_t> lit = pixels(bench / "p.png");
    picture(plain);
    const bool shows = options[0] != "--ao";  // a ball occludes no part of itself
    EXPECT_EQ(lit != pixels(bench / "p.png"), shows);
  }
  // Options beside a document override it.
  const std::string other = ball_with(R"("lights": [], "effects": {"fog": {}, "ambient_occlusion": {"radius": 1}})");
  const std::vector<std::string> all{"--shadows", "--ao", "--fog", "30,90"};
  EXPECT_TRUE(picture({"render", other}, all) == picture(plain, all));
}

TEST(SceneCommand, clips_and_slices_as_options_do) {
  const Workbench bench;
  bench.make_ball();
  const auto picture = [&](const std::vector<std::string>& first) {
    const RunResult result = bench.rhoray(words(first, {"--size", "40x30", "-o", "p.png", "--force"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_file(bench / "p.png");
  };
  const auto document = [](const std::string& layers, const std::string& more = "") {
    return concat(R"({"data": {"data": {"file": "ball.rho"}}, "layers": [)", layers, "]", more, "}");
  };
  const std::string ball = R"({"type": "isosurface", "isovalue": 100})";
  const std::vector<std::string> plain{"render", "ball.rho", "--iso", "100"};
  const std::string whole = picture(plain);
  for (const auto& [options, layers, more] :
       {std::tuple{std::vector<std::string>{"--clip-plane", "12,0,0,1,0,0"}, ball,
                   R"(, "clip": {"planes": [{"point": [12, 0, 0], "normal": [1, 0, 0]}]})"},
        {std::vector<std::string>{"--clip-box", "3,3,3,12,13,14", "--clip-plane", "9,0,0,1,0,1", "--cut-away"}, ball,
         R"(, "clip": {"box": [[3, 3, 3], [12, 13, 14]], "planes": [{"point": [9, 0, 0], "normal": [1, 0, 1]}],
            "keep": "outside"})"},
        {std::vector<std::string>{"--slice", "z=9", "--slice", "y", "--colormap", "gray", "--range", "0,200"},
         R"({"type": "slice", "axis": "z", "position": 9, "colormap": "gray", "range": [0, 200]},
            {"type": "slice", "axis": "y", "colormap": "gray", "range": [0, 200]}, )" +
             ball,
         ""}}) {
    SCOPED_TRACE(options[0]);
    const std::string by_options = picture(words(plain, options));
    EXPECT_TRUE(by_options == picture({"render", document(layers, more)})) << "the same, byte for byte";
    EXPECT_FALSE(by_options == whole);
    // The command stored in the picture reproduces it.
    const Json told = Json::parse(
        bench.rhoray(words(words(plain, options), {"--size", "40x30", "-o", "q.png", "--force", "--json"})).out);
    EXPECT_TRUE(read_file(bench / "q.png") != whole);
    EXPECT_TRUE(picture({"render", told["scene"].dump()}) == by_options);
  }
  // Slices by themselves, and together with a projection.
  EXPECT_TRUE(picture({"render", "ball.rho", "--slice", "8,0,0,2,0,0"}) ==
              picture({"render", document(R"({"type": "slice", "point": [8, 0, 0], "normal": [2, 0, 0]})")}));
  EXPECT_TRUE(picture({"render", "ball.rho", "--slice", "x", "--mode", "mip", "--range", "10,90"}) ==
              picture({"render", document(R"({"type": "slice", "axis": "x"}, {"type": "mip", "range": [10, 90]})")}));
  EXPECT_THAT(bench.rhoray({"render", "ball.rho", "--clip-plane", "0,0,-900,0,0,-1", "-o", "p.png", "--force"}).err,
              HasSubstr("clip: layer 0 is clipped away completely"));
}

TEST(SceneCommand, refuses_regions_and_planes_that_make_no_sense) {
  const Workbench bench;
  bench.make_ball();
  for (const auto& [options, fact] :
       {std::pair{std::vector<std::string>{"--clip-box", "0,0,0,1,1"}, "six finite numbers x0,y0,z0,x1,y1,z1"},
        {std::vector<std::string>{"--clip-box", "0,0,0,1,1,0"}, "six finite numbers x0,y0,z0,x1,y1,z1"},
        {std::vector<std::string>{"--clip-box", "0,0,0,1,1,nan"}, "six finite numbers x0,y0,z0,x1,y1,z1"},
        {std::vector<std::string>{"--clip-plane", "0,0,0,0,0,0"}, "a point, and a normal that is not 0"},
        {std::vector<std::string>{"--clip-plane", "z=4"}, "a point, and a normal that is not 0"},
        {std::vector<std::string>{"--cut-away"}, "no clip region given"},
        {std::vector<std::string>{"--slice", "w=4"}, "an axis and a position such as z=40"},
        {std::vector<std::string>{"--slice", "z="}, "an axis and a position such as z=40"},
        {std::vector<std::string>{"--slice", "z=high"}, "an axis and a position such as z=40"},
        {std::vector<std::string>{"--slice", "1,2,3,0,0,0"}, "an axis and a position such as z=40"},
        {std::vector<std::string>{"--slice", "z", "--specular", "0.5"}, "--specular has no effect on slices"}}) {
    const RunResult result = bench.rhoray(words(words({"render", "ball.rho"}, options), {"-o", "p.png"}));
    EXPECT_EQ(result.exit_code, 2) << options.back();
    EXPECT_THAT(result.err, HasSubstr(fact));
  }
  std::vector<std::string> seven{"render", "ball.rho", "-o", "p.png"};
  for (int i = 0; i < 7; ++i) seven = words(seven, {"--clip-plane", "0,0,0,0,0,1"});
  EXPECT_THAT(bench.rhoray(seven).err, HasSubstr("expected at most 6"));
}

TEST(SceneCommand, counts_what_is_clipped_and_sliced_only_where_it_is_called_for) {
  const Workbench bench;
  bench.make_ball();
  for (const std::vector<std::string>& look : {std::vector<std::string>{"--iso", "100"},
                                               {"--iso", "100", "--clip-plane", "12,0,0,1,0,0"},
                                               {"--slice", "z"},
                                               {"--slice", "z", "--clip-plane", "12,0,0,1,0,0", "--cut-away"}}) {
    SCOPED_TRACE(look.back());
    const std::vector<std::string> all =
        words({"render", "ball.rho", "--style", "fast", "--size", "32x32", "--json"}, look);
    const Json told = Json::parse(bench.rhoray(words(all, {"--explain"})).out);
    const Json counts = Json::parse(bench.rhoray(words(all, {"-o", "p.png", "--force"})).out)["statistics"];
    EXPECT_EQ(is_called_for(told, "clipping"), counts["rays_clipped"].get<int>() > 0);
    EXPECT_EQ(is_called_for(told, "true colours"), counts["slice_lookups"].get<int>() > 0);
  }
  EXPECT_THAT(bench.rhoray({"render", "ball.rho", "--slice", "z=9", "--explain"}).out,
              HasSubstr("layer 0: slice z = 9 of 'ball' in ball.rho\n"));
}

TEST(SceneCommand, refuses_lights_that_make_no_sense) {
  const Workbench bench;
  bench.make_ball();
  for (const auto& [option, text, fact] : {std::tuple{"--light", "30", "elevation from -90 to 90"},
                                           {"--light", "30,91", "elevation from -90 to 90"},
                                           {"--light", "30,up", "a finite number"},
                                           {"--light-size", "181", "0 to 180"},
                                           {"--fog", "9,3", "a below b"}}) {
    const RunResult result = bench.rhoray({"render", "ball.rho", option, text, "-o", "p.png"});
    EXPECT_EQ(result.exit_code, 2) << option << " " << text;
    EXPECT_THAT(result.err, HasSubstr(fact));
  }
}

TEST(SceneCommand, counts_rays_towards_lights_only_where_they_are_called_for) {
  const Workbench bench;
  bench.make_ball();
  for (const std::vector<std::string>& look : {std::vector<std::string>{},
                                               {"--shadows"},
                                               {"--light-size", "5"},
                                               {"--ao"},
                                               {"--light", "40,40"},
                                               {"--fog", "1,200"},
                                               {"--shadows", "--mode", "mip"},
                                               {"--shadows", "--opacity", "0.5"}}) {
    SCOPED_TRACE(look.empty() ? "plain" : look.back());
    const std::vector<std::string> all = words({"render", "ball.rho", "--size", "32x32", "--json"}, look);
    const Json told = Json::parse(bench.rhoray(words(all, {"--explain"})).out);
    const Json counts = Json::parse(bench.rhoray(words(all, {"-o", "p.png", "--force"})).out)["statistics"];
    EXPECT_EQ(is_called_for(told, "shadows"), counts["shadow_rays"].get<int>() > 0);
    EXPECT_EQ(is_called_for(told, "ambient occlusion"), counts["occlusion_rays"].get<int>() > 0);
    EXPECT_EQ(is_called_for(told, "fog"), !look.empty() && look[0] == "--fog");
    EXPECT_EQ(is_called_for(told, "soft shadows"), !look.empty() && look[0] == "--light-size");
    EXPECT_EQ(told["lights"].size(), 2U) << "the key and the fill light";
  }
  EXPECT_THAT(bench.rhoray({"render", "ball.rho", "--light", "90,0", "--shadows", "--explain"}).out,
              HasSubstr("light 0: from (1, 0, 0), colour (0.9, 0.9, 0.9), casts shadows\nlight 1: from ("));
}

TEST(SceneCommand, prints_schema_and_keys_without_a_file) {
  const Workbench bench;
  const RunResult schema = bench.rhoray({"render", "--scene-schema"});
  EXPECT_EQ(schema.exit_code, 0) << schema.err;
  EXPECT_EQ(Json::parse(schema.out)["$schema"], "https://json-schema.org/draft/2020-12/schema");
  EXPECT_THAT(bench.rhoray({"render", "--scene-help"}).out, HasSubstr("| `isovalue` |"));
}

}  // namespace
}  // namespace rhoray::tests

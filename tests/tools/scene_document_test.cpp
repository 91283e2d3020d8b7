#include "render/document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/document/tables.h"
#include "tests/tools/scene_documents.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/report.h"

namespace rhoray::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using tools::Json;

render::ResolvedScene planned(const std::filesystem::path& file) {
  const render::SceneDocument document = render::read_scene(file);
  render::ResolvedScene plan = tools::resolve_layers(document.scene_spec);
  render::aim_camera(document.scene_spec, plan);
  return plan;
}

TEST_F(SceneDocument, shows_several_isovalues_of_several_files) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}, "x": {"file": "box.rho", "field": "length"}},
    "layers": [{"type": "isosurface", "data": "b", "isovalue": [50, "p99", 900], "specular": 0},
               {"type": "mip", "data": "b", "visible": false},
               {"type": "isosurface", "data": "x", "isovalue": 0.5, "color": [0.5, 0.25, 0]}]})");
  const render::ResolvedScene plan = planned(bench() / "s.json");
  ASSERT_EQ(plan.scene.layers.size(), 3U);
  EXPECT_EQ(plan.datasets.size(), 2U);
  EXPECT_EQ(plan.scene.layers[0].isovalue, 50);
  EXPECT_EQ(plan.origins[1].isovalue_from, "percentile 99");
  EXPECT_EQ(plan.scene.layers[2].dataset, 1U);
  EXPECT_EQ(plan.scene.layers[2].material.color, Vec3(0.5, 0.25, 0));
  EXPECT_EQ(plan.scene.layers[1].material.specular, 0);
  EXPECT_NE(plan.scene.layers[0].material.color, plan.scene.layers[1].material.color);
  EXPECT_THAT(plan.notes, ElementsAre(HasSubstr("isovalue 900 is outside the range")));
}

TEST_F(SceneDocument, opens_only_what_is_visible) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}, "t": {"file": "ball.txt"}},
    "layers": [{"type": "mip", "data": "b"}, {"type": "mip", "data": "t", "visible": false}]})");
  EXPECT_EQ(planned(bench() / "s.json").datasets.size(), 1U);
}

TEST_F(SceneDocument, opens_a_texture_once_and_only_where_a_visible_layer_names_it) {
  const auto plan_with = [](const std::string& layers) {
    write_file(bench() / "s.json", concat(R"({"data": {"b": {"file": "ball.rho"}, "p": {"file": "photo.rho"}, )",
                                          R"("t": {"file": "ball.txt"}}, "layers": [)", layers, "]}"));
    return planned(bench() / "s.json");
  };
  const render::ResolvedScene none = plan_with(R"({"type": "isosurface", "data": "b", "isovalue": 100},
    {"type": "isosurface", "data": "b", "isovalue": 90, "texture": "t", "visible": false})");
  EXPECT_EQ(none.textures.size(), 0U);
  const render::ResolvedScene two =
      plan_with(R"({"type": "isosurface", "data": "b", "isovalue": [100, 110], "texture": "p"},
    {"type": "isosurface", "data": "b", "isovalue": 90, "texture": "p"})");
  ASSERT_EQ(two.textures.size(), 1U);
  ASSERT_EQ(two.scene.layers.size(), 3U);
  for (const render::Layer& layer : two.scene.layers)
    EXPECT_EQ(&layer.material.texture->grid(), &two.textures[0].grid());
  EXPECT_THAT(two.notes, testing::IsEmpty());
}

TEST_F(SceneDocument, notes_a_texture_that_lies_elsewhere) {
  const auto notes_of = [](const std::string& origin, double isovalue) {
    const RunResult packed =
        bench().rhoray({"pack", "photo.nrrd", "--color", "--origin", origin, "-o", "moved.rho", "-q", "--force"});
    EXPECT_EQ(packed.exit_code, 0) << packed.err;
    write_file(bench() / "s.json",
               concat(R"({"data": {"b": {"file": "ball.rho"}, "p": {"file": "moved.rho"}}, "layers": [)",
                      R"({"type": "isosurface", "data": "b", "isovalue": )", isovalue, R"(, "texture": "p"}]})"));
    return planned(bench() / "s.json").notes;
  };
  EXPECT_THAT(notes_of("1,1,1", 100), testing::IsEmpty());
  EXPECT_THAT(notes_of("10,1,1", 100), testing::IsEmpty());
  const auto is_told = ElementsAre(
      testing::AllOf(HasSubstr("moved.rho does not overlap layer 0"), HasSubstr("check spacing and origin")));
  EXPECT_THAT(notes_of("100,1,1", 100), is_told);
  // Beside a small surface, but within the data's bounds.
  EXPECT_THAT(notes_of("20,1,1", 230), is_told);
}

TEST_F(SceneDocument, gives_surfaces_without_a_colour_one_each_only_where_there_are_several) {
  const auto colors = [&](const std::string& layers) {
    write_file(bench() / "s.json", with("layers", layers));
    std::vector<Vec3> list;
    for (const render::Layer& layer : planned(bench() / "s.json").scene.layers) list.push_back(layer.material.color);
    return list;
  };
  EXPECT_EQ(colors(R"([{"type": "isosurface", "isovalue": 100}])").at(0), render::Material{}.color);
  std::string layers;
  for (int i = 1; i <= 8; ++i)
    layers += concat(i > 1 ? ", " : "", R"({"type": "isosurface", "isovalue": )", 10 * i, "}");
  const std::vector<Vec3> eight = colors("[" + layers + "]");
  for (std::size_t i = 0; i < eight.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((eight[i] - eight[j]).length(), 0.1) << i << " " << j;
}

TEST_F(SceneDocument, a_resolved_scene_as_a_spec_is_resolved_to_the_same_scene) {
  write_file(bench() / "s.json",
             R"({"data": {"b": {"file": "ball.rho"}, "x": {"file": "box.rho"}, "p": {"file": "photo.rho"}},
    "layers": [{"type": "isosurface", "data": "b", "isovalue": ["auto", 33.3], "method": "sampled:0.25+bisect"},
               {"type": "mip", "data": "x", "clip": false}, {"type": "mip", "data": "x", "range": [0.1, 0.7]},
               {"type": "isosurface", "data": "x", "normals": "smooth", "color_by": "length", "colormap": "gray", "range": [0, 2]},
               {"type": "isosurface", "data": "b", "isovalue": 44, "texture": "p"},
               {"type": "slice", "data": "x", "axis": "z", "position": 0.3, "threshold": [0.1, 0.9], "opacity": 0.8},
               {"type": "slice", "data": "x", "normal": [1, 2, 3], "colormap": "gray", "range": [0.2, 0.3], "lit": true}],
    "lights": [{"type": "directional", "azimuth": 20, "elevation": 30, "from": "camera", "shadows": true},
               {"type": "point", "position": [1, 2, 3], "color": [0.9, 0.7, 0.1], "intensity": 3.3, "radius": 0.25,
                "samples": 9, "shadows": true},
               {"type": "directional", "direction": [1, 2, 3], "shadows": true, "angular_diameter": 0.53},
               {"type": "head", "intensity": 0.3}],
    "effects": {"ambient_occlusion": {"samples": 5}, "fog": {"color": [0.1, 0.2, 0.3]}},
    "clip": {"box": [[0.1, -9, -9], [9, 9, 9.3]], "planes": [{"point": [0.1, 0, 0], "normal": [1, 2, 3]}],
             "keep": "outside"},
    "camera": {"azimuth": 33.3, "elevation": -71.7, "zoom": 1.7, "ortho": true},
    "image": {"size": [40, 30], "channels": ["depth", "cost"], "show": "roots", "hierarchy": false}})");
  const Json first = tools::scene_json(render::to_spec(planned(bench() / "s.json")));
  std::filesystem::create_directory(bench() / "elsewhere");
  write_file(bench() / "elsewhere/t.json",
             tools::scene_json(render::to_spec(planned(bench() / "s.json")), bench() / "elsewhere").dump());
  EXPECT_THAT(read_file(bench() / "elsewhere/t.json"), HasSubstr("\"../ball.rho\""));
  const render::ResolvedScene again = planned(bench() / "elsewhere/t.json");
  EXPECT_EQ(again.frame.width, 40);
  EXPECT_TRUE(again.frame.channels.cost);
  EXPECT_FALSE(again.frame.use_hierarchy);
  EXPECT_EQ(again.scene.lights.at(1).color, Vec3(0.9, 0.7, 0.1) * 3.3);
  EXPECT_EQ(again.scene.lights.at(1).size, 0.25);
  EXPECT_EQ(again.scene.lights.at(1).samples, 9);
  EXPECT_EQ(again.scene.lights.at(2).size, 0.53);
  EXPECT_EQ(again.scene.lights.at(2).samples, 16);
  const std::size_t slices = again.scene.layers.size() - 2;
  EXPECT_EQ(again.scene.layers.at(slices).plane.point.z, 0.3);
  EXPECT_EQ(again.scene.layers.at(slices).threshold, (Interval<double>{0.1, 0.9}));
  EXPECT_EQ(again.scene.layers.at(slices).material.opacity, 0.8);
  EXPECT_FALSE(again.scene.layers.at(slices).material.lit);
  EXPECT_EQ(again.scene.layers.at(slices + 1).plane.normal, Vec3(1, 2, 3));
  EXPECT_EQ(again.scene.layers.at(slices + 1).material.color_by->map, render::ColorMap::gray);
  EXPECT_TRUE(again.scene.layers.at(slices + 1).material.lit);
  EXPECT_EQ(again.scene.clip->box, Box3({0.1, -9, -9}, {9, 9, 9.3}));
  EXPECT_EQ(again.scene.clip->planes.at(0).normal, Vec3(1, 2, 3));
  EXPECT_TRUE(again.scene.clip->cuts_away);
  EXPECT_FALSE(again.scene.layers.at(2).clipped);
  Json second = tools::scene_json(render::to_spec(again));
  second["data"] = first["data"];  // by other paths
  EXPECT_EQ(second.dump(), first.dump());
}

TEST_F(SceneDocument, says_of_what_layers_a_clip_region_leaves_nothing) {
  const auto notes_of = [&](const std::string& clip) {
    write_file(bench() / "s.json", concat(R"({"data": {"b": {"file": "ball.rho"}}, "layers": [
      {"type": "isosurface", "isovalue": 100}, {"type": "mip", "clip": false}], "clip": )",
                                          clip, "}"));
    std::vector<std::string> notes;
    for (const std::string& note : planned(bench() / "s.json").notes) notes.push_back(without_folder(note));
    return notes;
  };
  EXPECT_THAT(notes_of(R"({"box": [[900, 0, 0], [901, 1, 1]]})"),
              ElementsAre("s.json: /clip: layer 0 is clipped away completely"));
  EXPECT_THAT(notes_of(R"({"planes": [{"point": [0, 0, 900], "normal": [0, 0, 1]}]})"),
              ElementsAre("s.json: /clip: layer 0 is clipped away completely"));
  EXPECT_THAT(notes_of(R"({"box": [[-900, -900, -900], [900, 900, 900]], "keep": "outside"})"),
              ElementsAre("s.json: /clip: layer 0 is clipped away completely"));
  EXPECT_THAT(notes_of(R"({"box": [[-900, -900, -900], [900, 900, 900]]})"), ElementsAre());
}

TEST_F(SceneDocument, says_of_slices_that_pass_the_data_by_and_of_a_camera_inside) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [
    {"type": "slice", "axis": "z"}, {"type": "slice", "axis": "z", "position": 900}]})");
  EXPECT_THAT(planned(bench() / "s.json").notes,
              ElementsAre(HasSubstr("layer 1: the slice z = 900 lies outside the data (")));
  const Vec3 middle = planned(bench() / "s.json").scene.layers[0].plane.point;
  write_file(
      bench() / "s.json",
      concat(R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip"}, {"type": "slice", "axis": "x"}],
               "camera": {"position": [)",
             middle.x, ",", middle.y, ",", middle.z, R"(], "target": [900, 0, 0]}})"));
  EXPECT_THAT(planned(bench() / "s.json").notes,
              ElementsAre(testing::EndsWith("ball.rho; rays start inside the data")));
}

TEST_F(SceneDocument, shows_triangles_as_a_layer_of_their_own) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}, "c": {"file": "cube.rho"}},
    "accuracy": "certified",
    "layers": [{"type": "isosurface", "data": "b", "isovalue": 100},
               {"type": "triangles", "data": "c", "normals": "smooth", "opacity": 0.5, "specular": 0},
               {"type": "triangles", "data": "c", "color": [1, 0, 0], "accuracy": "double"}]})");
  const render::ResolvedScene plan = planned(bench() / "s.json");
  ASSERT_EQ(plan.scene.layers.size(), 3U);
  const render::Layer& first = plan.scene.layers[1];
  EXPECT_EQ(first.mode, render::Mode::triangles);
  EXPECT_EQ(first.material.normals, render::Normals::smooth);
  EXPECT_EQ(first.material.opacity, 0.5);
  EXPECT_EQ(first.method, render::method_of(render::Accuracy::float32)) << "triangles have no certified level";
  EXPECT_EQ(plan.scene.layers[2].method, render::method_of(render::Accuracy::float64));
  EXPECT_EQ(plan.scene.layers[2].material.color, Vec3(1, 0, 0));
  EXPECT_NE(first.material.color, plan.scene.layers[0].material.color);
  const Json spelled = tools::scene_json(render::to_spec(plan));
  EXPECT_EQ(spelled["layers"][1]["type"], "triangles");
  EXPECT_FALSE(spelled["layers"][1].contains("isovalue"));
}

TEST_F(SceneDocument, knows_triangles_by_the_older_type_too) {
  write_file(bench() / "s.json", R"({"data": {"c": {"file": "cube.rho"}}, "layers": [{"type": "isosurface"}]})");
  const render::ResolvedScene plan = planned(bench() / "s.json");
  EXPECT_EQ(plan.scene.layers.at(0).mode, render::Mode::triangles);
  EXPECT_EQ(tools::scene_json(render::to_spec(plan))["layers"][0]["type"], "triangles");
}

TEST_F(SceneDocument, notes_lights_that_may_not_be_meant_and_surfaces_that_are_not_traced) {
  const auto notes = [&](const std::string& lights, const std::string& layer = R"("isovalue": 100)",
                         const std::string& camera = R"({"view": "-y"})") {
    write_file(bench() / "s.json", concat(R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "isosurface", )",
                                          layer, "}], \"lights\": ", lights, ", \"camera\": ", camera, "}"));
    std::vector<std::string> said = planned(bench() / "s.json").notes;
    for (std::string& note : said) note = without_folder(note);
    return said;
  };
  const auto point = [](const char* position, const char* more = "") {
    return concat(R"([{"type": "point", "position": )", position, more, "}]");
  };
  // The ball is 23 wide; its isosurface 100 has a radius of 7.3 about (11.5, 11.5, 11.5).
  const auto is_inside = ElementsAre(HasSubstr("light 0 is inside an opaque surface"));
  EXPECT_THAT(notes(point("[11.5, 11.5, 11.5]")), is_inside);
  EXPECT_THAT(notes(point("[9, 12, 15]", R"(, "shadows": true)")), is_inside);
  EXPECT_THAT(notes(point("[11.5, -3, 11.5]")), testing::IsEmpty());
  EXPECT_THAT(notes(point("[11.5, 11.5, 11.5]"), R"("isovalue": 100, "opacity": 0.9)"), testing::IsEmpty())
      << "a clear surface lets it out";
  EXPECT_THAT(notes(point("[11.5, 11.5, 13]"), R"("isovalue": 100)",
                    R"({"position": [11.5, 10, 11.5], "target": [11.5, 11.5, 11.5]})"),
              ElementsAre(HasSubstr("the camera is inside")))
      << "the eye is there too";
  // Looking along +y.
  const auto is_behind = ElementsAre(HasSubstr("light 0 is behind the objects"));
  EXPECT_THAT(notes(R"([{"type": "directional", "direction": [0.05, 1, 0]}])"), is_behind);
  EXPECT_THAT(notes(point("[11.5, 90, 11.5]")), is_behind);
  EXPECT_THAT(notes(R"([{"type": "directional", "direction": [0.5, 1, 0]}])"), testing::IsEmpty());
  EXPECT_THAT(notes(R"([{"type": "directional", "direction": [0, -1, 0]}])"), testing::IsEmpty());
  EXPECT_THAT(notes(R"([{"type": "directional", "direction": [0, -1, 0], "angular_diameter": 3}])"),
              ElementsAre(HasSubstr("light 0 has a size but casts no shadows")));
  EXPECT_THAT(notes("[]"), testing::IsEmpty());
  EXPECT_THAT(notes("[]", R"("isovalue": 100, "ambient": 0)"), ElementsAre(HasSubstr("no light has intensity")));
  EXPECT_THAT(notes(R"([{"type": "head"}])", R"("isovalue": 100, "opacity": 0)"),
              ElementsAre("s.json: /layers/0/opacity is 0; the surface is not traced"));
  EXPECT_THAT(notes(R"([{"type": "head"}])", R"("isovalue": 100, "opacity": 1)"), testing::IsEmpty());
}

TEST_F(SceneDocument, places_lights_by_directions_and_by_angles_from_world_and_camera) {
  const auto direction = [&](const std::string& light, const std::string& camera) {
    write_file(bench() / "s.json", concat(R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "isosurface"}],
      "lights": [{"type": "directional", )",
                                          light, R"(}], "camera": )", camera, "}"));
    return planned(bench() / "s.json").scene.lights.at(0).place;
  };
  const auto is_near = [](const Vec3& a, const Vec3& b) { return (a - b).length() < 1e-12; };
  // From the camera's right, from above, and from the eye itself, seen from +x with z up: right is
  // +y.
  EXPECT_TRUE(is_near(direction(R"("azimuth": 90, "from": "camera")", R"({"view": "+x"})"), {0, 1, 0}));
  EXPECT_TRUE(is_near(direction(R"("elevation": 90, "from": "camera")", R"({"view": "+x"})"), {0, 0, 1}));
  EXPECT_TRUE(is_near(direction(R"("azimuth": 0, "from": "camera")", R"({"view": "+x"})"), {1, 0, 0}));
  EXPECT_TRUE(is_near(direction(R"("azimuth": 90)", R"({"view": "-y"})"), {1, 0, 0}));
  EXPECT_TRUE(is_near(direction(R"("azimuth": 0)", R"({"view": "+x"})"), {0, -1, 0}));
  EXPECT_EQ(direction(R"("direction": [1, 2, 3])", R"({"view": "+x"})"), Vec3(1, 2, 3));
}

TEST_F(SceneDocument, fits_occlusion_and_fog_to_what_is_shown_where_they_say_no_distance) {
  write_file(bench() / "s.json", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip"}],
    "effects": {"ambient_occlusion": {}, "fog": {}}, "camera": {"view": "-y", "ortho": true},
    "image": {"background": [0.25, 0.5, 1]}})");
  const render::ResolvedScene plan = planned(bench() / "s.json");
  const Box3 box = plan.datasets[0].bounds();
  EXPECT_DOUBLE_EQ(plan.scene.occlusion.radius, box.size().length() / 10);
  EXPECT_EQ(plan.scene.occlusion.samples, 16);
  ASSERT_TRUE(plan.scene.fog);
  EXPECT_EQ(plan.scene.fog->color, Vec3(0.25, 0.5, 1));
  const double to_front = box.min.y - plan.scene.camera.position.y;
  EXPECT_NEAR(plan.scene.fog->range.lo, to_front, 1e-9);
  EXPECT_NEAR(plan.scene.fog->range.hi, to_front + 2 * box.size().y, 1e-9);
}

TEST_F(SceneDocument, without_lights_has_a_key_and_a_fill_light_and_no_effects) {
  write_file(bench() / "s.json", with("accuracy", "\"double\""));
  const render::ResolvedScene plan = planned(bench() / "s.json");
  ASSERT_EQ(plan.scene.lights.size(), 2U);
  for (const render::Light& light : plan.scene.lights) {
    EXPECT_EQ(light.kind, render::Light::Kind::directional);
    EXPECT_FALSE(light.casts_shadows);
  }
  EXPECT_NEAR(plan.scene.lights[1].color.x, plan.scene.lights[0].color.x / 3, 1e-15);
  EXPECT_EQ(plan.scene.occlusion.radius, 0);
  EXPECT_FALSE(plan.scene.fog);
  EXPECT_FALSE(tools::scene_json(render::to_spec(plan)).contains("lights"));
  EXPECT_FALSE(tools::scene_json(render::to_spec(plan)).contains("effects"));
  write_file(bench() / "s.json", with("lights", R"([{"type": "head"}, {"type": "head", "intensity": 0}])"));
  EXPECT_THAT(planned(bench() / "s.json").notes, ElementsAre("light 1 has no intensity; it is not traced"));
}

TEST(SceneSchema, is_the_published_one) {
  EXPECT_EQ(read_file(RHORAY_SOURCE_DIR "/data/scenes/scene.schema.json"), render::scene_schema_text())
      << "rhoray render --scene-schema > data/scenes/scene.schema.json";
}

/// Calls a function with every key of objects in a schema.
template <class Act>
void for_each_key(const Json& schema, const Act& act) {
  if (schema.is_object() && schema.contains("properties"))
    for (const auto& [key, value] : schema["properties"].items()) act(key);
  if (schema.is_structured())
    for (const Json& part : schema) for_each_key(part, act);
}

TEST(FuzzDictionary, knows_every_key_of_scene_documents) {
  const std::string words = read_file(RHORAY_SOURCE_DIR "/tests/fuzz/dictionaries/scene.dict");
  for_each_key(Json::parse(render::scene_schema_text()),
               [&](const std::string& key) { EXPECT_THAT(words, HasSubstr(concat("\"\\\"", key, "\\\": \""))); });
}

TEST(SceneReference, has_a_row_for_every_key_of_the_schema) {
  const std::string tables = render::scene_reference();
  std::size_t keys = 0, rows = 0;
  for_each_key(Json::parse(render::scene_schema_text()), [&](const std::string& key) {
    // The types of layers and lights are in the headings of their tables.
    if (key == "type") return;
    ++keys;
    EXPECT_THAT(tables, HasSubstr(concat("\n| `", key, "` | ")));
  });
  for (std::size_t at = tables.find("\n| `"); at != std::string::npos; at = tables.find("\n| `", at + 1)) ++rows;
  EXPECT_EQ(rows, keys);
}

TEST(SceneSchema, knows_every_key_and_nothing_else) {
  const Json schema = Json::parse(render::scene_schema_text());
  for (const auto& row : render::scene_rows()) EXPECT_TRUE(schema["properties"].contains(row.key)) << row.key;
  EXPECT_EQ(schema["required"], Json({"data", "layers"}));
  const Json& kinds = schema["properties"]["layers"]["items"]["oneOf"];
  ASSERT_EQ(kinds.size(), render::layer_kinds().size());
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    EXPECT_EQ(kinds[i]["properties"]["type"]["const"], render::layer_kinds()[i].word);
    EXPECT_EQ(kinds[i]["properties"].size(), render::layer_kinds()[i].rows.size() + 1);
  }
  EXPECT_FALSE(kinds[1]["properties"].contains("isovalue"));
  const Json& lights = schema["properties"]["lights"]["items"]["oneOf"];
  ASSERT_EQ(lights.size(), render::light_kinds().size());
  EXPECT_EQ(lights[2]["required"], Json({"type", "position"}));
  EXPECT_EQ(schema["properties"]["camera"]["properties"]["elevation"]["maximum"], 90);
}

}  // namespace
}  // namespace rhoray::tests

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "preprocess/pack_mesh.h"
#include "tests/tools/workbench.h"
#include "tools/pictures/annotations.h"
#include "tools/rhoray/render/label_layers.h"

namespace rhoray::tests {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// labels.nrrd: 20^3 bytes with the labels 1, 5 and 9 in a background of 0.
/// @param keys  lines of the header, of segments
void make_labels(const Workbench& bench, const std::string& keys = "") {
  std::string text = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 20 20 20\nencoding: raw\n" + keys + "\n";
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i) {
        const bool is_inside = i > 2 && j > 2 && k > 2 && i < 17 && j < 17 && k < 17;
        text += static_cast<char>(!is_inside ? 0 : k < 10 ? 1 : i < 10 ? 5 : 9);
      }
  write_file(bench / "labels.nrrd", text);
}

/// parts.vtu: the unit cube in 4 x 4 x 4 cubes with the cell field 'part', which is 7 in the inner
/// 8 of them, 4 in other cells below x = 1/4, and 0 elsewhere.
/// @param name  of the cell field
preprocess::NeutralMesh mesh_of_parts(bool has_point_field, const std::string& name = "part") {
  preprocess::NeutralMesh mesh = box_mesh({});
  if (has_point_field) add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  preprocess::NeutralField part{.name = name, .unit = {}, .values = {}};
  for (const auto& cell : mesh.cells) {
    Vec3 middle(0, 0, 0);
    for (const std::uint64_t v : cell) middle += 0.25 * to_vec3(mesh.points[v]);
    const Vec3 off = middle - Vec3(0.5, 0.5, 0.5);
    const bool is_inner = std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) < 0.25;
    part.values.push_back(is_inner ? 7 : middle.x < 0.25 ? 4 : 0);
  }
  mesh.cell_fields.push_back(part);
  return mesh;
}
void make_parts(const Workbench& bench, bool has_point_field, const std::string& name = "part") {
  preprocess::export_mesh(mesh_of_parts(has_point_field, name), bench / "parts.vtu", true);
}

/// The legends of the default picture.
std::vector<tools::Legend> legends_of(const std::filesystem::path& file, const std::string& field = "") {
  render::SceneSpec spec;
  spec.data = {{.name = "", .file = file, .field = field}};
  spec.layers = {{.type = render::LayerType::automatic}};
  const render::ResolvedScene plan = tools::resolve_layers(tools::with_label_layers(spec, {}));
  return tools::annotations_of(plan, {}).legends;
}

std::vector<std::string> texts_of(const std::vector<tools::Legend::Entry>& entries) {
  std::vector<std::string> texts;
  for (const tools::Legend::Entry& entry : entries) texts.push_back(entry.text);
  return texts;
}

TEST(LabelLayers, every_label_of_a_segmentation_gets_a_surface) {
  const Workbench bench;
  make_labels(bench);
  const Json shown = bench.drawn({"labels.nrrd"});
  const Json& layers = shown["scene"]["layers"];
  ASSERT_EQ(layers.size(), 3U);
  std::vector<Json> colors;
  for (const Json& layer : layers) {
    EXPECT_EQ(layer["type"], "isosurface");
    EXPECT_EQ(layer["isovalue"], 0.5);
    EXPECT_THAT(colors, Not(testing::Contains(layer["color"])));
    colors.push_back(layer["color"]);
  }
  EXPECT_EQ(shown["scene"]["data"]["label 5"]["label"], 5);
  EXPECT_EQ(shown["scene"]["data"].size(), 3U);
  const RunResult again = bench.shell(shown["reproduce"].get<std::string>() +
                                      " -o again.png && rhoray compare labels.png again.png --fail 0");
  EXPECT_EQ(again.exit_code, 0) << shown["reproduce"] << again.out << again.err;
  EXPECT_THAT(bench.rhoray({"render", "labels.nrrd", "--force"}).err, HasSubstr("holds labels: 1, 5, 9"));
}

TEST(LabelLayers, of_a_segmentation_have_the_names_that_the_file_gives) {
  const Workbench bench;
  make_labels(bench,
              "Segment0_LabelValue:=1\nSegment0_Name:=liver\nSegment3_LabelValue:=9\nSegment3_Name:=b\u00f6se\n");
  ASSERT_EQ(bench.rhoray({"pack", "labels.nrrd", "-o", "labels.rho"}).exit_code, 0);
  const auto legends = legends_of(bench / "labels.rho");
  ASSERT_EQ(legends.size(), 1U);
  EXPECT_THAT(texts_of(legends[0].entries), testing::ElementsAre("liver", "5", "b\u00f6se"));
  EXPECT_THAT(bench.rhoray({"render", "labels.nrrd"}).err,
              HasSubstr("holds labels: 1 (liver), 5, 9 (b\u00f6se); each"));
  for (const char* file : {"labels.nrrd", "labels.rho"}) {
    EXPECT_THAT(bench.rhoray({"info", file}).out, HasSubstr("labels 1 'liver', 9 'b\u00f6se'\n")) << file;
    const Json info = Json::parse(bench.rhoray({"info", file, "--json"}).out);
    EXPECT_EQ(info["fields"][0]["label_names"], (Json{{"1", "liver"}, {"9", "b\u00f6se"}})) << file;
  }
}

TEST(LabelLayers, of_a_mesh_have_the_names_that_the_file_gives) {
  const Workbench bench;
  preprocess::NeutralMesh mesh = mesh_of_parts(true);
  mesh.cell_fields[0].label_names = {{0, "air"}, {7, "iron"}};
  preprocess::pack_mesh(mesh, bench / "parts.rho");
  const auto legends = legends_of(bench / "parts.rho", "part");
  ASSERT_EQ(legends.size(), 1U);
  EXPECT_EQ(legends[0].title, "part");
  EXPECT_THAT(texts_of(legends[0].entries), testing::ElementsAre("air", "4", "iron"));
  EXPECT_THAT(bench.rhoray({"info", "parts.rho"}).out, HasSubstr("labels 0 'air', 7 'iron'\n"));
}

TEST(LabelLayers, many_labels_have_different_colours) {
  const Workbench bench;
  std::string text = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 150 6 6\nencoding: raw\n\n";
  for (int row = 0; row < 36; ++row)
    for (int i = 0; i < 150; ++i) text += static_cast<char>(i / 5);
  write_file(bench / "many.nrrd", text);
  const Json shown = bench.drawn({"many.nrrd"});
  const Json& layers = shown["scene"]["layers"];
  ASSERT_EQ(layers.size(), 29U);
  for (std::size_t a = 0; a < layers.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      double distance = 0;
      for (std::size_t c = 0; c < 3; ++c)
        distance += std::abs(layers[a]["color"][c].get<double>() - layers[b]["color"][c].get<double>());
      EXPECT_GT(distance, 0.1) << a << ' ' << b;
    }
}

TEST(LabelLayers, an_isovalue_or_a_mode_shows_the_numbers) {
  const Workbench bench;
  make_labels(bench);
  EXPECT_EQ(bench.drawn({"labels.nrrd", "--iso", "3"})["scene"]["layers"].size(), 1U);
  EXPECT_EQ(bench.drawn({"labels.nrrd", "--mode", "iso"})["scene"]["layers"].size(), 1U);
  EXPECT_EQ(bench.drawn({"labels.nrrd", "--mode", "mip"})["scene"]["layers"].size(), 1U);
  bench.make_ball();
  EXPECT_EQ(bench.drawn({"ball.rho"})["scene"]["layers"].size(), 1U);
}

TEST(LabelLayers, labels_that_are_not_there_are_refused) {
  const Workbench bench;
  make_labels(bench);
  bench.make_ball();
  const auto refusal = [&](const std::string& file, const std::string& label) {
    write_file(bench / "s.json", R"({"data": {"d": {"file": ")" + file + R"(", "label": )" + label +
                                     R"(}}, "layers": [{"type": "isosurface", "isovalue": 0.5}]})");
    const RunResult run = bench.rhoray({"render", "s.json"});
    EXPECT_NE(run.exit_code, 0);
    EXPECT_FALSE(std::filesystem::exists(bench / "s.png"));
    return run.err;
  };
  EXPECT_THAT(refusal("labels.nrrd", "4"), HasSubstr("holds the labels 1, 5, 9; expected label 4"));
  EXPECT_THAT(refusal("ball.rho", "4"), HasSubstr("is not a segmentation; expected label 4"));
  EXPECT_THAT(refusal("labels.nrrd", "1.5"), HasSubstr("/data/d/label"));
}

TEST(LabelLayers, every_label_of_a_mesh_gets_its_boundary) {
  const Workbench bench;
  make_parts(bench, true);
  const Json shown = bench.drawn({"parts.vtu", "--field", "part"});
  const Json &scene = shown["scene"], &layers = scene["layers"];
  ASSERT_EQ(layers.size(), 3U);
  std::vector<Json> colors;
  for (const Json& layer : layers) {
    EXPECT_EQ(layer["type"], "boundary");
    EXPECT_FALSE(layer.contains("color_by"));
    EXPECT_THAT(colors, Not(testing::Contains(layer["color"])));
    colors.push_back(layer["color"]);
  }
  EXPECT_EQ(layers[0]["data"], "label 0");
  EXPECT_EQ(layers[0]["opacity"], 0.33) << "hides 7";
  EXPECT_EQ(layers[1]["opacity"], 0.33) << "4 hides 7, too";
  EXPECT_EQ(layers[2]["opacity"], 1);
  EXPECT_EQ(scene["data"].size(), 3U);
  EXPECT_EQ(scene["data"]["label 7"]["label"], 7);
  EXPECT_EQ(scene["data"]["label 7"]["field"], "part");
  EXPECT_EQ(scene["annotations"]["legend"], true);
  const RunResult again = bench.shell(shown["reproduce"].get<std::string>() +
                                      " -o again.png && rhoray compare parts.png again.png --fail 0");
  EXPECT_EQ(again.exit_code, 0) << shown["reproduce"] << again.out << again.err;
  EXPECT_THAT(bench.rhoray({"render", "parts.vtu", "--field", "part", "--force"}).err,
              HasSubstr("'part' holds labels: 0, 4, 7"));
}

TEST(LabelLayers, of_a_mesh_are_shown_where_no_other_field_varies) {
  const Workbench bench;
  make_parts(bench, false);
  EXPECT_EQ(bench.drawn({"parts.vtu"})["scene"]["layers"].size(), 3U) << "the only field";
  make_parts(bench, false, "region");
  EXPECT_EQ(bench.drawn({"parts.vtu"})["scene"]["layers"].size(), 3U) << "beside a distance made by packing";
  make_parts(bench, true);
  const Json height = bench.drawn({"parts.vtu"})["scene"]["layers"];
  ASSERT_EQ(height.size(), 1U);
  EXPECT_EQ(height[0]["color_by"], "height");
}

TEST(LabelLayers, of_a_mesh_give_way_to_other_options) {
  const Workbench bench;
  make_parts(bench, false);
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{{"--color-by", "part"},
                                                                                     {"--mode", "boundary"},
                                                                                     {"--iso", "3"},
                                                                                     {"--mode", "mip"},
                                                                                     {"--accuracy", "exact"}}) {
    std::vector<std::string> all{"parts.vtu", "--context", "0"};
    if (words[0] == "--mode" || words[0] == "--color-by") all = {"parts.vtu"};
    all.insert(all.end(), words.begin(), words.end());
    EXPECT_EQ(bench.drawn(all)["scene"]["layers"].size(), 1U) << words[0];
  }
}

TEST(LabelLayers, of_a_mesh_that_are_not_there_are_refused) {
  const Workbench bench;
  make_parts(bench, true);
  ASSERT_EQ(bench.rhoray({"pack", "parts.vtu"}).exit_code, 0);
  const auto refusal = [&](const std::string& data, const std::string& type) {
    write_file(bench / "s.json",
               R"({"data": {"d": {"file": "parts.rho", )" + data + R"(}}, "layers": [{"type": ")" + type + R"("}]})");
    const RunResult run = bench.rhoray({"render", "s.json"});
    EXPECT_NE(run.exit_code, 0);
    EXPECT_FALSE(std::filesystem::exists(bench / "s.png"));
    return run.err;
  };
  EXPECT_THAT(refusal(R"("field": "part", "label": 5)", "boundary"),
              HasSubstr("/data/d/label: parts.rho: no cell has label 5 in field 'part'"));
  EXPECT_THAT(refusal(R"("label": 4)", "boundary"), HasSubstr("no field 'height' of cells; it has 'part'"));
  EXPECT_THAT(refusal(R"("field": "part", "label": 4)", "isosurface"), HasSubstr("/layers/0/type"));
  EXPECT_THAT(bench.rhoray({"render", "parts.vtu", "--field", "part", "--mode", "boundary"}).err,
              HasSubstr("it is a field of cells: --color-by part shows it"));
}

}  // namespace
}  // namespace rhoray::tests

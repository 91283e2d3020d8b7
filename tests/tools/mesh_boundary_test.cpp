#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

/// What `rhoray render` shows of a mesh: its boundary, and isosurfaces in it.
namespace rhoray::tests {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// cells.vtu: the unit cube with the point field 'height' and the cell field 'layer', 0 to 3
/// upward.
void make_cells_vtu(const Workbench& bench) {
  preprocess::NeutralMesh mesh = box_mesh({});
  add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  preprocess::NeutralField layer{.name = "layer", .unit = {}, .values = {}};
  for (const auto& cell : mesh.cells) {
    double z = 0;
    for (const std::uint64_t v : cell) z += mesh.points[v][2] / 4;
    layer.values.push_back(std::floor(4 * z));
  }
  mesh.cell_fields.push_back(layer);
  preprocess::export_mesh(mesh, bench / "cells.vtu", false);
}

TEST(MeshBoundaryCommand, a_mesh_is_shown_from_outside_in_colours_with_a_bar_and_a_box) {
  const Workbench bench;
  bench.make_box_vtu();
  const Json shown = bench.drawn({"box.vtu"});
  EXPECT_EQ(shown["mode"], "boundary");
  EXPECT_EQ(shown["field"], "height");
  const Json& scene = shown["scene"];
  ASSERT_EQ(scene["layers"].size(), 1U);
  EXPECT_EQ(scene["layers"][0]["type"], "boundary");
  EXPECT_EQ(scene["layers"][0]["color_by"], "height");
  EXPECT_EQ(scene["layers"][0]["normals"], "smooth");
  EXPECT_TRUE(scene["annotations"].contains("colorbar"));
  EXPECT_EQ(scene["annotations"]["box"], true);
  const RunResult again = bench.shell(shown["reproduce"].get<std::string>() +
                                      " -o again.png && rhoray compare box.png "
                                      "again.png --fail 0");
  EXPECT_EQ(again.exit_code, 0) << shown["reproduce"] << again.out << again.err;
}

TEST(MeshBoundaryCommand, an_isosurface_of_a_mesh_has_the_boundary_around_it) {
  const Workbench bench;
  bench.make_box_vtu();
  const Json shown = bench.drawn({"box.vtu", "--iso", "0.5"});
  const Json& layers = shown["scene"]["layers"];
  ASSERT_EQ(layers.size(), 2U);
  EXPECT_EQ(layers[0]["type"], "isosurface");
  EXPECT_EQ(layers[1]["type"], "boundary");
  EXPECT_EQ(layers[1]["opacity"], 0.12);
  EXPECT_FALSE(layers[1].contains("color_by"));
  EXPECT_FALSE(shown["scene"].contains("annotations"));
  EXPECT_THAT(shown["reproduce"].get<std::string>(), HasSubstr("--mode iso --iso 0.5 --context 0.12"));
  const RunResult again = bench.shell(shown["reproduce"].get<std::string>() +
                                      " -o again.png && rhoray compare box.png "
                                      "again.png --fail 0");
  EXPECT_EQ(again.exit_code, 0) << shown["reproduce"] << again.out << again.err;

  for (const auto& [option, value] : {std::pair("--pick", "48,36"), {"--channels", "depth"}})
    EXPECT_EQ(bench.drawn({"box.vtu", "--iso", "0.5", option, value, "-o", "box.exr"})["scene"]["layers"].size(), 1U)
        << option << " tells of the isosurface";
  EXPECT_EQ(bench.drawn({"box.vtu", "--iso", "0.5", "--context", "0"})["scene"]["layers"].size(), 1U);
  EXPECT_EQ(bench.drawn({"box.vtu", "--mode", "iso"})["scene"]["layers"].size(), 1U);
  EXPECT_EQ(bench.drawn({"box.vtu", "--accuracy", "certified"})["scene"]["layers"][0]["type"], "isosurface");
  EXPECT_EQ(bench.drawn({"box.vtu", "--accuracy", "double"})["scene"]["layers"][0]["type"], "boundary");
  EXPECT_EQ(bench.drawn({"box.vtu", "--show", "cost"})["scene"]["layers"][0]["type"], "isosurface");
  EXPECT_EQ(bench.drawn({"box.vtu", "--verify", "50"})["scene"]["layers"][0]["type"], "isosurface");
}

TEST(MeshBoundaryCommand, exr_files_hold_data_and_no_annotations_unasked) {
  const Workbench bench;
  bench.make_box_vtu();
  EXPECT_FALSE(bench.drawn({"box.vtu", "-o", "box.exr"})["scene"].contains("annotations"));
  const Json asked = bench.drawn({"box.vtu", "-o", "box.exr", "--box"})["scene"]["annotations"];
  EXPECT_EQ(asked["box"], true);
  EXPECT_FALSE(asked.contains("colorbar"));
}

TEST(MeshBoundaryCommand, a_plain_boundary_has_no_bar) {
  const Workbench bench;
  bench.make_box_vtu();
  const Json plain = bench.drawn({"box.vtu", "--surface-color", "teal"});
  EXPECT_FALSE(plain["scene"]["layers"][0].contains("color_by"));
  EXPECT_FALSE(plain["scene"].contains("annotations"));
  const Json other = bench.drawn({"box.vtu", "--mode", "boundary", "--color-by", "length"});
  EXPECT_EQ(other["scene"]["layers"][0]["color_by"], "length");
  EXPECT_FALSE(other["scene"].contains("annotations")) << "--mode says what is wanted";
}

TEST(MeshBoundaryCommand, a_mesh_without_fields_is_a_plain_solid) {
  const Workbench bench;
  preprocess::export_mesh(box_mesh({}), bench / "bare.vtu", false);
  const Json shown = bench.drawn({"bare.vtu"});
  EXPECT_EQ(shown["scene"]["layers"][0]["type"], "boundary");
  EXPECT_FALSE(shown["scene"]["layers"][0].contains("color_by"));
  EXPECT_FALSE(shown["scene"].contains("annotations"));
}

TEST(MeshBoundaryCommand, fields_of_cells_are_kept_shown_flat_listed_and_exported) {
  const Workbench bench;
  make_cells_vtu(bench);
  const RunResult packed = bench.rhoray({"pack", "cells.vtu"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  EXPECT_THAT(packed.out + packed.err, HasSubstr("1 field of cells"));
  EXPECT_THAT(bench.rhoray({"info", "cells.rho"}).out, HasSubstr("cells       'layer'"));
  const Json shown = bench.drawn({"cells.rho", "--color-by", "layer", "--pick", "48,36"});
  EXPECT_EQ(shown["scene"]["layers"][0]["color_by"], "layer");
  const Json pick = shown["picks"][0];
  ASSERT_TRUE(pick.contains("value")) << pick;
  EXPECT_EQ(pick["value"], std::floor(4 * pick["position"][2].get<double>())) << pick;

  ASSERT_EQ(bench.rhoray({"export", "cells.rho", "-o", "back.vtu"}).exit_code, 0);
  EXPECT_THAT(bench.rhoray({"info", "back.vtu"}).out, HasSubstr("'layer'"));
}

TEST(MeshBoundaryCommand, picks_have_the_values_of_the_field) {
  const Workbench bench;
  bench.make_box_vtu();
  const Json shown = bench.drawn({"box.vtu", "--pick", "48,36:40,30:60,40"});
  for (const Json& pick : shown["picks"]) {
    ASSERT_TRUE(pick.contains("value")) << pick;
    // The field is linear, and the depth a float.
    EXPECT_NEAR(pick["value"].get<double>(), pick["position"][2].get<double>(), 1e-6) << pick;
  }
}

TEST(MeshBoundaryCommand, means_of_cells_say_how_the_range_changes) {
  const Workbench bench;
  make_cells_vtu(bench);
  const RunResult packed = bench.rhoray({"pack", "cells.vtu", "--cell-data"});
  EXPECT_THAT(packed.err, HasSubstr("field \"layer\" was averaged to the points: 0 to 3 in cells became 0 to 3"));
}

TEST(MeshBoundaryCommand, options_without_effect_are_refused) {
  const Workbench bench;
  bench.make_box();
  bench.make_ball();
  bench.make_cube();
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "render");
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_FALSE(std::filesystem::exists(bench / "box.png"));
    return run.err;
  };
  EXPECT_THAT(refusal({"box.rho", "--mode", "boundary", "--iso", "3"}), HasSubstr("--iso: needs an isosurface"));
  EXPECT_THAT(refusal({"box.rho", "--mode", "boundary", "--accuracy", "exact"}), HasSubstr("expected float or double"));
  EXPECT_THAT(refusal({"ball.rho", "--mode", "boundary"}), HasSubstr("is a grid, which has no boundary"));
  EXPECT_THAT(refusal({"ball.rho", "--context", "0.2"}), HasSubstr("--context: needs a mesh"));
  EXPECT_THAT(refusal({"cube.rho", "--mode", "boundary"}), HasSubstr("holds only triangles"));
  EXPECT_THAT(refusal({"box.rho", "--mode", "mip", "--context", "0.2"}), HasSubstr("--context"));
  EXPECT_THAT(refusal({"box.rho", "--surface-color", "red", "--range", "0,1"}), HasSubstr("--range"));
}

TEST(MeshBoundaryCommand, scenes_have_boundaries) {
  const Workbench bench;
  bench.make_box();
  write_file(bench / "s.json", R"({"data": {"m": {"file": "box.rho"}}, "layers": [
    {"type": "boundary", "opacity": 0.3, "color": "#808080"},
    {"type": "isosurface", "isovalue": 0.5, "color_by": "length"}]})");
  const Json shown = bench.drawn({"s.json"});
  EXPECT_EQ(shown["scene"]["layers"].size(), 2U);
  EXPECT_EQ(shown["scene"]["data"].size(), 1U);
  write_file(bench / "bad.json", R"({"data": {"m": {"file": "box.rho"}}, "layers": [
    {"type": "boundary", "isovalue": 3}]})");
  EXPECT_THAT(bench.rhoray({"render", "bad.json"}).err, HasSubstr("/layers/0/isovalue: found in a layer of type"));
}

}  // namespace
}  // namespace rhoray::tests

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

/// Lines along the edges of boundaries and surfaces, as `rhoray render` draws them.
namespace rhoray::tests {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

/// The angle of a picture's layer; nothing where no line is drawn and none would be by default.
Json edges_of(const Workbench& bench, const std::vector<std::string>& words, std::size_t layer = 0) {
  const Json layers = bench.drawn(words)["scene"]["layers"];
  return layers.at(layer).value("feature_edges", Json());
}

TEST(FeatureEdgesCommand, a_plain_boundary_has_lines_above_30_degrees_and_nothing_else_has) {
  const Workbench bench;
  bench.make_box();
  bench.make_cube();
  preprocess::export_mesh(box_mesh({}), bench / "bare.vtu", false);
  EXPECT_EQ(edges_of(bench, {"bare.vtu"}), 30);
  EXPECT_EQ(edges_of(bench, {"box.rho", "--surface-color", "teal"}), 30);
  EXPECT_EQ(edges_of(bench, {"bare.vtu", "--feature-edges", "180"}), 180);
  EXPECT_EQ(edges_of(bench, {"bare.vtu", "--feature-edges", "40"}), 40);
  EXPECT_EQ(edges_of(bench, {"box.rho"}), Json()) << "coloured by a field";
  EXPECT_EQ(edges_of(bench, {"box.rho", "--feature-edges", "30"}), 30);
  EXPECT_EQ(edges_of(bench, {"bare.vtu", "--opacity", "0.5"}), Json());
  EXPECT_EQ(edges_of(bench, {"box.rho", "--iso", "0.5"}, 1), Json()) << "the boundary around an isosurface";
  EXPECT_EQ(edges_of(bench, {"cube.rho"}), Json());
  EXPECT_EQ(edges_of(bench, {"cube.rho", "--feature-edges", "60"}), 60);
}

TEST(FeatureEdgesCommand, lines_that_would_hide_the_surface_are_drawn_only_if_asked_for) {
  const Workbench bench;
  // Every second cube of a checkerboard of 24 x 24 on a plate: steps of 90 degrees everywhere.
  preprocess::NeutralMesh mesh = box_mesh({.cells = {96, 96, 2}, .box = {{0, 0, 0}, {96, 96, 2}}});
  std::erase_if(mesh.cells, [&](const auto& cell) {
    Vec3 middle(0, 0, 0);
    for (const std::uint64_t v : cell) middle += to_vec3(mesh.points[v]) / 4;
    return middle.z > 1 && (static_cast<int>(middle.x) + static_cast<int>(middle.y)) % 2 == 0;
  });
  preprocess::export_mesh(mesh, bench / "rough.vtu", false);
  EXPECT_EQ(edges_of(bench, {"rough.vtu"}), 180);
  EXPECT_EQ(edges_of(bench, {"rough.vtu", "--feature-edges", "30"}), 30);
}

TEST(FeatureEdgesCommand, the_printed_command_and_the_scene_draw_the_same_lines) {
  const Workbench bench;
  bench.make_box();
  for (const char* angle : {"30", "180"}) {
    const Json shown = bench.drawn({"box.rho", "--surface-color", "teal", "--feature-edges", angle});
    write_file(bench / "scene.json", shown["scene"].dump());
    for (const std::string& again : {shown["reproduce"].get<std::string>(), std::string("rhoray render scene.json")}) {
      const RunResult same = bench.shell(again + " -o again.png --force && rhoray compare box.png again.png --fail 0");
      EXPECT_EQ(same.exit_code, 0) << again << same.out << same.err;
    }
    std::filesystem::rename(bench / "box.png", bench / (std::string(angle) + ".png"));
  }
  EXPECT_NE(bench.rhoray({"compare", "30.png", "180.png", "--fail", "0"}).exit_code, 0);
}

TEST(FeatureEdgesCommand, a_picture_of_data_has_lines_only_if_asked_for) {
  const Workbench bench;
  bench.make_box();
  const std::vector<std::string> plain{"box.rho", "--surface-color", "teal", "-o", "box.exr"};
  EXPECT_EQ(edges_of(bench, plain), 180);
  EXPECT_EQ(edges_of(bench, {"box.rho", "--surface-color", "teal", "-o", "box.exr", "--feature-edges", "20"}), 20);
}

TEST(FeatureEdgesCommand, layers_of_scenes_have_lines) {
  const Workbench bench;
  bench.make_box();
  bench.make_cube();
  write_file(bench / "s.json", R"({"data": {"m": {"file": "box.rho"}, "c": {"file": "cube.rho"}}, "layers": [
    {"type": "boundary", "data": "m", "feature_edges": 45, "color_by": "length"},
    {"type": "triangles", "data": "c", "feature_edges": 10}]})");
  EXPECT_EQ(edges_of(bench, {"s.json"}, 0), 45);
  EXPECT_EQ(edges_of(bench, {"s.json"}, 1), 10);
}

TEST(FeatureEdgesCommand, what_has_no_triangles_is_refused) {
  const Workbench bench;
  bench.make_box();
  bench.make_ball();
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "render");
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    return run.err;
  };
  EXPECT_THAT(refusal({"ball.rho", "--feature-edges", "30"}), HasSubstr("--feature-edges: needs triangles"));
  EXPECT_THAT(refusal({"box.rho", "--iso", "0.5", "--feature-edges", "30"}), HasSubstr("add --mode boundary"));
  EXPECT_THAT(refusal({"ball.rho", "--slice", "z=0.5", "--feature-edges", "30"}), HasSubstr("--feature-edges"));
  EXPECT_THAT(refusal({"ball.rho", "--mode", "mip", "--feature-edges", "30"}), HasSubstr("--feature-edges"));
  EXPECT_THAT(refusal({"box.rho", "--feature-edges", "181"}), HasSubstr("0 to 180"));
}

}  // namespace
}  // namespace rhoray::tests

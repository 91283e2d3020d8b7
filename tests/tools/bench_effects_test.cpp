#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// Rows of a table by the names in their first column.
std::map<std::string, json> rows_of(const json& table, const std::string& name) {
  std::map<std::string, json> rows;
  for (const json& row : table["rows"]) rows[row[name].get<std::string>()] = row;
  return rows;
}

json table(const Workbench& bench, const std::string& name) {
  return json::parse(read_file(bench / ("tables/" + name + ".json")));
}

TEST(BenchEffects, switches_each_effect_on_alone_and_counts_what_it_asks_for) {
  const Workbench bench;
  bench.make_box();
  std::filesystem::create_directory(bench / "tables");
  const RunResult run = bench.rhoray({"bench", "effects", "box.rho", "--repeat", "2", "--size", "40x30", "--iso", "0.5",
                                      "--threads", "1", "-o", "tables"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json effects = table(bench, "effects");
  const auto rows = rows_of(effects, "effect");
  ASSERT_EQ(rows.size(), effects["rows"].size());
  const json &plain = rows.at("plain"), &off = rows.at("all effects off");
  EXPECT_EQ(off["picture"], plain["picture"]);
  for (const char* counter :
       {"shadow_rays", "occlusion_rays", "rays_through", "highlights", "normals_smoothed", "colors_looked_up"})
    for (const json& row : {plain, off}) EXPECT_EQ(row[counter], 0) << counter;
  EXPECT_EQ(off["cells_visited"], plain["cells_visited"]);
  const auto only = [&](const char* effect, const char* counter) {
    const json& row = rows.at(effect);
    for (const char* any :
         {"shadow_rays", "occlusion_rays", "rays_through", "highlights", "normals_smoothed", "colors_looked_up"})
      EXPECT_EQ(row[any].get<int>() > 0, std::string(any) == counter) << effect << ' ' << any;
    EXPECT_EQ(row["hits"], plain["hits"]) << effect;
    EXPECT_LE(row["ratio_min"], row["ratio"]);
    EXPECT_LE(row["ratio"], row["ratio_max"]);
  };
  only("one light beside the eye", "none");
  only("hard shadows", "shadow_rays");
  only("hard shadows, a light that moves", "shadow_rays");
  only("soft shadows, 16 rays", "shadow_rays");
  only("ambient occlusion", "occlusion_rays");
  only("specular", "highlights");
  only("smooth normals", "normals_smoothed");
  only("colour by a field", "colors_looked_up");
  only("fog", "none");
  only("transparent surfaces", "rays_through");
  EXPECT_GE(rows.at("transparent surfaces")["clear_per_hit"], 1.0);
  EXPECT_GE(rows.at("two transparent surfaces")["clear_crossings"],
            rows.at("two transparent surfaces")["rays_through"]);
  EXPECT_EQ(rows.at("one opaque surface")["clear_crossings"], 0);
  EXPECT_EQ(rows.at("hard shadows")["over"], "one light beside the eye");
  EXPECT_EQ(rows.at("hard shadows, a light that moves")["over"], "one light beside the eye");
  EXPECT_EQ(rows.at("two transparent surfaces")["over"], "one opaque surface");
  EXPECT_NE(rows.at("fog")["picture"], plain["picture"]);
  EXPECT_LE(rows.at("soft shadows, 16 rays")["shadow_rays"], 16 * plain["hits"].get<int>());

  const json frames = table(bench, "table_4");
  ASSERT_EQ(frames["rows"].size(), 4U);
  EXPECT_EQ(frames["rows"][1]["paper_fps"], 8.7);
  EXPECT_EQ(frames["rows"][0]["time"], 1.0);
  EXPECT_GT(frames["rows"][1]["fps"], 0.0);
  const auto phases = rows_of(table(bench, "table_1"), "shows");
  EXPECT_EQ(phases.at("bone of the Visible Woman")["traversal_percent"], 66);
  EXPECT_NEAR(phases.at("plain")["traversal_percent"].get<double>() +
                  phases.at("plain")["intersection_percent"].get<double>() +
                  phases.at("plain")["shading_percent"].get<double>(),
              100, 1e-6);
  EXPECT_EQ(effects["context"]["scene"]["layers"][0]["isovalue"], 0.5);
  EXPECT_THAT(read_file(bench / "tables/effects.csv"), testing::StartsWith("effect,over,ratio,"));
}

TEST(BenchEffects, takes_a_scene_as_it_is) {
  const Workbench bench;
  bench.make_ball();
  bench.make_cube();
  write_file(bench / "s.json", R"({"data": {"b": {"file": "ball.rho"}, "c": {"file": "cube.rho"}},
    "layers": [{"type": "isosurface", "data": "b", "isovalue": [60, 120], "opacity": 0.5},
               {"type": "triangles", "data": "c"}], "effects": {"fog": {}}, "image": {"show": "cost"}})");
  const RunResult run = bench.rhoray({"bench", "s.json", "--repeat", "1", "--size", "128x128", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto rows = rows_of(json::parse(run.out.substr(0, run.out.find('\n'))), "effect");
  EXPECT_GT(rows.at("the scene as it is")["rays_through"], 0);
  EXPECT_EQ(rows.at("plain")["rays_through"], 0);
  EXPECT_GT(rows.at("smooth normals")["normals_smoothed"], 0) << "of the triangles";
  EXPECT_NE(rows.at("hard shadows, a light that moves")["picture"], rows.at("hard shadows")["picture"]);
  EXPECT_NE(rows.at("one opaque surface")["picture"], rows.at("plain")["picture"]);
}

TEST(BenchEffects, has_a_row_for_each_of_texture_region_slices_and_edges) {
  const Workbench bench;
  bench.make_ball();
  bench.make_photo();
  write_file(bench / "s.json", R"({"data": {"b": {"file": "ball.rho"}, "p": {"file": "photo.rho"}},
    "layers": [{"type": "slice", "data": "b", "axis": "z"},
               {"type": "isosurface", "data": "b", "isovalue": 100, "texture": "p"}],
    "clip": {"box": [[0, 0, 0], [23, 23, 14]]}})");
  const RunResult run = bench.rhoray({"bench", "effects", "s.json", "--repeat", "1", "--size", "60x50", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto rows = rows_of(json::parse(run.out.substr(0, run.out.find('\n'))), "effect");
  for (const auto& [effect, counter] : {std::pair{"texture", "texture_lookups"},
                                        {"texture, hard shadows", "texture_lookups"},
                                        {"clip region", "rays_clipped"},
                                        {"slices", "slice_lookups"},
                                        {"antialiasing, 16 samples", "edge_samples"}}) {
    EXPECT_GT(rows.at(effect)[counter], 0) << effect;
    EXPECT_EQ(rows.at("plain")[counter], 0) << effect;
    EXPECT_NE(rows.at(effect)["picture"], rows.at("plain")["picture"]) << effect;
  }
}

TEST(BenchEffects, refuses_what_it_cannot_measure) {
  const Workbench bench;
  bench.make_ball();
  write_file(bench / "s.json", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip"}]})");
  write_file(bench / "i.json", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "isosurface"}]})");
  for (const auto& [words, exit_code, fact] :
       {std::tuple{std::vector<std::string>{"bench", "effects", "s.json"}, 4, "shows no surface"},
        {{"bench", "effects", "i.json", "--iso", "3"}, 2, "--iso: not allowed with the scene i.json"},
        {{"bench", "phases", "i.json"}, 7, "i.json: is a scene; table 'phases' needs a file with data"},
        {{"bench", "effects", "ball.raw"}, 7, "ball.raw: unsupported file type"}}) {
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, exit_code) << fact;
    EXPECT_THAT(run.err, HasSubstr(fact));
  }
}

}  // namespace
}  // namespace rhoray::tests

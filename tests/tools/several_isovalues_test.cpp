#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "render/color_map.h"
#include "render/isovalue.h"
#include "tests/support/expect_error.h"
#include "tests/tools/workbench.h"

/// Several isosurfaces of one field: their colours, opacities and legend.
namespace rhoray::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class SeveralIsovalues : public testing::Test {
 protected:
  SeveralIsovalues() { bench_.make_ball(); }

  nlohmann::json scene_of(std::vector<std::string> words) const {
    words.insert(words.begin(), "render");
    words.emplace_back("--print-scene");
    const RunResult result = bench_.rhoray(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  }

  static std::vector<double> opacities(const nlohmann::json& scene) {
    std::vector<double> all;
    for (const nlohmann::json& layer : scene["layers"]) all.push_back(layer["opacity"]);
    return all;
  }

  static void expect_color(const nlohmann::json& layer, const Vec3& color) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(layer["color"][c].get<double>(), color[static_cast<int>(c)], 1e-12);
  }

  /// field.vtu: tetrahedra of a cube with fields 'f' and 'others'.
  template <class Field>
  void make_mesh(const Field& field) const {
    preprocess::NeutralMesh mesh = box_mesh({});
    add_point_field(mesh, "f", field);
    preprocess::export_mesh(mesh, bench_ / "field.vtu", false);
  }

  Workbench bench_;
};

TEST_F(SeveralIsovalues, have_viridis_over_their_values_and_grow_opaque_inwards) {
  const nlohmann::json scene = scene_of({"ball.rho", "--iso", "40,80,120,160,200"});
  EXPECT_THAT(opacities(scene), ElementsAre(0.17, 0.2, 0.25, 0.33, 1));
  for (std::size_t i = 0; i < 5; ++i)
    expect_color(scene["layers"][i], color_of(render::ColorMap::viridis, static_cast<double>(i) / 4));
  EXPECT_EQ(scene["annotations"]["legend"], true);
  EXPECT_THAT(opacities(scene_of({"ball.rho", "--iso", "200,40,120"})), ElementsAre(1, 0.25, 0.33)) << "in any order";
}

TEST_F(SeveralIsovalues, are_ordered_by_size_where_the_field_grows_outwards) {
  make_mesh([](const Vec3& p) { return (p - Vec3(0.5)).length(); });
  EXPECT_THAT(opacities(scene_of({"field.vtu", "--iso", "0.2,0.3,0.4", "--context", "0"})), ElementsAre(1, 0.33, 0.25));
}

TEST_F(SeveralIsovalues, of_both_signs_are_blue_and_red_around_0_and_each_sign_has_its_innermost) {
  make_mesh([](const Vec3& p) {
    return 1 / (0.2 + (p - Vec3(0.2, 0.5, 0.5)).length()) - 1 / (0.2 + (p - Vec3(0.8, 0.5, 0.5)).length());
  });
  const nlohmann::json scene = scene_of({"field.vtu", "--iso", "-2,-1,1,2", "--context", "0"});
  EXPECT_THAT(opacities(scene), ElementsAre(1, 0.33, 0.33, 1));
  expect_color(scene["layers"][0], color_of(render::ColorMap::coolwarm, 0));
  expect_color(scene["layers"][2], color_of(render::ColorMap::coolwarm, 0.75));
}

TEST_F(SeveralIsovalues, of_both_signs_are_one_set_where_one_encloses_the_other) {
  make_mesh([](const Vec3& p) { return 0.3 - (p - Vec3(0.5)).length(); });
  const nlohmann::json scene = scene_of({"field.vtu", "--iso", "-0.1,0.1", "--context", "0"});
  EXPECT_THAT(opacities(scene), ElementsAre(0.33, 1));
  expect_color(scene["layers"][0], color_of(render::ColorMap::viridis, 0));
}

TEST_F(SeveralIsovalues, keep_a_colour_and_an_opacity_that_are_given) {
  const nlohmann::json colored = scene_of({"ball.rho", "--iso", "40,80", "--surface-color", "1,0,0"});
  for (const nlohmann::json& layer : colored["layers"]) expect_color(layer, {1, 0, 0});
  EXPECT_THAT(opacities(colored), ElementsAre(0.33, 1));
  EXPECT_FALSE(colored.contains("annotations")) << "no legend of one colour";
  const nlohmann::json clear = scene_of({"ball.rho", "--iso", "40,80", "--opacity", "0.3"});
  EXPECT_THAT(opacities(clear), ElementsAre(0.3, 0.3));
  expect_color(clear["layers"][1], color_of(render::ColorMap::viridis, 1));
  EXPECT_EQ(clear["annotations"]["legend"], true);
}

TEST_F(SeveralIsovalues, of_which_one_is_shown_look_like_one) {
  const nlohmann::json one = scene_of({"ball.rho", "--iso", "100"}), rest = scene_of({"ball.rho", "--iso", "100,9000"});
  EXPECT_EQ(rest["layers"], one["layers"]);
  EXPECT_FALSE(rest.contains("annotations"));
}

TEST_F(SeveralIsovalues, that_are_equal_make_one_surface) {
  const nlohmann::json one = scene_of({"ball.rho", "--iso", "100"}), equal = scene_of({"ball.rho", "--iso", "100,100"});
  EXPECT_EQ(equal["layers"], one["layers"]);
  EXPECT_FALSE(equal.contains("annotations"));
  EXPECT_EQ(scene_of({"ball.rho", "--iso", "40,80,40,p50,80,p50"})["layers"],
            scene_of({"ball.rho", "--iso", "40,80,p50"})["layers"]);
  EXPECT_EQ(scene_of({"ball.rho", "--iso", "0,-0"})["layers"].size(), 1U);
}

TEST_F(SeveralIsovalues, that_are_equal_are_drawn_once_with_a_note) {
  const auto draw = [&](const std::string& isovalues, const std::string& picture) {
    return bench_.rhoray({"render", "ball.rho", "--iso", isovalues, "--opacity", "0.5", "--surface-color", "1,0,0",
                          "--size", "60x50", "-o", picture});
  };
  ASSERT_EQ(draw("100", "one.png").exit_code, 0);
  const RunResult equal = draw("100,100", "two.png");
  EXPECT_EQ(equal.exit_code, 0) << equal.err;
  EXPECT_THAT(equal.err, HasSubstr("note: --iso: isovalue 100 (given) equals an earlier one; the layer is left out\n"));
  EXPECT_EQ(bench_.rhoray({"compare", "one.png", "two.png", "--fail", "0"}).exit_code, 0);
  write_file(bench_ / "s.json", R"({"data": {"b": {"file": "ball.rho"}}, "image": {"size": [60, 50]},
                                    "layers": [{"type": "isosurface", "isovalue": [40, "p50", "p50"]}]})");
  const RunResult document = bench_.rhoray({"render", "s.json"});
  EXPECT_THAT(document.err, HasSubstr("note: s.json: /layers/0/isovalue/2: isovalue "));
  EXPECT_THAT(document.err, HasSubstr(" (percentile 50) equals an earlier one; the layer is left out\n"));
}

TEST_F(SeveralIsovalues, have_a_legend_that_an_option_switches) {
  EXPECT_EQ(scene_of({"ball.rho", "--iso", "40,80", "--legend", "off"})["annotations"]["legend"], false);
  EXPECT_EQ(scene_of({"ball.rho", "--iso", "40", "--legend", "on"})["annotations"]["legend"], true);
  write_file(bench_ / "s.json", R"({"data": {"b": {"file": "ball.rho"}}, "annotations": {"legend": false},
                                    "layers": [{"type": "isosurface", "isovalue": [40, 80]}]})");
  EXPECT_EQ(scene_of({"s.json"})["annotations"]["legend"], false);
  EXPECT_EQ(scene_of({"s.json", "--legend", "on"})["annotations"]["legend"], true);
  const RunResult refused = bench_.rhoray({"render", "ball.rho", "--mode", "mip", "--legend", "on", "-o", "p.png"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--legend: no isosurface or label here has a colour of its own"));
}

TEST_F(SeveralIsovalues, are_drawn_again_by_the_printed_command) {
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, {"--legend", "off"}, {"--opacity", "0.4"}, {"--background", "none"}}) {
    std::vector<std::string> all{"render", "ball.rho", "--iso", "40,80,120", "--size",
                                 "120x90", "--force",  "-o",    "p.png"};
    all.insert(all.end(), more.begin(), more.end());
    const RunResult first = bench_.rhoray(all);
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const std::string picture = read_file(bench_ / "p.png");
    const RunResult again = bench_.shell(line_after(first.err, "reproduce: ") + " --force");
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_TRUE(read_file(bench_ / "p.png") == picture) << testing::PrintToString(more);
  }
}

TEST_F(SeveralIsovalues, are_opaque_where_they_are_checked) {
  const RunResult drawn = bench_.rhoray({"render", "ball.rho", "--iso", "40,80", "--verify", "50", "--size", "32x32"});
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
}

TEST_F(SeveralIsovalues, are_drawn_without_legend_where_annotations_cannot_be_drawn) {
  std::filesystem::create_directory(bench_ / "alone");
  std::filesystem::copy_file(RHORAY_PROGRAM, bench_ / "alone/rhoray");
  const RunResult drawn = bench_.shell("alone/rhoray render ball.rho --iso 40,80 --size 32x32 -o p.png");
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_THAT(drawn.err, HasSubstr("note: no colour bar, legend or box: they need the module rhoray-pictures.so"));
  const RunResult refused = bench_.shell("alone/rhoray render ball.rho --iso 40,80 --legend on --size 32x32 -o q.png");
  EXPECT_EQ(refused.exit_code, 7);
}

/// The format allows it, and such a field was called constant.
TEST(Isovalue, is_not_chosen_without_a_histogram) {
  const formats::FieldSummary field{.name = "f", .unit = {}, .range = {0, 26}, .histogram = {}};
  for (const char* text : {"auto", "p50"})
    expect_error(ErrorCode::usage, "no histogram", [&] { render::choose_isovalue(text, field); });
  EXPECT_EQ(render::choose_isovalue("13", field).value, 13);
}

}  // namespace
}  // namespace rhoray::tests

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "formats/base/text.h"
#include "preprocess/pack_volume.h"
#include "render/accuracy.h"
#include "render/document.h"
#include "render/render.h"
#include "tests/support/expect_error.h"
#include "tests/support/fields.h"
#include "tests/support/host_floating_point.h"
#include "tests/tools/workbench.h"
#include "tools/rhoray/accuracy_options.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

struct DataSet {
  const char* name;
  Field field;
  const char* isovalue;
};

/// Smooth and rough, thin and thick.
std::vector<DataSet> data_sets() {
  return {
      {"ball.rho", distance_field({0.1, 0, -0.1}), "0.6"},
      {"ripples.rho", marschner_lobb_field(3), "0.5"},
      {"product.rho", product_field(), "0.1"},
      {"gyroid.rho",
       [](const Vec3& p) {
         return std::sin(6 * p.x) * std::cos(6 * p.y) + std::sin(6 * p.y) * std::cos(6 * p.z) +
                std::sin(6 * p.z) * std::cos(6 * p.x);
       },
       "0.3"},
      {"rough.rho",
       [](const Vec3& p) { return p.z + 0.3 * std::sin(17 * p.x + 3 * p.y) * std::cos(13 * p.y - 5 * p.z); }, "0.1"}};
}

void make(const Workbench& bench, const DataSet& data) {
  const Index3 count(28, 28, 28);
  const auto dataset = sampled_volume<float>(count, lattice_over(Box3({-1, -1, -1}, {1, 1, 1}), count), data.field);
  preprocess::pack_volume(dataset, bench / data.name);
}

json rendered(const Workbench& bench, const std::string& words) {
  const RunResult run = bench.shell("rhoray render " + words + " --json --size 240x180 --force -o p.png");
  EXPECT_EQ(run.exit_code, 0) << words << run.err;
  return json::parse(run.out);
}

TEST(AccuracyChoice, keeps_its_error_on_five_data_sets_also_from_where_it_has_not_looked) {
  const Workbench bench;
  std::map<std::string, int> methods;
  for (const DataSet& data : data_sets()) {
    make(bench, data);
    for (const char* error : {"0.3", "0.003", "1e-10"}) {
      SCOPED_TRACE(std::string(data.name) + " " + error);
      const std::string what = std::string(data.name) + " --iso " + data.isovalue;
      const json first = rendered(bench, what + " --max-error " + error + " --verify 1000");
      EXPECT_LE(first["verify"]["random"]["kept_by_99"].get<double>(), std::stod(error));
      const std::string method = first["method"];
      ++methods[method];
      EXPECT_THAT(first["reproduce"].get<std::string>(), HasSubstr(method));
      const std::string option = method.find(':') == std::string::npos ? " --accuracy " : " --method ";
      const json other = rendered(bench, what + option + method + " --view -x --verify 1000 --verify-seed 7");
      EXPECT_LE(other["verify"]["random"]["kept_by_99"].get<double>(), std::stod(error));
    }
  }
  EXPECT_GE(methods.size(), 2U) << "the error asked for makes no difference: is the choice still one?";
}

TEST(AccuracyChoice, takes_the_best_that_keeps_the_time_and_says_so_when_none_does) {
  const Workbench bench;
  bench.make_ball();
  const auto said = [&](const std::string& words) {
    const RunResult run = bench.shell("rhoray render ball.rho --size 64x48 --force -o p.png " + words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return line_after(run.err, "method ");
  };
  EXPECT_THAT(said("--iso 60 --budget-ms 100000"),
              testing::StartsWith("exact: the most accurate method within the time limit"));
  EXPECT_THAT(said("--iso 60 --budget-ms 1e-6"), HasSubstr("no method keeps the time limit; this is the fastest"));
  EXPECT_THAT(said("--iso 60 --budget-ms 1e-6 --max-error 1e-10"),
              HasSubstr("within the error limit in 99 % of the pixels, but above the time limit"));
  EXPECT_THAT(said("--mode mip --max-error 1e-6"), HasSubstr("of the field's range"));
}

TEST(AccuracyChoice, refuses_limits_that_nothing_meets) {
  const Workbench bench;
  bench.make_ball();
  for (const char* words : {"--max-error 0", "--budget-ms -1"}) {
    const RunResult run = bench.shell(std::string("rhoray render ball.rho --iso 60 -o p.png ") + words);
    EXPECT_EQ(run.exit_code, 2) << words;
    EXPECT_FALSE(std::filesystem::exists(bench / "p.png"));
  }
}

TEST(AccuracyChoice, refuses_limits_where_no_layer_has_a_method) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  for (const auto& [words, fact] :
       {std::pair{"ball.rho --slice z --max-error 0.01", "--max-error: no layer is an isosurface or a projection"},
        {"box.rho --mode boundary --budget-ms 100", "--budget-ms: no layer is an isosurface or a projection"},
        {"ball.rho --slice z --accuracy exact", "--accuracy has no effect on slices"}}) {
    const RunResult run = bench.shell(concat("rhoray render ", words, " -o p.png"));
    EXPECT_EQ(run.exit_code, 2) << words;
    EXPECT_THAT(run.err, HasSubstr(fact));
    EXPECT_FALSE(std::filesystem::exists(bench / "p.png"));
  }
}

TEST(AccuracyChoice, is_told_in_the_report) {
  const Workbench bench;
  bench.make_ball();
  ASSERT_EQ(
      bench.shell("rhoray accuracy ball.rho --iso 60 -o out --size 64x48 --repeat 1 --max-error 0.01 -q").exit_code, 0);
  const json results = json::parse(read_file(bench / "out/results.json"));
  EXPECT_THAT(results["notes"].dump(), HasSubstr("would use method "));
}

TEST(SelfCheck, finds_the_levels_as_good_as_they_promise) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  for (const std::string words : {"ball.rho --iso 60 --accuracy float", "ball.rho --iso 60 --accuracy double",
                                  "ball.rho --iso 60 --accuracy certified", "ball.rho --iso 60 --accuracy exact",
                                  "ball.rho --iso 60,120 --opacity 1 --accuracy certified", "ball.rho --mode mip",
                                  "ball.rho --mode mip --accuracy certified", "box.rho --field length --iso 0.8",
                                  "box.rho --field length --iso 0.8 --accuracy certified"}) {
    const json check = rendered(bench, words + " --verify 200 --verify-seed 3")["verify"];
    EXPECT_EQ(check["seed"], 3);
    EXPECT_EQ(check["random"]["pixels"], 200) << words;
    EXPECT_GT(check["edges"]["pixels"], 0) << words;
    EXPECT_TRUE(check["holds"]) << words;
    EXPECT_NE(check["limit"], "") << words;
  }
  const RunResult run =
      bench.shell("rhoray render ball.rho --iso 60 --method sampled:2 --size 320x240 -o p.png --force --verify 300");
  EXPECT_EQ(run.exit_code, 0) << "a method that promises nothing breaks nothing";
  EXPECT_THAT(run.out, HasSubstr("the method promises nothing"));
  EXPECT_THAT(run.out, HasSubstr("random 300 pixels: "));
  EXPECT_THAT(run.out, HasSubstr("seed 1"));
}

TEST(SelfCheck, notices_a_picture_that_is_wrong) {
  const Workbench bench;
  bench.make_ball();
  render::SceneSpec scene_spec{.data = std::vector<render::DataSpec>(1), .layers = std::vector<render::LayerSpec>(1)};
  scene_spec.data[0].file = bench / "ball.rho";
  scene_spec.layers[0].isovalues = {"60"};
  scene_spec.layers[0].accuracy = "certified";
  scene_spec.image.size = render::PictureSize{80, 60};
  render::ResolvedScene plan = tools::resolve_layers(scene_spec);
  render::aim_camera(scene_spec, plan);
  plan.frame.channels = render::channels_to_check(plan);
  render::Framebuffer right;
  render::render(plan.datasets, plan.scene, plan.frame, right);
  const auto check = [&](const render::Framebuffer& picture, std::optional<double> limit = {}) {
    return render::check_picture(plan, picture, {.pixels = 500, .seed = 1, .limit = limit}, 1);
  };
  EXPECT_EQ(check(right).broken, "");
  render::Framebuffer wrong = right;
  for (float& depth : wrong.depth) depth *= 1.001F;
  EXPECT_THAT(check(wrong).broken, HasSubstr("beyond their bound"));
  EXPECT_GT(check(wrong).random.largest, 0.01);
  EXPECT_GT(check(wrong).random.largest_value_error, 0.1);
  EXPECT_THAT(check(wrong, 1e-3).broken, HasSubstr("more than 1 % at a confidence of 97.5 %"));
  EXPECT_EQ(check(right, 1e-3).broken, "");
  EXPECT_THAT(check(wrong, 10.0).broken,
              testing::AllOf(HasSubstr("beyond their bound"), testing::Not(HasSubstr("confidence"))))
      << "a wider limit does not excuse a proof that is wrong";
  wrong = right;
  for (float& depth : wrong.depth) depth = std::numeric_limits<float>::infinity();
  EXPECT_THAT(check(wrong).broken, HasSubstr("false negatives"));
  EXPECT_EQ(check(wrong).random.false_hits, 0U);
  for (float& depth : wrong.depth) depth = 1;
  EXPECT_GT(check(wrong).random.false_hits, 0U);

  std::stop_source source;
  source.request_stop();
  const render::SelfCheckOptions stopped{.pixels = 500, .limit = {}, .watch = source.get_token()};
  expect_error(ErrorCode::interrupted, "interrupted", [&] { render::check_picture(plan, right, stopped, 1); });
}

// The exact answers with which pixels are compared were themselves computed in the host's
// environment. A certified picture that had changed in it was therefore found right.
TEST(SelfCheck, counts_one_pixel_in_the_singular) {
  render::SelfCheck check;
  check.random.missed = 1, check.random.false_hits = 2;
  EXPECT_THAT(tools::text_of(check), HasSubstr("0 pixels: 1 false negative, 2 false positives, largest"));
}

TEST(SelfCheck, does_not_depend_on_the_hosts_floating_point_environment) {
  const Workbench bench;
  const Index3 count(13, 13, 13);
  preprocess::pack_volume(
      sampled_volume<double>(count, lattice_over({{0, 0, 0}, {1, 1, 1}}, count),
                             [](const Vec3& p) { return 1e-309 * (std::sin(5 * p.x) + std::sin(4 * p.y) * p.z); }),
      bench / "small.rho");
  const auto found = [&] {
    render::SceneSpec scene_spec{.data = std::vector<render::DataSpec>(1), .layers = std::vector<render::LayerSpec>(1)};
    scene_spec.data[0].file = bench / "small.rho";
    scene_spec.layers[0].isovalues = {"7e-310"};
    scene_spec.layers[0].accuracy = "certified";
    scene_spec.image.size = render::PictureSize{60, 45};
    render::ResolvedScene plan = tools::resolve_layers(scene_spec);
    render::aim_camera(scene_spec, plan);
    plan.frame.channels = render::channels_to_check(plan);
    render::Framebuffer picture;
    render::render(plan.datasets, plan.scene, plan.frame, picture);
    const render::SelfCheck check = render::check_picture(plan, picture, {.pixels = 500, .seed = 1, .limit = {}}, 2);
    return concat(check.broken, " ", check.random.shown, " ", check.random.missed, " ", check.random.false_hits, " ",
                  check.random.largest, " ", check.random.kept_by_99, " ", check.edges.shown, " ", check.edges.largest);
  };
  const std::string expected = found();
  EXPECT_THAT(expected, testing::StartsWith(" ")) << "broken";
  for (const HostFloatingPoint& environment : host_environments()) {
    std::string in_host;
    std::thread([&] {
      const InHostFloatingPoint host(environment);
      in_host = found();
    }).join();
    EXPECT_EQ(in_host, expected) << environment.name;
  }
}

TEST(SelfCheck, ends_with_exit_code_6_for_a_method_that_is_worse_on_purpose) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  const auto run = [&](const std::string& words) {
    return bench.shell("rhoray render " + words + " --size 240x180 --force -o p.png --verify 500");
  };
  struct Worse {
    std::string picture, good, bad, limit;
  };
  for (const Worse& worse :
       {Worse{"ball.rho --iso 60", "--method sampled:0.0625+linear", "--method sampled:2+linear", "0.01"},
        Worse{"ball.rho --iso 60", "--accuracy double", "--method sampled:1+bisect", "1e-8"},
        Worse{"ball.rho --mode mip", "--accuracy double", "--method sampled:2", "1e-3"},
        Worse{"box.rho --field length --iso 0.8", "--accuracy float", "--method slack:0.3", "1e-3"}}) {
    const std::string limit = " --verify-limit " + worse.limit;
    const RunResult good = run(worse.picture + " " + worse.good + limit);
    EXPECT_EQ(good.exit_code, 0) << worse.picture << good.err;
    EXPECT_THAT(good.out, HasSubstr("within the limit"));
    std::filesystem::remove(bench / "p.png");
    const RunResult bad = run(worse.picture + " " + worse.bad + limit);
    EXPECT_EQ(bad.exit_code, 6) << worse.picture << bad.out;
    EXPECT_THAT(bad.out, HasSubstr("OUTSIDE THE LIMIT"));
    EXPECT_THAT(bad.err, HasSubstr("more than 1 % at a confidence of 97.5 %"));
    EXPECT_TRUE(std::filesystem::exists(bench / "p.png")) << "the picture is written all the same";
    EXPECT_EQ(run(worse.picture + " " + worse.bad).exit_code, 0) << "such a method promises nothing by itself";
    const RunResult as_json = run(worse.picture + " " + worse.bad + limit + " --json");
    EXPECT_EQ(as_json.exit_code, 6);
    EXPECT_FALSE(json::parse(as_json.out)["verify"]["holds"]);
  }
}

TEST(SelfCheck, looks_at_what_a_clip_region_leaves) {
  const Workbench bench;
  bench.make_ball();
  for (const std::string words : {"--iso 60 --accuracy certified --clip-plane 11.5,11.5,11.5,-1,0.2,0.1",
                                  "--iso 60 --accuracy exact --clip-box 4,4,4,12,12,30",
                                  "--iso 60 --accuracy certified --clip-box 11,2,11,30,30,30 --cut-away",
                                  "--mode mip --accuracy certified --clip-plane 10,11.5,11.5,-1,0.2,0.1",
                                  "--mode mip --accuracy certified --clip-box 8,8,8,30,30,30 --cut-away"}) {
    const json check = rendered(bench, "ball.rho " + words + " --verify 2000")["verify"];
    EXPECT_TRUE(check["holds"]) << words << check;
    EXPECT_GT(check["random"]["shown"], 100) << words;
  }
}

TEST(SelfCheck, refuses_pictures_whose_pixels_are_of_several_places) {
  const Workbench bench;
  bench.make_ball();
  const auto refused = [&](const std::string& words, const std::string& fact) {
    const RunResult run = bench.shell("rhoray render ball.rho -o p.png --size 40x30 " + words);
    EXPECT_EQ(run.exit_code, 2) << words;
    EXPECT_THAT(run.err, HasSubstr(fact));
  };
  refused("--slice z=10 --verify 10", "--verify: a layer is a slice");
  refused("--iso 60 --verify-limit 0.1", "--verify-limit: needs --verify");
  refused("--iso 60 --verify 10 --verify-limit 0", "--verify-limit: found 0");
  const RunResult run = bench.shell("rhoray render ball.rho --iso 60,120 --opacity 0.5 --verify 10 -o p.png");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--verify: a transparent surface"));
}

}  // namespace
}  // namespace rhoray::tests

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "formats/base/error.h"
#include "render/method_words.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using render::Method;
using render::Mode;
using testing::HasSubstr;

TEST(MethodWords, name_every_method_and_are_read_back) {
  const std::vector<std::string> grid{"bracketed:float", "bracketed:double",   "paper:float",
                                      "paper:double",    "sampled:0.5+linear", "sampled:0.25+bisect"};
  const std::vector<std::string> mesh{"edges:float",        "edges:double",      "paper:double",    "paper:float",
                                      "slack:1e-12:double", "slack:0.001:float", "sampled:1+linear"};
  const std::vector<std::string> mip{"exact:double", "face:float", "sampled:0.1+linear"};
  const auto expect_same = [](const std::vector<std::string>& words, Mode mode, bool is_mesh) {
    for (const std::string& word : words) {
      const render::MethodOption option = render::option_of(render::method_named(word, mode, is_mesh), mode, is_mesh);
      const render::Method method = render::method_named(word, mode, is_mesh);
      const bool is_level = method.algorithm == render::Method::Algorithm::direct;
      EXPECT_EQ(option.option, is_level ? "--accuracy" : "--method");
      EXPECT_EQ(option.word, is_level ? word.substr(word.find(':') + 1) : word);
    }
  };
  expect_same(grid, Mode::isosurface, false);
  expect_same(mesh, Mode::isosurface, true);
  expect_same(mip, Mode::mip, false);
  for (const std::string& word : render::accuracy_words()) {
    const render::MethodOption option =
        render::option_of(render::method_of(render::accuracy_named(word)), Mode::isosurface, false);
    EXPECT_EQ(option.option, "--accuracy");
    EXPECT_EQ(option.word, word);
  }
}

TEST(MethodWords, refuse_what_does_not_answer_the_question) {
  const auto refusal = [](const std::string& word, Mode mode, bool is_mesh) {
    try {
      render::method_named(word, mode, is_mesh);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage);
      return std::string(error.what());
    }
    return std::string("not refused: " + word);
  };
  EXPECT_THAT(refusal("edges", Mode::isosurface, false), HasSubstr("expected one of bracketed"));
  EXPECT_THAT(refusal("bracketed", Mode::isosurface, true), HasSubstr("expected one of edges"));
  EXPECT_THAT(refusal("face", Mode::isosurface, false), HasSubstr("found 'face'"));
  for (const char* word : {"sampled", "sampled:", "sampled:x", "sampled:0.5+cubic", "paper:half", "slack", ""})
    EXPECT_THAT(refusal(word, Mode::isosurface, true), HasSubstr("--method: found '")) << word;
  EXPECT_THAT(refusal("sampled:0", Mode::isosurface, true), HasSubstr("--method sampled:"));
  EXPECT_THAT(refusal("slack:2", Mode::isosurface, true), HasSubstr("--method slack:"));
}

TEST(AccuracyCommand, levels_draw_the_same_picture_and_every_method_says_how_it_drew) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  const auto pack_in_bricks_of = [&](const std::string& edge, const std::string& file) {
    const RunResult packed = bench.rhoray({"pack", "ball.raw", "--raw", "24x24x24:uint8", "--type", "F32", "--layout",
                                           "sparse", "--brick-edge", edge, "-o", file, "-q"});
    ASSERT_EQ(packed.exit_code, 0) << packed.err;
  };
  pack_in_bricks_of("8", "sparse.rho");
  pack_in_bricks_of("2", "small_bricks.rho");
  struct Choice {
    std::vector<std::string> words;
    std::string method;
  };
  const std::vector<Choice> choices{{{"ball.rho", "--accuracy", "preview"}, "preview"},
                                    {{"ball.rho"}, "float"},
                                    {{"ball.rho", "--accuracy", "double"}, "double"},
                                    {{"ball.rho", "--method", "bracketed"}, "double"},
                                    {{"ball.rho", "--mode", "mip"}, "double"},
                                    {{"sparse.rho"}, "float"},
                                    {{"small_bricks.rho"}, "double"},
                                    {{"box.rho", "--mode", "iso"}, "float"},
                                    {{"box.rho", "--mode", "iso", "--accuracy", "double"}, "double"},
                                    {{"box.rho", "--method", "edges:float"}, "float"},
                                    {{"ball.rho", "--accuracy", "certified"}, "certified"},
                                    {{"ball.rho", "--accuracy", "exact"}, "exact"},
                                    {{"ball.rho", "--method", "paper"}, "paper:double"},
                                    {{"ball.rho", "--method", "sampled:0.25+bisect"}, "sampled:0.25+bisect"},
                                    {{"ball.rho", "--mode", "mip", "--accuracy", "certified"}, "certified"},
                                    {{"ball.rho", "--mode", "mip", "--method", "sampled:0.5"}, "sampled:0.5+linear"},
                                    {{"box.rho", "--accuracy", "certified"}, "certified"},
                                    {{"box.rho", "--accuracy", "exact"}, "exact"},
                                    {{"box.rho", "--method", "slack:1e-12"}, "slack:1e-12:double"},
                                    {{"box.rho", "--method", "sampled:0.1"}, "sampled:0.1+linear"},
                                    {{"box.rho", "--mode", "mip", "--accuracy", "exact"}, "exact"}};
  std::map<std::string, std::vector<int>> hits;  // of the same picture
  for (const Choice& choice : choices) {
    SCOPED_TRACE(testing::PrintToString(choice.words));
    std::vector<std::string> words{"render"};
    words.insert(words.end(), choice.words.begin(), choice.words.end());
    words.insert(words.end(), {"--size", "40x30", "--antialias", "1", "-o", "p.png", "--json"});
    const RunResult result = bench.rhoray(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json json = nlohmann::json::parse(result.out);
    const std::string machine = json["statistics"]["machine"];
    EXPECT_THAT(result.err, HasSubstr("p.png: " + choice.method + " by " + machine + " kernels, traced in "));
    EXPECT_EQ(json["method"], choice.method);
    const bool is_proven = choice.method == "certified" || choice.method == "exact";
    EXPECT_EQ(json["statistics"]["largest_error"].is_number(), is_proven);
    const std::uint64_t ruled_out = json["statistics"]["rays_ruled_out"];
    EXPECT_TRUE(choice.method != "exact" || json["statistics"]["rays_judged_exactly"] == 40 * 30 - ruled_out);
    EXPECT_TRUE(!choice.method.starts_with("sampled") || json["statistics"]["samples_taken"] > 0);
    if (const std::vector<std::string> levels = render::accuracy_words();
        std::find(levels.begin(), levels.end(), choice.method) != levels.end())
      hits[choice.words[0] + std::string(json["mode"])].push_back(json["statistics"]["hits"]);
    EXPECT_THAT(std::string(json["reproduce"]), HasSubstr(choice.method));
    const std::string bytes = read_file(bench / "p.png");
    std::filesystem::remove(bench / "p.png");
    ASSERT_EQ(bench.shell(json["reproduce"]).exit_code, 0);
    EXPECT_TRUE(read_file(bench / "p.png") == bytes);
    std::filesystem::remove(bench / "p.png");
  }
  // The levels agree except for pixels at the outline. (The paper's method loses one pixel of
  // fifteen here.)
  for (const auto& [picture, counts] : hits)
    for (const int count : counts) EXPECT_NEAR(count, counts[0], 2) << picture;
}

TEST(AccuracyCommand, keeps_error_roots_iterations_and_cost_in_an_exr) {
  const Workbench bench;
  bench.make_ball();
  const RunResult result =
      bench.rhoray({"render", "ball.rho", "--iso", "100", "--size", "40x30", "--accuracy", "certified", "--channels",
                    "depth,error,roots,iterations,cost", "-o", "p.exr"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ASSERT_EQ(bench
                .rhoray({"render", "ball.rho", "--iso", "100", "--size", "40x30", "--accuracy", "exact", "--channels",
                         "depth", "-o", "truth.exr"})
                .exit_code,
            0);
  const auto file = OIIO::ImageInput::open((bench / "p.exr").string());
  ASSERT_TRUE(file);
  const OIIO::ImageSpec spec = file->spec();
  for (const char* count : {"roots", "iterations", "cost"})
    EXPECT_EQ(spec.channelformat(spec.channelindex(count)), OIIO::TypeDesc::UINT32) << count;
  const auto channel = [](const std::filesystem::path& path, const char* name, auto& out) {
    const auto opened = OIIO::ImageInput::open(path.string());
    const int at = opened->spec().channelindex(name);
    out.resize(40 * 30);
    return opened->read_image(0, 0, at, at + 1, opened->spec().channelformat(at), out.data());
  };
  std::vector<float> error, depth, truth;
  std::vector<std::uint32_t> roots, cost;
  ASSERT_TRUE(channel(bench / "p.exr", "error", error) && channel(bench / "p.exr", "Z", depth) &&
              channel(bench / "p.exr", "roots", roots) && channel(bench / "p.exr", "cost", cost) &&
              channel(bench / "truth.exr", "Z", truth));
  int hits = 0;
  for (std::size_t pixel = 0; pixel < 40 * 30; ++pixel) {
    ASSERT_EQ(std::isinf(depth[pixel]), std::isinf(truth[pixel]));
    EXPECT_EQ(std::isinf(depth[pixel]), std::isnan(error[pixel]));
    EXPECT_EQ(std::isinf(depth[pixel]), roots[pixel] == 0);
    if (std::isinf(depth[pixel])) continue;
    ++hits;
    // Channels are floats.
    EXPECT_LE(std::abs(depth[pixel] - truth[pixel]), error[pixel] + 1e-6F * truth[pixel]);
    EXPECT_GT(cost[pixel], 0U);
  }
  EXPECT_GT(hits, 100);
}

TEST(AccuracyCommand, draws_heat_maps_of_what_a_picture_took) {
  const Workbench bench;
  bench.make_ball();
  for (const char* page : {"error", "roots", "iterations", "cost"}) {
    const RunResult result = bench.rhoray({"render", "ball.rho", "--iso", "100", "--size", "40x30", "--accuracy",
                                           "certified", "--show", page, "-o", "p.png", "--force"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr(std::string(page) + ": "));
    EXPECT_THAT(line_after(result.err, "reproduce: "), HasSubstr(std::string("--show ") + page));
  }
}

TEST(AccuracyCommand, refuses_what_cannot_be_said) {
  const Workbench bench;
  bench.make_ball();
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "ball.rho", "-o", "p.exr", "--size", "4x4"});
    const RunResult result = bench.rhoray(words);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_FALSE(std::filesystem::exists(bench / "p.exr"));
    return result.err;
  };
  EXPECT_THAT(refusal({"--accuracy", "certifed"}), HasSubstr("certified"));
  EXPECT_THAT(refusal({"--method", "papr"}), HasSubstr("paper"));
  EXPECT_THAT(refusal({"--channels", "error"}), HasSubstr("certified or exact"));
  EXPECT_THAT(refusal({"--show", "error"}), HasSubstr("certified or exact"));
}

}  // namespace
}  // namespace rhoray::tests

// Options of packing for files that are packed on the fly: --raw, --spacing, --origin, --time; and
// textures of files that are not packed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr const char* raw_words = "24x24x24:uint8";

/// Expects two pictures without a differing pixel.
void expect_same(const Workbench& bench, const std::string& a, const std::string& b) {
  const RunResult same = bench.rhoray({"compare", a, b, "--fail", "0"});
  EXPECT_EQ(same.exit_code, 0) << a << " " << b << same.out << same.err;
}

/// steps.nii: 4 x 4 x 4 samples at three times; those of time t are t + 10 x.
void make_steps(const Workbench& bench) {
  std::string header(352, '\0');
  const auto put16 = [&](std::size_t at, int value) {
    header[at] = static_cast<char>(value & 255), header[at + 1] = static_cast<char>(value >> 8);
  };
  const auto put_float = [&](std::size_t at, float value) { std::memcpy(header.data() + at, &value, sizeof value); };
  put16(0, 348);
  for (const auto& [at, value] : {std::pair{40, 4}, {42, 4}, {44, 4}, {46, 4}, {48, 3}, {50, 1}, {52, 1}, {54, 1}})
    put16(static_cast<std::size_t>(at), value);
  put16(70, 2), put16(72, 8);
  for (std::size_t at = 76; at < 108; at += 4) put_float(at, 1);
  put_float(108, 352);
  std::memcpy(header.data() + 344, "n+1", 4);
  for (int t = 0; t < 3; ++t)
    for (int i = 0; i < 64; ++i) header += static_cast<char>(t + 10 * (i % 4));
  write_file(bench / "steps.nii", header);
}

TEST(ReadingOptions, draw_samples_without_a_header_as_their_packed_file) {
  const Workbench bench;
  bench.make_ball_raw();
  const std::vector<std::string> read{"--raw", raw_words, "--spacing", "1,1,2", "--origin", "3,4,5"};
  std::vector<std::string> pack{"pack", "ball.raw", "-o", "ball.rho"};
  pack.insert(pack.end(), read.begin(), read.end());
  ASSERT_EQ(bench.rhoray(pack).exit_code, 0);
  ASSERT_EQ(bench.rhoray({"render", "ball.rho", "--size", "64x48", "-o", "packed.exr"}).exit_code, 0);
  std::vector<std::string> render{"render", "ball.raw", "--size", "64x48", "-o", "direct.exr"};
  render.insert(render.end(), read.begin(), read.end());
  const RunResult direct = bench.rhoray(render);
  ASSERT_EQ(direct.exit_code, 0) << direct.err;
  expect_same(bench, "direct.exr", "packed.exr");

  const std::string again = line_after(direct.err, "reproduce: ");
  EXPECT_THAT(again, HasSubstr("--raw 24x24x24:uint8 --spacing 1,1,2 --origin 3,4,5"));
  std::filesystem::rename(bench / "direct.exr", bench / "first.exr");
  const RunResult repeated = bench.shell(again);
  ASSERT_EQ(repeated.exit_code, 0) << repeated.err;
  EXPECT_THAT(repeated.err, Not(HasSubstr("packed ball.raw in"))) << "the copy in the cache is taken";
  expect_same(bench, "direct.exr", "first.exr");

  const RunResult of_picture = bench.rhoray({"render", "first.exr", "-o", "third.exr"});
  ASSERT_EQ(of_picture.exit_code, 0) << of_picture.err;
  expect_same(bench, "first.exr", "third.exr");
}

TEST(ReadingOptions, are_part_of_the_key_in_the_cache) {
  const Workbench bench;
  bench.make_ball_raw();
  const auto packs = [&](const std::string& spacing) {
    const RunResult drawn = bench.rhoray(
        {"render", "ball.raw", "--raw", raw_words, "--spacing", spacing, "--size", "16x16", "--force", "-o", "x.png"});
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    return drawn.err.find("packed ball.raw in") != std::string::npos;
  };
  EXPECT_TRUE(packs("1,1,1"));
  EXPECT_TRUE(packs("1,1,2"));
  EXPECT_FALSE(packs("1,1,1"));
  EXPECT_FALSE(packs("1,1,2"));
  EXPECT_THAT(bench.rhoray({"cache", "--json"}).out, HasSubstr("--raw 24x24x24:uint8 --spacing 1,1,2"));
}

TEST(ReadingOptions, choose_a_time_step) {
  const Workbench bench;
  make_steps(bench);
  const auto largest = [&](const std::string& time) {
    const RunResult info = bench.rhoray({"info", "steps.nii", "--time", time, "--json"});
    EXPECT_EQ(info.exit_code, 0) << info.err;
    return Json::parse(info.out)["fields"][0]["range"][1].get<double>();
  };
  EXPECT_EQ(largest("first"), 30);
  EXPECT_EQ(largest("#1"), 31);
  EXPECT_EQ(largest("last"), 32);
  const Json drawn = bench.drawn({"steps.nii", "--time", "last", "--mode", "mip", "--range", "0,32", "-o", "last.png"});
  EXPECT_THAT(drawn["reproduce"].get<std::string>(), HasSubstr("--time last"));
  EXPECT_EQ(drawn["scene"]["data"]["data"]["time"], "last");
  const Json measured =
      Json::parse(bench.rhoray({"measure", "steps.nii", "--time", "#1", "--iso", "31", "--json"}).out);
  EXPECT_NEAR(measured["volume"].get<double>(), 0, 1e-9) << "no value is above 31 at this time";
}

TEST(ReadingOptions, serve_every_subcommand_that_packs_on_the_fly) {
  const Workbench bench;
  bench.make_ball_raw();
  const std::vector<std::vector<std::string>> all{
      {"info", "ball.raw"},
      {"export", "ball.raw", "-o", "ball.vti"},
      {"measure", "ball.raw", "--iso", "100"},
      {"validate", "ball.raw", "--iso", "100", "--samples", "50"},
      {"bench", "open", "ball.raw", "--repeat", "1"},
      {"bench", "pack", "ball.raw", "--repeat", "1"},
      {"accuracy", "ball.raw", "--iso", "100", "--size", "16x16", "--time-limit", "5", "-o", "report"}};
  for (std::vector<std::string> words : all) {
    words.insert(words.end(), {"--raw", raw_words});
    const RunResult result = bench.rhoray(words);
    EXPECT_EQ(result.exit_code, 0) << words[0] << result.err;
  }
}

TEST(ReadingOptions, are_refused_where_they_have_no_meaning) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box_vtu();
  write_file(bench / "open.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  write_file(bench / "scene.json", R"({"data": {"b": {"file": "ball.rho"}}, "layers": [{"type": "mip"}]})");
  struct Case {
    std::vector<std::string> words;
    std::string message;
  };
  const Case cases[] = {
      {{"ball.rho", "--time", "last"}, "--time: only for files that are not packed, but ball.rho is a packed file"},
      {{"ball.rho", "--spacing", "1,1,1"}, "--spacing: only for files that are not packed"},
      {{"ball.rho", "--raw", raw_words}, "--raw: only for files that are not packed, but ball.rho is a packed file"},
      {{"box.vtu", "--raw", "2x2x2:uint8"}, "--raw: box.vtu begins with a header (VTK XML)"},
      {{"box.vtu", "--spacing", "1,1,1"}, "--spacing: only for volumes, but box.vtu is a mesh"},
      {{"open.off", "--time", "last"}, "--time: open.off is a surface, which has no time steps"},
      {{"ball.raw", "--raw", "24x24:uint8"}, "24x24:uint8"},
  };
  for (const Case& one : cases)
    for (const std::string subcommand : {"render", "info", "measure", "accuracy"}) {
      std::vector<std::string> words{subcommand};
      words.insert(words.end(), one.words.begin(), one.words.end());
      if (subcommand == "accuracy") words.insert(words.end(), {"-o", "out"});
      const RunResult result = bench.rhoray(words);
      EXPECT_EQ(result.exit_code, 2) << subcommand << result.err;
      EXPECT_THAT(result.err, HasSubstr(one.message)) << subcommand;
    }
  const RunResult scene = bench.rhoray({"render", "scene.json", "--time", "last", "-o", "x.png"});
  EXPECT_EQ(scene.exit_code, 2);
  EXPECT_THAT(scene.err, HasSubstr("--time: not allowed with the scene scene.json"));
  EXPECT_THAT(scene.err, HasSubstr("set \"time\" in the document's data"));
}

TEST(ReadingOptions, are_keys_of_scene_documents) {
  const Workbench bench;
  bench.make_ball();
  write_file(bench / "scene.json", R"({"data": {"b": {"file": "ball.raw", "raw": "24x24x24:uint8"}},
                                       "layers": [{"type": "mip"}], "image": {"size": [64, 48]}})");
  const RunResult drawn = bench.rhoray({"render", "scene.json", "-o", "a.exr"});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  ASSERT_EQ(bench.rhoray({"render", "ball.rho", "--mode", "mip", "--size", "64x48", "-o", "b.exr"}).exit_code, 0);
  expect_same(bench, "a.exr", "b.exr");
}

TEST(Textures, of_files_that_are_not_packed_are_packed_once) {
  const Workbench bench;
  bench.make_ball();
  bench.make_photo();
  const std::vector<std::string> shown{"render", "ball.rho", "--iso", "100", "--size", "64x48", "--force"};
  const auto draw = [&](const std::string& texture, const std::string& output) {
    std::vector<std::string> words = shown;
    words.insert(words.end(), {"--texture", texture, "-o", output});
    RunResult result = bench.rhoray(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result;
  };
  draw("photo.rho", "packed.exr");
  const RunResult first = draw("photo.nrrd", "direct.exr");
  EXPECT_THAT(first.err, HasSubstr("packed photo.nrrd in"));
  expect_same(bench, "direct.exr", "packed.exr");
  const RunResult second = draw("photo.nrrd", "direct.exr");
  EXPECT_THAT(second.err, Not(HasSubstr("packed photo.nrrd in")));
  const std::string again = line_after(second.err, "reproduce: ");
  EXPECT_THAT(again, HasSubstr("--texture photo.nrrd"));
  ASSERT_EQ(bench.shell(again + " --force").exit_code, 0);
  expect_same(bench, "direct.exr", "packed.exr");
}

}  // namespace
}  // namespace rhoray::tests

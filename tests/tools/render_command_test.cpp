#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

struct ReadPicture {
  OIIO::ImageSpec spec;
  std::vector<float> pixels;

  std::size_t channel(const std::string& name) const { return static_cast<std::size_t>(spec.channelindex(name)); }
  float at(int x, int y, const std::string& name) const {
    return pixels[static_cast<std::size_t>(y * spec.width + x) * static_cast<std::size_t>(spec.nchannels) +
                  channel(name)];
  }
};

ReadPicture read_picture(const std::filesystem::path& path) {
  const auto file = OIIO::ImageInput::open(path.string());
  if (!file) throw std::runtime_error(OIIO::geterror());
  ReadPicture picture{file->spec(), {}};
  picture.pixels.resize(static_cast<std::size_t>(picture.spec.width) * static_cast<std::size_t>(picture.spec.height) *
                        static_cast<std::size_t>(picture.spec.nchannels));
  if (!file->read_image(0, 0, 0, picture.spec.nchannels, OIIO::TypeDesc::FLOAT, picture.pixels.data()))
    throw std::runtime_error(file->geterror());
  return picture;
}

/// The channel 'cell' in whole numbers. Read as float, they would be fractions of the largest one.
std::vector<std::uint32_t> read_cells(const std::filesystem::path& path) {
  const auto file = OIIO::ImageInput::open(path.string());
  if (!file) throw std::runtime_error(OIIO::geterror());
  const OIIO::ImageSpec spec = file->spec();
  std::vector<std::uint32_t> cells(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
  const int channel = spec.channelindex("cell");
  if (!file->read_image(0, 0, channel, channel + 1, OIIO::TypeDesc::UINT32, cells.data()))
    throw std::runtime_error(file->geterror());
  return cells;
}

TEST(RenderCommand, shows_the_first_field_that_is_not_the_same_everywhere) {
  const Workbench bench;
  preprocess::NeutralMesh mesh = box_mesh({});
  add_point_field(mesh, "flat", [](const Vec3&) { return 1.0; });
  add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  preprocess::export_mesh(mesh, bench / "box.vtu", false);
  ASSERT_EQ(bench.rhoray({"pack", "box.vtu", "--field", "flat,height", "-q"}).exit_code, 0);
  const RunResult result = bench.rhoray({"render", "box.rho", "--size", "64x48", "-o", "box.png"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("field 'flat' is constant; showing field 'height'"));
  EXPECT_THAT(line_after(result.err, "reproduce: "), HasSubstr("--field height"));
  EXPECT_EQ(bench.rhoray({"render", "box.rho", "--mode", "iso", "--field", "flat", "-o", "flat.png"}).exit_code, 2);
}

TEST(RenderCommand, says_which_cell_a_pixel_shows) {
  const Workbench bench;
  bench.make_box();
  const std::vector<std::string> look{"render", "box.rho", "--iso", "0.3", "--field",
                                      "height", "--size",  "64x48", "-o",  "cells.exr"};
  std::vector<std::string> with_channel = look, with_pick = look;
  with_channel.insert(with_channel.end(), {"--channels", "cell"});
  ASSERT_EQ(bench.rhoray(with_channel).exit_code, 0);
  const std::uint32_t shown = read_cells(bench / "cells.exr")[24 * 64 + 32];
  with_pick.back() = "box.png";
  with_pick.insert(with_pick.end(), {"--pick", "32,24:0,0"});
  const RunResult text = bench.rhoray(with_pick);
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("), cell " + std::to_string(shown) + ", value 0.3, depth "));
  EXPECT_THAT(text.out, HasSubstr("pixel 0,0: no hit"));
  with_pick.push_back("--json");
  with_pick.push_back("--force");
  const nlohmann::json json = nlohmann::json::parse(bench.rhoray(with_pick).out);
  EXPECT_EQ(json["picks"][0]["cell"], shown);
  // The surface lies where the height z is 0.3; depths are floats.
  EXPECT_NEAR(json["picks"][0]["position"][2].get<double>(), 0.3, 1e-5);
  EXPECT_TRUE(json["picks"][1]["cell"].is_null());
  with_pick[with_pick.size() - 3] = "64,0";
  EXPECT_THAT(bench.rhoray(with_pick).err, HasSubstr("found pixel 64,0; expected one below 64,48"));
  with_pick[with_pick.size() - 3] = "3;4";
  EXPECT_EQ(bench.rhoray(with_pick).exit_code, 2);
}

TEST(RenderCommand, draws_a_ball_in_the_middle_of_an_off_white_picture) {
  const Workbench bench;
  bench.make_ball();
  const RunResult result = bench.rhoray({"render", "ball.rho", "--iso", "100", "--size", "96x64", "-o", "ball.png"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  const ReadPicture picture = read_picture(bench / "ball.png");
  EXPECT_EQ(picture.spec.width, 96);
  EXPECT_EQ(picture.spec.height, 64);
  EXPECT_EQ(picture.spec.nchannels, 3);
  EXPECT_EQ(picture.spec.format, OIIO::TypeDesc::UINT8);
  for (const auto& [channel, background] : {std::pair{"R", 0xf4}, {"G", 0xf4}, {"B", 0xf2}}) {
    EXPECT_FLOAT_EQ(picture.at(0, 0, channel), static_cast<float>(background) / 255);
    EXPECT_FLOAT_EQ(picture.at(95, 63, channel), static_cast<float>(background) / 255);
    EXPECT_LT(picture.at(48, 32, channel), 0.98);
    EXPECT_GT(picture.at(48, 32, channel), 0.2);
  }
}

TEST(RenderCommand, ends_with_a_command_that_makes_the_same_bytes_again_and_keeps_it_in_the_picture) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  // A name that a shell would split.
  std::filesystem::rename(bench / "box.rho", bench / "a box.rho");
  const std::vector<std::vector<std::string>> choices = {
      {"ball.rho", "-o", "p.png", "--iso", "auto"},
      {"ball.rho", "-o", "p.png", "--iso", "p90", "--view", "-x", "--zoom", "1.7", "--surface-color", "#336699"},
      {"ball.rho", "-o", "p.exr", "--ortho", "--azimuth", "33.3", "--elevation", "-71.7", "--channels",
       "value,cell,normal,depth"},
      {"ball.rho", "-o", "p.png", "--mode", "mip", "--method", "face", "--range", "10,200.5", "--background",
       "0.1,0.2,0.3"},
      {"ball.rho", "-o", "p.png", "--mode", "mip", "--no-hierarchy"},
      {"a box.rho", "-o", "p.png", "--field", "length", "--specular", "0", "--fov", "45"},
      {"a box.rho", "-o", "p.tif", "--camera-position", "3,2,1", "--camera-target", "0.5,0.5,0.5", "--camera-up",
       "0,1,0"},
      {"a box.rho", "-o", "p.exr", "--mode", "mip"},
      {"ball.rho", "-o", "p.png", "--style", "fast", "--iso", "100"},
      {"ball.rho", "-o", "p.png", "--style", "paper", "--specular", "0.3", "--view", "front"},
      {"ball.rho", "-o", "p.png", "--style", "presentation", "--up", "y", "--normals", "exact"}};
  struct Drawn {
    std::filesystem::path picture;
    std::string command;
    std::string bytes;
  };
  std::vector<Drawn> drawn;
  for (const std::vector<std::string>& choice : choices) {
    SCOPED_TRACE(testing::PrintToString(choice));
    std::vector<std::string> words{"render", "--size", "40x30"};
    words.insert(words.end(), choice.begin(), choice.end());
    const RunResult result = bench.rhoray(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::filesystem::path picture = bench / choice[2];
    const std::string command = line_after(result.err, "reproduce: ");
    EXPECT_TRUE(result.err.ends_with(command + "\n")) << "it is the last line";
    const bool keeps_any_name = picture.extension() != ".tif";
    EXPECT_EQ(read_picture(picture).spec.get_string_attribute(keeps_any_name ? "rhoray:command" : "ImageDescription"),
              command);
    EXPECT_THAT(read_picture(picture).spec.get_string_attribute("Software"), testing::StartsWith("rhoray "));
    drawn.push_back({picture, command, read_file(picture)});
    std::filesystem::remove(picture);
  }

  // A time of writing in the file would show.
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  for (const Drawn& first : drawn) {
    SCOPED_TRACE(first.command);
    const RunResult again = bench.shell(first.command);
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_EQ(line_after(again.err, "reproduce: "), first.command);
    EXPECT_TRUE(read_file(first.picture) == first.bytes);
    std::filesystem::remove(first.picture);
  }
}

TEST(RenderCommand, keeps_depth_normal_value_and_cell_in_an_exr) {
  const Workbench bench;
  bench.make_ball();
  const RunResult result = bench.rhoray({"render", "ball.rho", "--iso", "127.5", "--size", "65x65", "--view", "-y",
                                         "--camera-position", "11.5,-88.5,11.5", "--camera-target", "11.5,11.5,11.5",
                                         "--channels", "depth,normal,value,cell", "-o", "ball.exr"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const ReadPicture picture = read_picture(bench / "ball.exr");
  for (const char* name : {"R", "G", "B", "A", "Z", "N.x", "N.y", "N.z", "value", "cell"})
    ASSERT_GE(picture.spec.channelindex(name), 0) << name;
  EXPECT_EQ(picture.spec.channelformat(picture.spec.channelindex("cell")), OIIO::TypeDesc::UINT32);
  EXPECT_EQ(picture.spec.channelformat(picture.spec.channelindex("Z")), OIIO::TypeDesc::FLOAT);

  // The centre ray meets the surface, six samples before the ball's centre, at a right angle.
  EXPECT_EQ(picture.at(32, 32, "A"), 1);
  EXPECT_NEAR(picture.at(32, 32, "Z"), 94, 0.1);
  EXPECT_NEAR(picture.at(32, 32, "N.y"), -1, 0.01);
  EXPECT_NEAR(picture.at(32, 32, "value"), 127.5, 1e-3);
  const int cell = static_cast<int>(read_cells(bench / "ball.exr").at(32 * 65 + 32));
  EXPECT_EQ(cell % 23, 11);
  EXPECT_EQ(cell / 23 % 23, 5);
  EXPECT_EQ(cell / (23 * 23), 11);

  EXPECT_EQ(read_cells(bench / "ball.exr").front(), 0xffff'ffffU);
  EXPECT_EQ(picture.at(0, 0, "A"), 0);
  EXPECT_EQ(picture.at(0, 0, "R"), 0);
  EXPECT_TRUE(std::isinf(picture.at(0, 0, "Z")));
  EXPECT_TRUE(std::isnan(picture.at(0, 0, "value")));
}

TEST(RenderCommand, shows_the_valley_with_the_strongest_gradient_and_names_the_others) {
  // Three materials: 20 outside, 120 within 18 samples of the centre, 220 within 11, with noise.
  const Workbench bench;
  std::string bytes;
  for (int k = 0; k < 48; ++k)
    for (int j = 0; j < 48; ++j)
      for (int i = 0; i < 48; ++i) {
        const double distance = std::hypot(i - 23.5, j - 23.5, k - 23.5);
        const auto share_inside = [&](double radius) { return std::clamp((radius - distance) / 2 + 0.5, 0.0, 1.0); };
        const int noise = (7 * i + 13 * j + 29 * k) % 17 - 8;
        bytes += static_cast<char>(std::lround(20 + 100 * (share_inside(18) + share_inside(11))) + noise);
      }
  write_file(bench / "scan.raw", bytes);
  const RunResult packed = bench.rhoray({"pack", "scan.raw", "--raw", "48x48x48:uint8", "-o", "scan.rho", "-q"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const RunResult result =
      bench.rhoray({"render", "scan.rho", "--style", "fast", "--size", "32x16", "-o", "scan.png", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["isovalue_from"], "strongest gradient among the histogram's valleys");
  EXPECT_NEAR(json["isovalue"].get<double>(), 70, 8);
  EXPECT_THAT(result.err,
              testing::ContainsRegex("isovalue [0-9.]+ .strongest gradient among the histogram's valleys "
                                     "of field .*; other valley: 1[67][0-9.]+; Otsu's threshold [0-9.]+\n"));
  const RunResult info = bench.rhoray({"info", "scan.rho"});
  EXPECT_THAT(info.out, testing::ContainsRegex("isovalue auto [0-9.]+ .strongest gradient among the histogram's "
                                               "valleys.; other valleys: 1[67][0-9.]+\n"));
}

TEST(RenderCommand, prints_choices_and_statistics_as_json) {
  const Workbench bench;
  bench.make_ball();
  const RunResult result =
      bench.rhoray({"render", "ball.rho", "--style", "fast", "--size", "32x16", "-o", "ball.png", "--json", "--stats"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["mode"], "iso");
  EXPECT_EQ(json["isovalue_from"], "Otsu's threshold");
  EXPECT_THAT(result.err, HasSubstr("isovalue "));
  EXPECT_EQ(json["statistics"]["rays"], 32 * 16);
  EXPECT_GT(json["statistics"]["hits"], 0);
  EXPECT_GT(json["statistics"]["phases_cpu_s"]["traversal"], 0);
  EXPECT_EQ(read_picture(bench / "ball.png").spec.get_string_attribute("rhoray:machine"),
            json["statistics"]["machine"].get<std::string>());
  EXPECT_EQ(json["statistics"]["samples_taken"], 0);
  EXPECT_EQ(json["statistics"]["rays_redone_in_double"], 0);
  EXPECT_EQ(json["statistics"]["rays_judged_exactly"], 0);
  EXPECT_EQ(json["reproduce"], line_after(result.err, "reproduce: "));
}

TEST(RenderCommand, has_styles_whose_choices_single_options_replace) {
  const Workbench bench;
  bench.make_ball();
  const auto scene = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{"render", "ball.rho", "--iso", "100", "--print-scene"};
    words.insert(words.end(), options.begin(), options.end());
    const RunResult result = bench.rhoray(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  };
  struct Row {
    std::string style;
    double specular, white;
    int antialias;
    std::string normals;
  };
  for (const Row& row : {Row{"default", 0.15, 0.9, 8, "smooth"},
                         {"paper", 0.15, 1, 8, "smooth"},
                         {"fast", 0.25, 1, 1, "exact"},
                         {"presentation", 0.15, 0.9, 8, "smooth"}}) {
    const nlohmann::json json = scene({"--style", row.style});
    EXPECT_EQ(json["style"], row.style);
    EXPECT_FALSE(json.contains("lights"));
    EXPECT_EQ(json["layers"][0]["specular"], row.specular);
    EXPECT_EQ(json["layers"][0]["normals"], row.normals);
    EXPECT_EQ(json["image"]["antialias"], row.antialias);
    EXPECT_NEAR(json["image"]["background"][0], row.white, 0.01);
    EXPECT_EQ(json.contains("effects"), row.style == "presentation");
  }
  EXPECT_EQ(scene({}), scene({"--style", "default"}));
  const nlohmann::json other = scene({"--style", "fast", "--antialias", "4", "--specular", "0", "--background", "0,0,1",
                                      "--normals", "smooth", "--shadows"});
  EXPECT_EQ(other["image"]["antialias"], 4);
  EXPECT_EQ(other["layers"][0]["specular"], 0);
  EXPECT_EQ(other["layers"][0]["normals"], "smooth");
  EXPECT_EQ(other["image"]["background"], nlohmann::json({0.0, 0.0, 1.0}));
  EXPECT_EQ(other["lights"].size(), 2U);
  EXPECT_EQ(other["lights"][0]["shadows"], true);
  const nlohmann::json projection = scene({"--mode", "mip", "--style", "paper"});
  EXPECT_EQ(projection["image"]["background"], nlohmann::json({0.0, 0.0, 0.0}));
  EXPECT_EQ(projection["image"]["antialias"], 1);
}

TEST(RenderCommand, looks_from_sides_of_data_that_stand_on_any_axis) {
  const Workbench bench;
  bench.make_ball();
  const auto back = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{"render", "ball.rho", "--iso", "100", "--print-scene"};
    words.insert(words.end(), options.begin(), options.end());
    const nlohmann::json camera = nlohmann::json::parse(bench.rhoray(words).out)["camera"];
    Vec3 way;
    for (int axis = 0; axis < 3; ++axis)
      way[axis] = camera["position"][static_cast<std::size_t>(axis)].get<double>() -
                  camera["target"][static_cast<std::size_t>(axis)].get<double>();
    return way.normalized();
  };
  for (const auto& [options, expected] : {std::pair{std::vector<std::string>{"--view", "front"}, Vec3(0, -1, 0)},
                                          {{"--view", "right"}, Vec3(1, 0, 0)},
                                          {{"--view", "top"}, Vec3(0, 0, 1)},
                                          {{"--view", "front", "--up", "y"}, Vec3(0, 0, 1)},
                                          {{"--view", "top", "--up", "y"}, Vec3(0, 1, 0)},
                                          {{"--view", "-z", "--up", "y"}, Vec3(0, 0, -1)},
                                          {{"--view", "bottom", "--up", "-x"}, Vec3(1, 0, 0)}})
    EXPECT_LT((back(options) - expected).length(), 1e-12) << testing::PrintToString(options);
}

TEST(RenderCommand, has_y_up_in_surfaces_from_ply_and_z_in_others) {
  const Workbench bench;
  bench.make_cube();
  write_file(bench / "tip.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
             "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
  ASSERT_EQ(bench.rhoray({"pack", "tip.ply", "-o", "tip.rho", "-q"}).exit_code, 0);
  const auto up = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{"render", "--print-scene"};
    words.insert(words.end(), options.begin(), options.end());
    return nlohmann::json::parse(bench.rhoray(words).out)["camera"]["up"];
  };
  EXPECT_EQ(up({"tip.rho"}), nlohmann::json({0.0, 1.0, 0.0}));
  EXPECT_EQ(up({"tip.rho", "--up", "z"}), nlohmann::json({0.0, 0.0, 1.0}));
  EXPECT_EQ(up({"cube.rho"}), nlohmann::json({0.0, 0.0, 1.0}));
}

TEST(RenderCommand, colours_and_smooths_a_mesh_when_asked_and_reproduces_it) {
  const Workbench bench;
  bench.make_box();
  const std::vector<std::string> plain{"render", "box.rho", "--field", "length", "--mode", "iso",
                                       "--iso",  "0.9",     "--size",  "48x48",  "--json"};
  const auto with = [&](const std::vector<std::string>& words) {
    std::vector<std::string> all = plain;
    all.insert(all.end(), words.begin(), words.end());
    const RunResult result = bench.rhoray(all);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  };
  const nlohmann::json off = with({"-o", "plain.png"});
  EXPECT_EQ(off["statistics"]["normals_smoothed"], 0);
  EXPECT_EQ(off["statistics"]["colors_looked_up"], 0);
  with({"--normals", "flat", "-o", "flat.exr"});
  with({"--normals", "smooth", "-o", "smooth.exr"});
  const nlohmann::json on = with(
      {"--normals", "smooth", "--color-by", "height", "--colormap", "coolwarm", "--range", "0.1,0.8", "-o", "on.exr"});
  EXPECT_GT(on["statistics"]["hits"], 100);
  EXPECT_EQ(on["statistics"]["normals_smoothed"], on["statistics"]["colors_looked_up"]);
  EXPECT_GE(on["statistics"]["colors_looked_up"], on["statistics"]["hits"]);
  EXPECT_NE(read_picture(bench / "flat.exr").pixels, read_picture(bench / "smooth.exr").pixels);
  EXPECT_NE(read_picture(bench / "smooth.exr").pixels, read_picture(bench / "on.exr").pixels);
  const std::string reproduce = on["reproduce"];
  EXPECT_THAT(reproduce, HasSubstr("--normals smooth --color-by height --colormap coolwarm --range 0.1,0.8"));
  const std::vector<float> first = read_picture(bench / "on.exr").pixels;
  ASSERT_EQ(bench.shell(reproduce + " --force").exit_code, 0);
  EXPECT_EQ(read_picture(bench / "on.exr").pixels, first);
}

TEST(RenderCommand, refuses_looks_that_do_not_apply) {
  const Workbench bench;
  bench.make_box();
  bench.make_ball();
  const auto refused = [&](std::vector<std::string> words, const std::string& reason) {
    words.insert(words.begin(), "render");
    const RunResult result = bench.rhoray(words);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr(reason));
  };
  refused({"ball.rho", "--normals", "flat"}, "'flat' applies only to meshes, and ball.rho is a grid");
  refused({"box.rho", "--normals", "exact"}, "'exact' applies only to grids, and box.rho is a mesh");
  refused({"box.rho", "--normals", "round"}, "flat");
  refused({"box.rho", "--color-by", "heigth"}, "did you mean height?");
  refused({"box.rho", "--mode", "iso", "--colormap", "gray"}, "needs --color-by");
  refused({"box.rho", "--surface-color", "red", "--colormap", "gray"}, "needs --color-by");
  refused({"box.rho", "--mode", "mip", "--normals", "flat"}, "--normals: needs an isosurface");
  refused({"box.rho", "--mode", "mip", "--color-by", "height"}, "--color-by: needs an isosurface");
}

TEST(RenderCommand, says_nothing_when_quiet_and_shows_progress_when_asked) {
  const Workbench bench;
  bench.make_ball();
  const RunResult quiet = bench.rhoray({"render", "ball.rho", "--size", "8x8", "-o", "a.png", "-q"});
  EXPECT_EQ(quiet.out + quiet.err, "");
  const RunResult plain = bench.rhoray({"render", "ball.rho", "--size", "8x8", "-o", "b.png", "--progress", "plain"});
  EXPECT_THAT(plain.err, HasSubstr("tracing\n"));
  const RunResult json =
      bench.rhoray({"pack", "ball.raw", "--raw", "24x24x24:uint8", "-o", "c.rho", "--progress", "json"});
  EXPECT_EQ(nlohmann::json::parse(json.err.substr(0, json.err.find('\n'))).at("phase"), "reading");
}

TEST(RenderCommand, warns_of_an_empty_picture_and_still_writes_it) {
  const Workbench bench;
  bench.make_ball();
  const RunResult away = bench.rhoray({"render", "ball.rho", "--camera-position", "0,-99,0", "--camera-target",
                                       "0,-200,0", "--size", "8x8", "-o", "away.png"});
  EXPECT_EQ(away.exit_code, 0);
  EXPECT_THAT(away.err, HasSubstr("the picture is empty"));
  EXPECT_TRUE(std::filesystem::exists(bench / "away.png"));
}

TEST(RenderCommand, draws_a_damaged_file_only_when_told_not_to_check) {
  const Workbench bench;
  bench.make_ball();
  std::string bytes = read_file(bench / "ball.rho");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_file(bench / "ball.rho", bytes);
  EXPECT_EQ(bench.rhoray({"render", "ball.rho", "--size", "8x8"}).exit_code, 4);
  EXPECT_FALSE(std::filesystem::exists(bench / "ball.png"));
  EXPECT_EQ(bench.rhoray({"render", "ball.rho", "--size", "8x8", "--no-verify"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(bench / "ball.png"));
}

TEST(RenderCommand, says_which_options_have_no_effect) {
  const Workbench bench;
  bench.make_ball();
  const auto drawn = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "ball.rho", "--size", "16x16", "-o", "a.png", "--force"});
    return bench.rhoray(words);
  };
  const std::string no_surface = "lights and occlusion have no effect: no layer is a surface";
  EXPECT_THAT(drawn({"--mode", "mip", "--shadows"}).err, HasSubstr(no_surface));
  EXPECT_THAT(drawn({"--slice", "x", "--ao"}).err, HasSubstr(no_surface));
  EXPECT_THAT(drawn({"--iso", "100", "--ao"}).err, testing::Not(HasSubstr("no effect")));
  EXPECT_THAT(drawn({"--mode", "mip"}).err, testing::Not(HasSubstr("no effect")));
  EXPECT_THAT(drawn({"--iso", "100", "--ortho-height", "60", "--zoom", "3"}).err, HasSubstr("zoom has no effect"));
  const RunResult opacity = drawn({"--mode", "mip", "--opacity", "0.2"});
  EXPECT_EQ(opacity.exit_code, 2);
  EXPECT_THAT(opacity.err, HasSubstr("--opacity: needs an isosurface"));
}

/// One value of a million among values of 0 to 1: percentiles say little, and the command says so.
TEST(RenderCommand, says_how_well_it_knows_a_default_range) {
  const Workbench bench;
  std::vector<float> values(16 * 16 * 16);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 100) / 100;
  values[700] = 1e6F;
  write_file(bench / "far.raw",
             std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]));
  const auto drawn = [&](std::vector<std::string> words) {
    words.insert(words.begin(),
                 {"render", "far.raw", "--raw", "16x16x16:float32", "--size", "16x16", "-o", "a.png", "--force"});
    return bench.rhoray(words).err;
  };
  EXPECT_THAT(drawn({"--mode", "mip"}), HasSubstr("is known to within 3.9e+03 only; --range sets another"));
  EXPECT_THAT(drawn({"--mode", "mip", "--range", "0,1"}), testing::Not(HasSubstr("is known to within")));
  EXPECT_THAT(drawn({"--iso", "p95"}), HasSubstr("; to within 3.9e+03, a bin of the histogram"));
  EXPECT_THAT(bench.rhoray({"info", "far.raw", "--raw", "16x16x16:float32"}).out,
              HasSubstr("; each to within 3.9e+03"));
}

}  // namespace
}  // namespace rhoray::tests

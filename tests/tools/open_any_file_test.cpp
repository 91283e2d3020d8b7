#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <iterator>
#include <nlohmann/json.hpp>

#include "formats/base/error.h"
#include "tests/tools/workbench.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

/// ball.nrrd: ball.raw with a header.
void make_ball_nrrd(const Workbench& bench) {
  bench.make_ball_raw();
  write_file(bench / "ball.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n\n" + read_file(bench / "ball.raw"));
}

/// Each is drawn twice: from the file, and from what `pack` makes of it.
TEST(OpenAnyFile, draws_what_the_packed_file_shows) {
  const Workbench bench;
  make_ball_nrrd(bench);
  bench.make_box_vtu();
  write_file(bench / "open.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  for (const std::string name : {"ball.nrrd", "box.vtu", "open.off"}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(bench.rhoray({"pack", name, "-o", "packed.rho", "--force", "-q"}).exit_code, 0);
    const RunResult direct = bench.rhoray({"render", name, "--size", "64x48", "-o", "direct.exr", "--force"});
    EXPECT_EQ(direct.exit_code, 0) << direct.err;
    EXPECT_THAT(direct.err, HasSubstr("packed " + name + " in "));
    const RunResult packed = bench.rhoray({"render", "packed.rho", "--size", "64x48", "-o", "packed.exr", "--force"});
    EXPECT_EQ(packed.exit_code, 0) << packed.err;
    const RunResult same = bench.rhoray({"compare", "direct.exr", "packed.exr", "--fail", "0"});
    EXPECT_EQ(same.exit_code, 0) << same.out << same.err;
  }
}

TEST(OpenAnyFile, says_of_pictures_that_hold_no_scene_which_ones_do) {
  const Workbench bench;
  bench.make_ball();
  for (const std::string name : {"p.tif", "p.jpg"}) {
    ASSERT_EQ(bench.rhoray({"render", "ball.rho", "--iso", "100", "--size", "32x32", "-o", name}).exit_code, 0);
    const RunResult refused = bench.rhoray({"render", name, "-o", "q.png"});
    EXPECT_EQ(refused.exit_code, 7) << refused.err;
    EXPECT_THAT(refused.err, HasSubstr("`rhoray render` takes scenes from PNG and EXR pictures only"));
  }
  EXPECT_THAT(bench.rhoray({"render", "--help"}).out, HasSubstr("(.png, .exr)"));
}

TEST(OpenAnyFile, packs_once_and_says_so_in_one_line) {
  const Workbench bench;
  make_ball_nrrd(bench);
  const RunResult first = bench.rhoray({"render", "ball.nrrd", "--size", "32x32"});
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.err, HasSubstr("packed ball.nrrd in "));
  EXPECT_THAT(first.err, HasSubstr("kept in the cache"));
  EXPECT_TRUE(std::filesystem::exists(bench / "ball.png"));
  const RunResult second = bench.rhoray({"render", "ball.nrrd", "--size", "32x32", "--force"});
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.err, Not(HasSubstr("packed ball.nrrd")));
  EXPECT_THAT(line_after(second.err, "reproduce: "), HasSubstr("rhoray render ball.nrrd"));
  const RunResult without = bench.rhoray({"render", "ball.nrrd", "--size", "32x32", "--force", "--no-cache"});
  EXPECT_EQ(without.exit_code, 0) << without.err;
  EXPECT_THAT(without.err, HasSubstr("in memory"));
}

TEST(OpenAnyFile, packs_once_for_a_scene_that_later_names_the_field) {
  const Workbench bench;
  make_ball_nrrd(bench);
  int packed = 0;
  const tools::DataAccess access{.use_cache = false,
                                 .say = [&](const std::string& line) { packed += line.starts_with("packed "); },
                                 .opened = std::make_shared<tools::DataAccess::Opened>()};
  const std::string field = tools::load_shown(bench / "ball.nrrd", {}, access).field().name;
  EXPECT_EQ(tools::load_shown(bench / "ball.nrrd", field, access).field().name, field);
  EXPECT_EQ(packed, 1);
}

/// Loaded data keep what was prepared for pictures. So a viewer must not load them again for every
/// choice of colours.
TEST(OpenAnyFile, loads_a_field_once_however_its_layers_are_coloured) {
  const Workbench bench;
  preprocess::NeutralMesh mesh = box_mesh({});
  for (const std::string name : {"x", "y", "z"}) add_point_field(mesh, name, [](const Vec3& p) { return p.length(); });
  preprocess::export_mesh(mesh, bench / "fields.vtu", true);
  const tools::DataAccess access{.opened = std::make_shared<tools::DataAccess::Opened>(),
                                 .loaded = std::make_shared<tools::DataAccess::Loaded>()};
  ASSERT_EQ(bench.rhoray({"pack", "fields.vtu", "-o", "packed.rho", "-q"}).exit_code, 0);
  for (const std::string file : {"fields.vtu", "packed.rho"}) {
    access.opened->clear();
    access.loaded->clear();
    for (const std::string field : {"x", "y"})
      for (const std::string outer : {"", "x", "y", "z"})
        for (const std::string inner : {"", "x", "y", "z", "none"}) {
          render::SceneSpec spec{.data = {{.name = "data", .file = bench / file, .field = field}}};
          for (const auto& [isovalue, color_by] : {std::pair("0.9", outer), std::pair("0.5", inner)})
            spec.layers.push_back(
                {.type = render::LayerType::isosurface, .data = "data", .isovalues = {isovalue}, .color_by = color_by});
          if (inner == "none")
            EXPECT_THROW(tools::resolve_layers(spec, access), Error);
          else
            EXPECT_EQ(tools::resolve_layers(spec, access).datasets[0].field().name, field);
        }
    EXPECT_EQ(access.loaded->size(), 2U) << file;
    EXPECT_EQ(access.opened->size(), 1U) << file;
  }
}

TEST(OpenAnyFile, lists_packed_copies_and_removes_them) {
  const Workbench bench;
  make_ball_nrrd(bench);
  ASSERT_EQ(bench.rhoray({"cache", "--clear"}).exit_code, 0);
  ASSERT_EQ(bench.rhoray({"render", "ball.nrrd", "--size", "16x16", "-q"}).exit_code, 0);
  const auto listed = nlohmann::json::parse(bench.rhoray({"cache", "--json"}).out);
  ASSERT_EQ(listed["entries"].size(), 1U);
  EXPECT_EQ(listed["entries"][0]["input"], std::filesystem::canonical(bench / "ball.nrrd").string());
  EXPECT_EQ(listed["entries"][0]["bytes"], listed["bytes"]);
  EXPECT_THAT(bench.rhoray({"cache"}).out, HasSubstr("ball.nrrd"));
  const RunResult cleared = bench.rhoray({"cache", "--clear", "--json"});
  EXPECT_THAT(cleared.err, HasSubstr("removed 1 packed copy"));
  const auto removed = nlohmann::json::parse(cleared.out, nullptr, false);
  EXPECT_EQ(removed["removed"], listed["entries"]) << cleared.out;
  EXPECT_EQ(removed["entries"].size(), 0U);
  EXPECT_EQ(nlohmann::json::parse(bench.rhoray({"cache", "--json"}).out)["entries"].size(), 0U);
  EXPECT_EQ(bench.shell("RHORAY_CACHE_SIZE=lots rhoray cache").exit_code, 2);
}

TEST(OpenAnyFile, replaces_no_file_that_reading_found) {
  const Workbench bench;
  bench.make_ball_raw();
  const auto header = [](const std::string& data) {
    return "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\ndata file: " + data + "\n";
  };
  for (const char* const name : {"ball.npy", "ball.png", "0.png"}) {
    std::filesystem::copy(bench / "ball.raw", bench / name);
    write_file(bench / (std::string(name) + ".nhdr"), header(name));
  }
  write_file(bench / "ball.nhdr", header("ball.raw"));
  write_file(bench / "frames.json",
             R"({"data": {"b": {"file": "0.png.nhdr"}}, "layers": [{"data": "b", "type": "mip"}],
                 "camera": {"keyframes": [{"time": 0, "view": "front"}, {"time": 1, "view": "back"}]}})");
  std::filesystem::create_symlink("ball.raw", bench / "link.rho");
  bench.make_box_vtu();
  write_file(bench / "pieces.pvtu", R"(<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid>
                                       <Piece Source="box.vtu"/></PUnstructuredGrid></VTKFile>)");
  const std::map<std::string, std::string> before = bench.contents();
  for (const char* const line :
       {"pack ball.nhdr -o ball.raw", "pack ball.nhdr -o link.rho", "export ball.npy.nhdr -o ball.npy",
        "render --no-cache ball.png.nhdr -o ball.png", "render ball.png.nhdr -o ball.png",
        "render frames.json --frames 2 -o %d.png", "import pieces.pvtu -o box.vtu"})
    for (int i = 0; i < 2; ++i) {  // packed, and by its packed copy
      const RunResult run = bench.shell(std::string("rhoray ") + line + " --force -q");
      EXPECT_EQ(run.exit_code, 2) << line << run.err;
      EXPECT_THAT(run.err, HasSubstr("is a file of the input; expected another name")) << line;
      EXPECT_TRUE(bench.contents() == before) << line;
    }
  EXPECT_EQ(bench.rhoray({"pack", "ball.nhdr", "-o", "ball.rho", "-q"}).exit_code, 0);
}

TEST(OpenAnyFile, names_a_damaged_packed_copy_and_its_remedy) {
  const Workbench bench;
  make_ball_nrrd(bench);
  ASSERT_EQ(bench.rhoray({"render", "ball.nrrd", "--size", "16x16", "-q"}).exit_code, 0);
  const std::filesystem::path folder = std::filesystem::path(std::getenv("XDG_CACHE_HOME")) / "rhoray";
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".rho") {
      std::string bytes = read_file(entry.path());
      bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
      write_file(entry.path(), bytes);
    }
  for (const char* const line :
       {"render ball.nrrd --size 16x16 -o x.png", "export ball.nrrd -o x.vti", "measure ball.nrrd"}) {
    const RunResult damaged = bench.shell(std::string("rhoray ") + line);
    EXPECT_EQ(damaged.exit_code, 4) << line;
    EXPECT_THAT(damaged.err, HasSubstr("the packed copy of ball.nrrd: bytes ")) << line;
    EXPECT_THAT(damaged.err, HasSubstr("`rhoray cache --clear` removes it")) << line;
  }
  ASSERT_EQ(bench.rhoray({"cache", "--clear"}).exit_code, 0);
  EXPECT_EQ(bench.rhoray({"render", "ball.nrrd", "--size", "16x16", "-o", "x.png"}).exit_code, 0);
}

TEST(OpenAnyFile, writes_into_the_working_folder) {
  const Workbench bench;
  std::filesystem::create_directory(bench / "data");
  make_ball_nrrd(bench);
  std::filesystem::rename(bench / "ball.nrrd", bench / "data/ball.nrrd");
  for (const std::string subcommand : {"render", "pack"})
    EXPECT_EQ(bench.rhoray({subcommand, "data/ball.nrrd", "-q"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(bench / "ball.png"));
  EXPECT_TRUE(std::filesystem::exists(bench / "ball.rho"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(bench / "data"), {}), 1);
}

TEST(OpenAnyFile, packs_again_for_a_field_that_packing_leaves_out) {
  const Workbench bench;
  preprocess::NeutralMesh mesh = box_mesh({});
  add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  mesh.point_fields.push_back({"v", "", 3, false, {}});
  for (const auto& p : mesh.points)
    for (const double x : p) mesh.point_fields.back().values.push_back(x);
  preprocess::export_mesh(mesh, bench / "flow.vtu", false);
  const RunResult result = bench.rhoray(
      {"render", "flow.vtu", "--field", "height", "--color-by", "v.x", "--size", "32x32", "-o", "flow.png"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(line_after(result.err, "reproduce: "), HasSubstr("--color-by v.x"));
  const RunResult unknown = bench.rhoray({"render", "flow.vtu", "--field", "heigth", "-o", "x.png"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("heigth"));
  EXPECT_THAT(unknown.err, HasSubstr("height"));
}

TEST(OpenAnyFile, draws_the_scene_of_a_picture) {
  const Workbench bench;
  make_ball_nrrd(bench);
  ASSERT_EQ(bench.rhoray({"render", "ball.nrrd", "--size", "40x30", "--iso", "100", "-o", "a.png", "-q"}).exit_code, 0);
  ASSERT_EQ(bench.rhoray({"render", "ball.nrrd", "--size", "40x30", "--iso", "100", "-o", "a.exr", "-q"}).exit_code, 0);
  for (const std::string name : {"a.png", "a.exr"}) {
    const RunResult again = bench.rhoray({"render", name, "-o", "again.exr", "--force"});
    EXPECT_EQ(again.exit_code, 0) << name << again.err;
    EXPECT_EQ(bench.rhoray({"compare", "a.exr", "again.exr", "--fail", "0"}).exit_code, 0) << name;
  }
}

TEST(OpenAnyFile, shows_several_files_as_layers) {
  const Workbench bench;
  make_ball_nrrd(bench);
  write_file(bench / "open.off", "OFF\n3 1 0\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n");
  const RunResult result = bench.rhoray({"render", "ball.nrrd", "open.off", "--size", "64x48", "--print-scene"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto scene = nlohmann::json::parse(result.out);
  ASSERT_EQ(scene["layers"].size(), 2U);
  EXPECT_EQ(scene["layers"][0]["type"], "isosurface");
  EXPECT_EQ(scene["layers"][1]["type"], "triangles");
}

TEST(OpenAnyFile, writes_a_picture_to_standard_output) {
  const Workbench bench;
  make_ball_nrrd(bench);
  const RunResult piped = bench.rhoray({"render", "ball.nrrd", "--size", "40x30", "-o", "-", "-q"});
  EXPECT_EQ(piped.exit_code, 0) << piped.err;
  EXPECT_TRUE(piped.out.starts_with("\x89PNG"));
  EXPECT_FALSE(std::filesystem::exists(bench / "-"));
  EXPECT_EQ(bench.rhoray({"render", "ball.nrrd", "-o", "-", "--json"}).exit_code, 2);
}

TEST(OpenAnyFile, serves_the_other_subcommands) {
  const Workbench bench;
  make_ball_nrrd(bench);
  EXPECT_EQ(bench.rhoray({"export", "ball.nrrd", "-o", "ball.vti"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(bench / "ball.vti"));
  const RunResult validated = bench.rhoray({"validate", "ball.nrrd", "--iso", "100", "--samples", "100"});
  EXPECT_EQ(validated.exit_code, 0) << validated.err;
  const RunResult measured = bench.rhoray({"bench", "open", "ball.nrrd", "--repeat", "1"});
  EXPECT_EQ(measured.exit_code, 0) << measured.err;
  const RunResult reported =
      bench.rhoray({"accuracy", "ball.nrrd", "--iso", "100", "--size", "16x16", "--time-limit", "5", "-o", "report"});
  EXPECT_EQ(reported.exit_code, 0) << reported.err;
}

}  // namespace
}  // namespace rhoray::tests

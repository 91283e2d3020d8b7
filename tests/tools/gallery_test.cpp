#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/tools/workbench.h"

/// data/gallery: its pictures are those that its commands draw.
namespace rhoray::tests {
namespace {

using Json = nlohmann::json;

const std::filesystem::path data = std::filesystem::path(RHORAY_SOURCE_DIR) / "data";

/// A picture of the gallery's table and its command, to be run in `data`.
struct Row {
  std::string picture;
  std::string command;
};

std::vector<Row> rows_of_the_gallery() {
  std::vector<Row> rows;
  std::istringstream lines(read_file(data / "gallery/README.md"));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| [")) continue;
    const std::string picture = line.substr(3, line.find(']') - 3);
    const auto begin = line.find("`rhoray render scenes/");
    if (begin != std::string::npos)
      rows.push_back({picture, line.substr(begin + 1, line.find('`', begin + 1) - begin - 1)});
    // The path of its data here.
    else if (line.find("`tools/setup/first_light` draws it") != std::string::npos)
      rows.push_back({picture, "rhoray render made/200000-192x192x256/torso-ct.rho --iso 250 -o gallery/" + picture});
    else
      ADD_FAILURE() << "gallery/README.md says no command for " << picture;
  }
  return rows;
}

/// The command that makes a file named by scenes, in the folder where the file belongs. Empty if
/// nothing here makes it. $SHARED is the folder of the shared data.
std::string maker_of(const std::string& file) {
  const std::pair<const char*, const char*> makers[] = {
      {"torso-ct.rho",
       "rhoray-recipes torso-ct --size 192x192x256 -o torso-ct.nhdr && rhoray pack torso-ct.nhdr -o torso-ct.rho -q"},
      {"torso-photo.rho",
       "rhoray-recipes torso-photo -o torso-photo.nhdr && rhoray pack torso-photo.nhdr --color -o torso-photo.rho -q"},
      {"pet.rho", "rhoray pack \"$SHARED/volumes/pet_dicom_299slices.zip\" -o pet.rho -q"},
      {"utahtorso.rho", "rhoray pack \"$SHARED/unstructured/utahtorso/utahtorso-lowres.vtu\" -o utahtorso.rho -q"},
      {"utahtorso-heart.rho",
       "rhoray pack \"$SHARED/unstructured/utahtorso/utahtorso-lowres-heart.ply\" -o utahtorso-heart.rho -q"},
      {"utahtorso-skin.rho",
       "rhoray pack \"$SHARED/unstructured/utahtorso/utahtorso-lowres-skin.ply\" -o utahtorso-skin.rho -q"},
      {"head-ct.rho", "rhoray pack \"$SHARED/volumes/vhf_ct_head/vhf_ct_head.nhdr\" -o head-ct.rho -q"},
      {"mr-head.rho", "rhoray pack \"$SHARED/volumes/MRHeadResampled/MRHeadResampled.nhdr\" -o mr-head.rho -q"},
      {"mr-head-nifti.rho",
       "rhoray export \"$SHARED/volumes/MRHeadResampled/MRHeadResampled.nhdr\" -o mr-head.nii -q && "
       "rhoray pack mr-head.nii -o mr-head-nifti.rho -q"},
      {"indheat.rho", "rhoray pack \"$SHARED/unstructured/gmsh/indheat.bin.v41.msh\" -o indheat.rho -q"},
      {"mixed-mesh.rho", "rhoray pack \"$SHARED/unstructured/mixed_mesh_3d.vtu\" -o mixed-mesh.rho -q"},
      {"wingnut.rho", "rhoray pack \"$SHARED/surfaces/odedstein/wingnut.obj\" -o wingnut.rho -q"},
      {"bracket.rho", "rhoray pack \"$SHARED/unstructured/bracket_appended_compressed.vtu\" -o bracket.rho -q"},
      {"fuel.rho", "rhoray pack \"$SHARED/volumes/fuel.nii.gz\" -o fuel.rho -q"}};
  for (const auto& [name, maker] : makers)
    if (file == name) return maker;
  return {};
}

const char* shared_folder() {
  return std::getenv("RHORAY_SHARED_DATA");
}

/// The data that a row's command names, directly or in a scene document.
struct NamedScene {
  std::vector<std::string> files;  ///< relative to the folder of the scenes

  bool needs_shared_data() const {
    return std::any_of(files.begin(), files.end(), [](const std::string& file) {
      return maker_of(std::filesystem::path(file).filename().string()).find("$SHARED") != std::string::npos;
    });
  }
};

NamedScene scene_of(const Row& row) {
  const auto begin = row.command.find("render ") + 7;
  const std::string named = row.command.substr(begin, row.command.find(' ', begin) - begin);
  if (!named.ends_with(".json")) return {.files = {"../" + named}};
  NamedScene scene;
  const Json document = Json::parse(read_file(data / named));
  for (const Json& entry : document.at("data")) scene.files.push_back(entry.at("file"));
  EXPECT_FALSE(scene.files.empty()) << named;
  return scene;
}

/// Makes the data that a scene needs, beside `scenes`, with the same layout as `data`.
void make_data(const Workbench& bench, const NamedScene& scene) {
  for (const std::string& name : scene.files) {
    const std::filesystem::path file = bench.path() / "scenes" / name;
    if (std::filesystem::exists(file)) continue;
    const std::string maker = maker_of(file.filename().string());
    ASSERT_NE(maker, "") << "maker_of() says nothing of " << file.filename();
    std::filesystem::create_directories(file.lexically_normal().parent_path());
    const RunResult made = bench.shell("SHARED='" + std::string(shared_folder() == nullptr ? "" : shared_folder()) +
                                       "'; cd '" + file.lexically_normal().parent_path().string() + "' && " + maker);
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
}

/// Renders the pictures whose scenes need the shared data, or those whose scenes do not, and
/// compares them.
void expect_the_commands_draw_the_pictures(bool of_shared_data) {
  const Workbench bench;
  std::filesystem::copy(data / "scenes", bench / "scenes");
  std::filesystem::create_directory(bench / "gallery");
  for (const Row& row : rows_of_the_gallery()) {
    SCOPED_TRACE(row.command);
    const NamedScene scene = scene_of(row);
    if (scene.needs_shared_data() != of_shared_data) continue;
    make_data(bench, scene);
    if (testing::Test::HasFatalFailure()) return;
    const RunResult drawn = bench.shell(row.command + " -q");
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
    // Machines differ where rays graze a surface or a shadow's edge, in some pixels by much. JPEG
    // loses a little everywhere, and more near such pixels.
    const bool is_jpeg = row.picture.ends_with(".jpg");
    const RunResult compared =
        bench.rhoray({"compare", (data / "gallery" / row.picture).string(), "gallery/" + row.picture, "--fail",
                      is_jpeg ? "0.05" : "0.01", "--fail-share", "0.002"});
    EXPECT_EQ(compared.exit_code, 0) << compared.out << compared.err;
  }
}

TEST(Gallery, has_a_command_for_every_picture_in_its_folder) {
  std::set<std::string> in_folder, in_table;
  for (const auto& entry : std::filesystem::directory_iterator(data / "gallery"))
    if (entry.is_regular_file() && entry.path().extension() != ".md") in_folder.insert(entry.path().filename());
  for (const Row& row : rows_of_the_gallery())
    EXPECT_TRUE(in_table.insert(row.picture).second) << row.picture << " stands there twice";
  EXPECT_EQ(in_table, in_folder);
}

TEST(Gallery, has_pictures_of_made_data_that_its_commands_draw_again) {
  expect_the_commands_draw_the_pictures(false);
}

TEST(Gallery, has_pictures_of_shared_data_that_its_commands_draw_again) {
  if (shared_folder() == nullptr) GTEST_SKIP() << "RHORAY_SHARED_DATA names no folder";
  expect_the_commands_draw_the_pictures(true);
}

}  // namespace
}  // namespace rhoray::tests

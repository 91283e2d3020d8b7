#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/tools/workbench.h"

/// data/gallery: its pictures are what its commands draw.
namespace rhoray::tests {
namespace {

using Json = nlohmann::json;

const std::filesystem::path data = std::filesystem::path(RHORAY_SOURCE_DIR) / "data";

/// A picture of the gallery's table and the command beside it, said in `data`.
struct Row {
  std::string picture;
  std::string command;
};

std::vector<Row> rows_of_the_gallery() {
  std::vector<Row> rows;
  std::istringstream lines(read_file(data / "gallery/README.md"));
  for (std::string line; std::getline(lines, line);) {
    const auto begin = line.find("`rhoray render scenes/");
    if (!line.starts_with("| [") || begin == std::string::npos) continue;
    rows.push_back({line.substr(3, line.find(']') - 3), line.substr(begin + 1, line.find('`', begin + 1) - begin - 1)});
  }
  return rows;
}

/// How a file that scenes name is made in the folder where it shall lie; empty where nothing here makes it. $SHARED is
/// the folder of the shared data.
std::string maker_of(const std::string& file) {
  const std::pair<const char*, const char*> makers[] = {
      {"torso-ct.rho",
       "rhoray-recipes torso-ct --size 192x192x256 -o torso-ct.nhdr && rhoray pack torso-ct.nhdr -o torso-ct.rho -q"},
      {"pet.rho", "rhoray pack \"$SHARED/volumes/pet_dicom_299slices.zip\" -o pet.rho -q"},
      {"utahtorso.rho", "rhoray pack \"$SHARED/unstructured/utahtorso/utahtorso-lowres.vtu\" -o utahtorso.rho -q"},
      {"utahtorso-heart.rho",
       "rhoray pack \"$SHARED/unstructured/utahtorso/utahtorso-lowres-heart.ply\" -o utahtorso-heart.rho -q"},
      {"utahtorso-skin.rho",
       "rhoray pack \"$SHARED/unstructured/utahtorso/utahtorso-lowres-skin.ply\" -o utahtorso-skin.rho -q"},
      {"head-ct.rho", "rhoray pack \"$SHARED/volumes/vhf_ct_head/vhf_ct_head.nhdr\" -o head-ct.rho -q"}};
  for (const auto& [name, maker] : makers)
    if (file == name) return maker;
  return {};
}

/// Makes what a scene needs, beside `scenes`, as `data` has it.
/// @return  false where the shared data would be needed
bool make_data(const Workbench& bench, const Json& scene) {
  const char* const shared = std::getenv("RHORAY_SHARED_DATA");
  for (const Json& entry : scene["data"]) {
    const std::filesystem::path file = bench.path() / "scenes" / entry["file"].get<std::string>();
    if (std::filesystem::exists(file)) continue;
    const std::string maker = maker_of(file.filename().string());
    EXPECT_NE(maker, "") << "maker_of() says nothing of " << file.filename();
    if (maker.find("$SHARED") != std::string::npos && shared == nullptr) return false;
    std::filesystem::create_directories(file.lexically_normal().parent_path());
    const RunResult made = bench.shell("SHARED='" + std::string(shared == nullptr ? "" : shared) + "'; cd '" +
                                       file.lexically_normal().parent_path().string() + "' && " + maker);
    EXPECT_EQ(made.exit_code, 0) << made.err;
  }
  return true;
}

TEST(Gallery, has_pictures_that_its_commands_draw_again) {
  const Workbench bench;
  std::filesystem::copy(data / "scenes", bench / "scenes");
  std::filesystem::create_directory(bench / "gallery");
  const std::vector<Row> rows = rows_of_the_gallery();
  ASSERT_GE(rows.size(), 4u);
  int drawn_count = 0;
  for (const Row& row : rows) {
    SCOPED_TRACE(row.command);
    ASSERT_TRUE(std::filesystem::exists(data / "gallery" / row.picture));
    const auto begin = row.command.find("scenes/");
    const std::string scene = row.command.substr(begin, row.command.find(' ', begin) - begin);
    if (!make_data(bench, Json::parse(read_file(bench / scene)))) continue;
    const RunResult drawn = bench.shell(row.command + " -q");
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
    // Machines differ where rays graze a surface or a shadow's edge: in some pixels by much. JPEG loses a little
    // everywhere, more beside those.
    const bool is_jpeg = row.picture.ends_with(".jpg");
    const RunResult compared =
        bench.rhoray({"compare", (data / "gallery" / row.picture).string(), "gallery/" + row.picture, "--fail",
                      is_jpeg ? "0.05" : "0.01", "--fail-share", "0.002"});
    EXPECT_EQ(compared.exit_code, 0) << compared.out << compared.err;
    ++drawn_count;
  }
  EXPECT_GE(drawn_count, 2);
}

}  // namespace
}  // namespace rhoray::tests

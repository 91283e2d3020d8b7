#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "tests/support/sanitizers.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

TEST(Road, leads_from_a_recipe_to_pictures_of_a_mesh_and_a_volume) {
  const Workbench bench;
  const auto must = [&](const std::string& line) {
    const RunResult result = bench.shell(line);
    EXPECT_EQ(result.exit_code, 0) << line << "\n" << result.err;
    return result;
  };
  must("rhoray-recipes torso-surface --cells 6000 -o torso.smesh");
  must("rhoray tetrahedralize torso.smesh -o mesh.vtu");
  must("rhoray-recipes torso-potential mesh.vtu -o torso.vtu");
  must("rhoray-recipes torso-ct --size 48x48x64 -o ct.nhdr");
  must("rhoray pack torso.vtu -o torso.rho");
  must("rhoray pack ct.nhdr -o ct.rho");
  must("rhoray verify --deep torso.rho ct.rho");
  for (const std::string scene : {"torso.rho --iso p95", "ct.rho", "ct.rho --mode mip", "torso.rho --mode mip"}) {
    const RunResult drawn = must("rhoray render " + scene + " --size 80x60 --json --force -o x.png");
    if (drawn.exit_code != 0) continue;
    const nlohmann::json json = nlohmann::json::parse(drawn.out);
    EXPECT_GT(json["statistics"]["hits"], 100) << scene;
  }
}

TEST(Road, refuses_to_replace_and_replaces_with_force) {
  const Workbench bench;
  bench.make_ball();
  const std::string before = read_file(bench / "ball.rho");
  const std::vector<std::string> words{"pack",     "ball.raw", "--raw", "24x24x24:uint8",
                                       "--layout", "linear",   "-o",    "ball.rho"};
  EXPECT_EQ(bench.rhoray(words).exit_code, 2);
  EXPECT_TRUE(read_file(bench / "ball.rho") == before);
  std::vector<std::string> with_force = words;
  with_force.push_back("--force");
  EXPECT_EQ(bench.rhoray(with_force).exit_code, 0);
  EXPECT_FALSE(read_file(bench / "ball.rho") == before);
}

TEST(PackCommand, tells_what_it_did_for_people_and_as_json) {
  const Workbench bench;
  bench.make_box_vtu();
  const RunResult result = bench.rhoray({"pack", "box.vtu", "--field", "length,height", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("384 tetrahedra, 125 points, 2 fields"));
  EXPECT_THAT(result.err, HasSubstr("peak memory"));
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["file"], "box.rho");
  EXPECT_EQ(json["file_bytes"], std::filesystem::file_size(bench / "box.rho"));
  EXPECT_EQ(json["description"]["fields"][0]["name"], "length");
  EXPECT_GT(json["worker_peak_bytes"], 0);
}

TEST(PackCommand, takes_its_options_to_heart) {
  const Workbench bench;
  bench.make_ball_raw();
  bench.make_box_vtu();
  const auto info = [&](const std::string& line) {
    const RunResult packed = bench.shell("rhoray pack " + line + " -q --force -o x.rho");
    EXPECT_EQ(packed.exit_code, 0) << packed.err;
    return nlohmann::json::parse(bench.rhoray({"info", "x.rho", "--json"}).out);
  };
  const std::string ball = "ball.raw --raw 24x24x24:uint8";
  EXPECT_EQ(info(ball + " --layout linear")["layout"]["linear"], true);
  EXPECT_EQ(info(ball + " --brick-edge 8")["layout"]["brick_edge"], 8);
  EXPECT_EQ(info(ball + " --type F32")["fields"][0]["type"], "F32");
  const nlohmann::json levels = info(ball + " --levels 2 --factor 3")["macro_levels"];
  EXPECT_EQ(levels["count"], 2);
  EXPECT_EQ(levels["factor"], 3);
  EXPECT_EQ(info("box.vtu --field height")["fields"].size(), 1U);
  const auto leaves = [](const nlohmann::json& json) {
    std::uint64_t count = 1;
    for (const auto& n : json["leaf_cells"]["count"]) count *= n.get<std::uint64_t>();
    return count;
  };
  const std::string box = "box.vtu --structure leaves";
  EXPECT_GT(leaves(info(box + " --leaf-ratio 8")), 4 * leaves(info(box)));
  EXPECT_LT(leaves(info(box + " --cells 30")), leaves(info(box)));
  EXPECT_EQ(info(box + " --levels 2")["macro_levels"]["count"], 2);
  const nlohmann::json clusters = info("box.vtu");
  EXPECT_FALSE(clusters.contains("leaf_cells"));
  EXPECT_EQ(clusters["clusters"]["size"], 64);
  EXPECT_LT(clusters["structure_bytes"], info(box)["structure_bytes"]);
  for (const char* of_lists : {"--leaf-ratio 8", "--cells 30", "--levels 2", "--factor 3"}) {
    const RunResult refused = bench.shell(std::string("rhoray pack box.vtu -q --force -o x.rho ") + of_lists);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, testing::HasSubstr("only for volumes or --structure leaves"));
  }
}

TEST(BenchCommand, fills_its_tables) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  std::filesystem::create_directory(bench / "tables");
  const RunResult all = bench.rhoray({"bench", "ball.rho", "--repeat", "2", "--size", "24x24", "--iso", "60,auto",
                                      "--mip", "--threads", "2", "-o", "tables"});
  ASSERT_EQ(all.exit_code, 0) << all.err;
  const auto table = [&](const std::string& name) {
    return nlohmann::json::parse(read_file(bench / ("tables/" + name + ".json")));
  };

  const nlohmann::json phases = table("phases");
  ASSERT_EQ(phases["rows"].size(), 3U);
  for (const nlohmann::json& row : phases["rows"]) {
    const double sum = row["traversal_percent"].get<double>() + row["intersection_percent"].get<double>() +
                       row["shading_percent"].get<double>();
    EXPECT_NEAR(sum, 100, 1e-6);
    EXPECT_EQ(row["rays"], 24 * 24);
    EXPECT_LE(row["frame_s_min"], row["frame_s"]);
    EXPECT_LE(row["frame_s"], row["frame_s_max"]);
  }
  const nlohmann::json threads = table("threads");
  ASSERT_EQ(threads["rows"].size(), 6U);
  EXPECT_EQ(threads["rows"][0]["picture"], threads["rows"][1]["picture"]) << "one thread and two draw the same";
  EXPECT_EQ(threads["rows"][0]["speedup"], 1.0);
  const nlohmann::json views = table("views");
  ASSERT_EQ(views["rows"].size(), 12U);
  for (const nlohmann::json& row : views["rows"]) {
    EXPECT_GT(row["cycles_per_ray"], 0.0);
    EXPECT_GT(row["covered"], row["view"] == "inside" ? 0.99 : 0.05);
  }
  const nlohmann::json changes = table("isovalue");
  ASSERT_EQ(changes["rows"].size(), 4U) << "a changed isovalue and a changed view of two isosurfaces";
  EXPECT_NE(changes["rows"][0]["picture"], changes["rows"][1]["picture"]);
  for (const nlohmann::json& row : changes["rows"]) {
    EXPECT_LE(row["change_ms_min"], row["change_ms"]);
    EXPECT_LE(row["change_ms"], row["change_ms_max"]);
  }
  for (const char* name : {"phases", "threads", "memory"}) {
    const nlohmann::json filled = table(name);
    for (const nlohmann::json& row : filled["rows"]) EXPECT_FALSE(row["machine"].get<std::string>().empty());
  }
  const nlohmann::json memory = table("memory");
  ASSERT_EQ(memory["rows"].size(), 3U);
  for (const nlohmann::json& row : memory["rows"]) {
    EXPECT_EQ(row["picture_bytes"], 24 * 24 * 16);
    EXPECT_GT(row["beyond_file_and_picture_bytes"], 100'000) << "the program itself: is it counted?";
    if (!sanitized) {  // sanitizers keep memory that was freed
      EXPECT_LT(row["beyond_file_and_picture_bytes"], 64 << 20);
    }
  }
  EXPECT_EQ(table("open")["rows"].size(), 4U);
  for (const char* key : {"processor", "compiler", "commit", "version", "repeat"})
    EXPECT_TRUE(threads["context"].contains(key)) << key;
  EXPECT_THAT(read_file(bench / "tables/phases.csv"), testing::StartsWith("scene,traversal_percent,"));

  const RunResult pack = bench.rhoray({"bench", "pack", "box.vtu", "--repeat", "2", "--json", "--scratch", "."});
  ASSERT_EQ(pack.exit_code, 0) << pack.err;
  const nlohmann::json row = nlohmann::json::parse(pack.out)["rows"][0];
  EXPECT_EQ(row["file_bytes"], std::filesystem::file_size(bench / "box.rho"));
  EXPECT_GT(row["extra_bytes_per_tetrahedron"], 16);
  EXPECT_FALSE(std::filesystem::exists(bench / "rhoray-scratch"));
}

/// Waits until the process, with the workers that it has waited for, has used a third of a second
/// of CPU time. However slow the machine, the process is then in the middle of work that takes many
/// times as long.
void wait_until_it_works(pid_t process) {
  const long ticks_wanted = ::sysconf(_SC_CLK_TCK) / 3;
  for (long ticks = 0; ticks < ticks_wanted;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const std::string stat = read_file("/proc/" + std::to_string(process) + "/stat");
    // What follows is the third field, state.
    std::istringstream fields(stat.substr(stat.rfind(')') + 2));
    std::string field;
    ticks = 0;
    for (int number = 3; fields >> field; ++number) {
      ASSERT_FALSE(number == 3 && field == "Z") << "it has ended";
      // Ticks of the process and of its children.
      if (number >= 14 && number <= 17) ticks += std::stol(field);
    }
  }
}

TEST(Interrupt, ends_with_130_and_leaves_nothing) {
  const Workbench bench;
  bench.make_box();
  const auto before = bench.contents();
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"render", "box.rho", "--size", "8000x8000", "--mode", "mip",
                                              "--no-hierarchy", "--threads", "1", "-o", "x.png"},
                                             {"bench", "pack", "box.vtu", "--repeat", "10000", "--scratch", "."}}) {
    SCOPED_TRACE(words[0]);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      std::vector<char*> arguments{const_cast<char*>(RHORAY_PROGRAM)};
      for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
      arguments.push_back(nullptr);
      const bool ready = ::chdir(bench.path().c_str()) == 0 && ::dup2(::open("/dev/null", O_WRONLY), 2) >= 0;
      if (ready) ::execv(arguments[0], arguments.data());
      ::_exit(127);
    }
    wait_until_it_works(child);
    EXPECT_EQ(::kill(child, SIGINT), 0);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
    EXPECT_EQ(bench.contents(), before);
  }
}

}  // namespace
}  // namespace rhoray::tests

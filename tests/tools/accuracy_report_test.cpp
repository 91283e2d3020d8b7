#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "formats/base/text.h"
#include "tests/tools/workbench.h"
#include "tools/analysis/gnuplot.h"

namespace rhoray::tests {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const std::string small = " --size 80x60 --repeat 1 -q";

/// Rows of a CSV file, by column. Quoted fields contain no line ends here.
std::vector<std::map<std::string, std::string>> csv_rows(const std::string& text) {
  std::vector<std::vector<std::string>> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    std::vector<std::string> fields(1);
    bool is_quoted = false;
    for (const char letter : text.substr(at, end - at))
      if (letter == '"')
        is_quoted = !is_quoted;
      else if (letter == ',' && !is_quoted)
        fields.emplace_back();
      else
        fields.back() += letter;
    lines.push_back(std::move(fields));
    at = end + 1;
  }
  std::vector<std::map<std::string, std::string>> rows;
  for (std::size_t line = 1; line < lines.size(); ++line) {
    EXPECT_EQ(lines[line].size(), lines[0].size());
    for (std::size_t c = 0; c < lines[0].size(); ++c) rows.resize(line), rows.back()[lines[0][c]] = lines[line][c];
  }
  return rows;
}

json row_named(const json& results, const std::string& variant, const std::string& group = {}) {
  for (const json& row : results.at("rows"))
    if (row.at("variant") == variant && (group.empty() || row.at("group") == group)) return row;
  throw std::runtime_error("no row " + variant);
}

json results_of(const Workbench& bench, const std::string& folder) {
  return json::parse(read_file(bench / (folder + "/results.json")));
}

void run_well(const Workbench& bench, const std::string& words) {
  const RunResult run = bench.shell("rhoray accuracy " + words);
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

TEST(AccuracyReport, opens_with_the_picture_a_verdict_and_the_tables_and_says_why_the_paper_misses_pixels) {
  const Workbench bench;
  bench.make_ball();
  // Coefficients so small that the paper's method takes them for 0.
  std::string tiny = "NRRD0004\ntype: float\ndimension: 3\nsizes: 24 24 24\nendian: little\nencoding: raw\n\n";
  for (const char byte : read_file(bench / "ball.raw")) {
    const float value = 1e-14F * static_cast<float>(static_cast<unsigned char>(byte));
    tiny.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  write_file(bench / "tiny.nrrd", tiny);
  run_well(bench, "ball.rho --iso 60 -o usual" + small);
  run_well(bench, "tiny.nrrd --iso 6e-13 -o tiny" + small);
  for (const std::string folder : {"usual", "tiny"}) {
    const std::string page = read_file(bench / (folder + "/report.html"));
    const std::size_t picture = page.find("<figure class=\"reference\">"), verdict = page.find("class=\"verdict\"");
    EXPECT_LT(page.find("href=\"results.csv\""), picture);
    EXPECT_LT(picture, verdict);
    EXPECT_LT(verdict, page.find("All variants"));
    EXPECT_THAT(page, HasSubstr("of the isovalue where the surface is drawn"));
    const json paper = row_named(results_of(bench, folder), "paper:double");
    const bool is_wrong = paper.at("missed").get<int>() + paper.at("false_hits").get<int>() > 0;
    EXPECT_EQ(page.find("It expands the cubic of a cell around the eye") != std::string::npos, is_wrong) << folder;
    if (folder == "tiny") {
      EXPECT_TRUE(is_wrong);
    }
  }
}

TEST(AccuracyReport, measures_a_method_that_is_worse_on_purpose_as_worse) {
  const Workbench bench;
  bench.make_ball();
  run_well(bench, "ball.rho --iso 60 -o out --size 120x90 --repeat 1 -q");
  const json results = results_of(bench, "out");
  const json good = row_named(results, "sampled:0.0625+linear"), bad = row_named(results, "sampled:2+linear");
  for (const char* measure : {"depth_median_cells", "depth_p99_cells", "depth_kept_by_99_cells", "value_median",
                              "value_p99", "normal_median_deg", "normal_p99_deg", "rmse_of_255", "flip"})
    EXPECT_GT(bad.at(measure).get<double>(), good.at(measure).get<double>()) << measure;
  EXPECT_GT(bad.at("missed").get<int>(), good.at("missed").get<int>());
  const json exact = row_named(results, "exact"), large = row_named(results, "1/2 of the size"),
             smaller = row_named(results, "1/4 of the size");
  EXPECT_EQ(exact.at("depth_max_cells"), 0);
  EXPECT_EQ(exact.at("flip"), 0);
  EXPECT_GT(smaller.at("flip").get<double>(), large.at("flip").get<double>());
  EXPECT_TRUE(large.at("depth_p99_cells").is_null()) << "a smaller picture asks other rays";
  for (const json& row : results.at("rows")) EXPECT_EQ(row.at("judged_pixels").is_null(), row.at("missed").is_null());
}

TEST(AccuracyReport, says_the_same_in_csv_and_json_and_explains_every_column) {
  const Workbench bench;
  bench.make_ball();
  run_well(bench, "ball.rho --iso 60 -o out" + small);
  const json results = results_of(bench, "out");
  EXPECT_EQ(results.at("schema"), "rhoray-accuracy 1");
  const auto rows = csv_rows(read_file(bench / "out/results.csv"));
  ASSERT_EQ(rows.size(), results.at("rows").size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const json& row = results.at("rows")[r];
    ASSERT_EQ(row.size(), rows[r].size());
    for (const auto& [name, value] : row.items()) {
      const std::string text = value.is_null() ? "" : value.is_string() ? value.get<std::string>() : value.dump();
      EXPECT_EQ(rows[r].at(name), text) << name;
    }
  }
  ASSERT_EQ(results.at("columns").size(), results.at("rows")[0].size());
  for (const json& column : results.at("columns"))
    EXPECT_TRUE(results.at("rows")[0].contains(column.at("name").get<std::string>())) << column;
  for (const char* fact : {"processor", "compiler", "commit", "command", "seed"})
    EXPECT_TRUE(results.at("context").contains(fact)) << fact;
}

TEST(AccuracyReport, is_one_page_that_sends_for_nothing) {
  const Workbench bench;
  bench.make_ball();
  run_well(bench, "ball.rho --iso 60 -o out" + small);
  const std::string page = read_file(bench / "out/report.html");
  EXPECT_FALSE(std::regex_search(page, std::regex("https?:|@import|url\\([^#]|<script|<link")));
  std::size_t pictures = 0;
  for (std::size_t at = page.find("src="); at != std::string::npos; at = page.find("src=", at + 1), ++pictures)
    EXPECT_EQ(page.substr(at, 27), "src=\"data:image/png;base64,");
  EXPECT_GE(pictures, 9U);
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy\" content=\"default-src 'none'"));
  EXPECT_THAT(page, HasSubstr("The fastest method that is within"));
  EXPECT_THAT(page, HasSubstr("≤ 10<sup>−8</sup> <span class=\"bar\"")) << "the legend of the errors";
  EXPECT_EQ(page.find("{{"), std::string::npos) << "the template is filled";
  EXPECT_THAT(page, HasSubstr("rhoray accuracy ball.rho"));
  if (tools::has_gnuplot()) {
    EXPECT_THAT(page, HasSubstr("<svg"));
    for (const char* plot : {"error_time", "wrong_time", "convergence", "distribution", "flip_time"})
      EXPECT_THAT(read_file(bench / ("out/" + std::string(plot) + ".svg")), HasSubstr("</svg>")) << plot;
  }
}

/// bumps.rho: hills that cast shadows on one another.
void make_bumps(const Workbench& bench) {
  std::string bumps;
  for (int i = 0; i < 24 * 24 * 24; ++i) {
    const double height = 80 * std::sin(0.7 * (i % 24)) * std::sin(0.6 * (i / 24 % 24));
    bumps += static_cast<char>(static_cast<unsigned char>(128 + height - 3 * (i / 576 - 12)));
  }
  write_file(bench / "bumps.raw", bumps);
  ASSERT_EQ(bench.rhoray({"pack", "bumps.raw", "--raw", "24x24x24:uint8", "-o", "bumps.rho", "-q"}).exit_code, 0);
}

TEST(AccuracyReport, repeats_itself_by_its_command) {
  const Workbench bench;
  make_bumps(bench);
  run_well(bench, "bumps.rho --iso 128 --shadows --ao -o out" + small);
  const json first = results_of(bench, "out");
  EXPECT_GT(row_named(first, "1 ray a hit").at("flip"), row_named(first, "256 rays a hit").at("flip"));
  const RunResult again = bench.shell(first.at("context").at("command").get<std::string>() + " --force -q");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const json second = results_of(bench, "out");
  ASSERT_EQ(first.at("rows").size(), second.at("rows").size());
  for (std::size_t r = 0; r < first.at("rows").size(); ++r)
    for (const char* measure : {"variant", "missed", "depth_max_cells", "value_max", "normal_max_deg", "flip"})
      EXPECT_EQ(first.at("rows")[r].at(measure), second.at("rows")[r].at(measure)) << measure;
}

TEST(AccuracyReport, measures_every_effect_of_the_scene_by_its_number_of_samples) {
  const Workbench bench;
  bench.make_ball();
  make_bumps(bench);
  write_file(bench / "scene.json", R"({"data": {"bumps": {"file": "bumps.rho"}, "ball": {"file": "ball.rho"}},
    "layers": [{"type": "isosurface", "data": "bumps", "isovalue": 128},
               {"type": "isosurface", "data": "ball", "isovalue": 200}],
    "lights": [{"type": "directional", "azimuth": 30, "elevation": 40, "shadows": true, "angular_diameter": 20,
                "samples": 4}],
    "effects": {"ambient_occlusion": {"samples": 4, "radius": 6}},
    "image": {"antialias": 4}})");
  run_well(bench, "scene.json -o out" + small);
  const json results = results_of(bench, "out");
  const auto flip = [&](const char* variant) { return row_named(results, variant).at("flip").get<double>(); };
  EXPECT_GT(flip("1 ray a hit"), flip("64 rays a hit"));
  EXPECT_GT(flip("1 sample a pixel"), flip("16 samples a pixel"));
  EXPECT_GE(flip("1 ray to a light"), flip("64 rays to a light"));
  EXPECT_TRUE(row_named(results, "4 rays to a light").at("judged_pixels").is_null()) << "the same places are hit";
  EXPECT_TRUE(std::filesystem::exists(bench / "out/layer1_1_ray_to_a_light_error.png"));
  const std::string page = read_file(bench / "out/report.html");
  EXPECT_THAT(page, HasSubstr("Pictures that differ only in appearance"));
  EXPECT_THAT(page, HasSubstr("Soft shadows with this many rays"));
  run_well(bench, "ball.rho --iso 60 --style fast -o plain" + small);
  const json plain = results_of(bench, "plain");
  for (const json& row : plain.at("rows"))
    EXPECT_THAT(row.at("group").get<std::string>(), testing::Not(HasSubstr("samples"))) << "of a scene without effects";
}

TEST(AccuracyReport, measures_normals_the_other_way_than_the_scene_has_them) {
  const Workbench bench;
  bench.make_box();
  run_well(bench, "box.rho --field length --iso 0.8 --normals smooth -o out --time-limit 30" + small);
  EXPECT_GT(row_named(results_of(bench, "out"), "flat normals").at("normal_p99_deg"), 0);
  EXPECT_THAT(read_file(bench / "out/report.html"), HasSubstr("Smooth and flat normals differ by"));
  bench.make_ball();
  run_well(bench, "ball.rho --iso 100 -o grid --time-limit 30" + small);
  const json row = row_named(results_of(bench, "grid"), "exact normals");
  EXPECT_GT(row.at("normal_p99_deg"), 0);
  EXPECT_LT(row.at("normal_max_deg"), 20);
  EXPECT_THAT(read_file(bench / "grid/report.html"), HasSubstr("Smooth and exact normals differ by"));
}

TEST(AccuracyReport, judges_what_a_clip_region_leaves_and_leaves_slices_out) {
  const Workbench bench;
  bench.make_ball();
  run_well(bench, "ball.rho --iso 60 --clip-box 0,0,0,24,24,12 --slice z=12 -o out" + small);
  const json results = results_of(bench, "out");
  EXPECT_THAT(results.at("notes").dump(), HasSubstr("is a slice"));
  ASSERT_EQ(results.at("layers").size(), 1U);
  for (const char* level : {"double", "certified"}) {
    const json row = row_named(results, level);
    EXPECT_EQ(row.at("missed"), 0) << level;
    EXPECT_EQ(row.at("false_hits"), 0) << level;
    EXPECT_LE(row.at("depth_max_cells"), 1e-3) << level;
    EXPECT_LE(row.at("flip"), 1e-5) << level;
  }
  const RunResult alone = bench.shell("rhoray accuracy ball.rho --slice z=12 -o alone" + small);
  EXPECT_EQ(alone.exit_code, 2) << alone.err;
  EXPECT_THAT(alone.err, HasSubstr("there are no methods to compare"));
}

TEST(AccuracyReport, says_what_its_instruments_cost_and_what_variants_keep_in_memory) {
  const Workbench bench;
  bench.make_ball();
  run_well(bench, "ball.rho --iso 60 -o out" + small);
  const json results = results_of(bench, "out");
  EXPECT_TRUE(results.at("context").at("instruments_share_of_time").is_number());
  EXPECT_GE(results.at("context").at("instruments_noise"), 0);
  EXPECT_GE(results.at("context").at("instruments_pictures"), 3);
  EXPECT_THAT(read_file(bench / "out/report.html"), HasSubstr("changes the CPU time of a picture by"));
  for (const json& row : results.at("rows"))
    if (row.at("times") > 0) {
      EXPECT_GE(row.at("memory_bytes"), row.at("data_bytes")) << row.at("variant");
    }
}

TEST(AccuracyReport, measures_what_is_too_slow_for_pictures_on_random_pixels) {
  const Workbench bench;
  bench.make_ball();
  // 64 samples per cell along 76,800 rays are a hundred million. They need more than the available
  // tenth of a second.
  run_well(bench, "ball.rho --iso 60 -o out --size 320x240 --repeat 1 -q --time-limit 3");
  const json results = results_of(bench, "out"), fine = row_named(results, "sampled:0.015625+linear");
  EXPECT_THAT(fine.at("note").get<std::string>(), HasSubstr("too slow for a picture"));
  EXPECT_LT(fine.at("judged_pixels"), 320 * 240);
  // A busy machine has no time for the exact answer of all pixels either.
  EXPECT_LE(fine.at("judged_pixels"), results.at("layers")[0].at("judged_pixels"));
  EXPECT_GT(fine.at("judged_pixels"), 0);
  EXPECT_LT(fine.at("missed_ppm_low"), fine.at("missed_ppm_high")) << "a sample leaves something open";
  EXPECT_GT(fine.at("cpu_ms"), 0);
  EXPECT_EQ(fine.at("times"), 0);
  EXPECT_TRUE(fine.at("flip").is_null());
  EXPECT_THAT(read_file(bench / "out/report.html"), HasSubstr("≈ "));
}

TEST(AccuracyReport, is_complete_without_gnuplot_and_names_the_package) {
  const Workbench bench;
  bench.make_ball();
  const RunResult run =
      bench.shell("PATH=/nowhere " RHORAY_PROGRAM " accuracy ball.rho --iso 60 -o out --size 80x60 --repeat 1");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(line_after(run.err, "note: no plots"), HasSubstr("gnuplot-nox"));
  const std::string page = read_file(bench / "out/report.html");
  EXPECT_THAT(page, HasSubstr("gnuplot-nox"));
  EXPECT_EQ(page.find("<svg"), std::string::npos);
  EXPECT_EQ(csv_rows(read_file(bench / "out/results.csv")).size(), results_of(bench, "out").at("rows").size());
}

TEST(AccuracyReport, measures_largest_values_and_meshes) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  run_well(bench, "ball.rho --mode mip -o mip" + small);
  const json mip = results_of(bench, "mip");
  EXPECT_EQ(row_named(mip, "exact").at("value_max"), 0);
  EXPECT_LE(row_named(mip, "double").at("value_max"), 1e-9);
  EXPECT_GT(row_named(mip, "sampled:2+linear").at("value_median"),
            row_named(mip, "sampled:0.25+linear").at("value_median"));
  EXPECT_THAT(row_named(mip, "8 bits").at("note").get<std::string>(), HasSubstr("integers of 8 bits"));

  run_well(bench, "box.rho --field length --iso 0.8 -o mesh --time-limit 30" + small);
  const json mesh = results_of(bench, "mesh");
  EXPECT_LE(row_named(mesh, "double").at("depth_max_cells"), 1e-9);
  EXPECT_GT(row_named(mesh, "grid 32").at("depth_median_cells"), row_named(mesh, "grid 128").at("depth_median_cells"));
  EXPECT_GT(row_named(mesh, "grid 32").at("preprocess_s"), 0);
  EXPECT_GT(row_named(mesh, "grid 128").at("memory_bytes"), row_named(mesh, "grid 32").at("memory_bytes"));
  for (const char* size : {"32", "64", "128"})
    EXPECT_EQ(row_named(mesh, concat("OpenVDB ", size)).at("missed"),
              row_named(mesh, concat("grid ", size)).at("missed"))
        << "the same samples";
  EXPECT_GT(row_named(mesh, "8 bits").at("depth_median_cells"), row_named(mesh, "16 bits").at("depth_median_cells"));
  EXPECT_GT(row_named(mesh, "16 bits").at("depth_median_cells"), row_named(mesh, "double").at("depth_median_cells"));
  EXPECT_EQ(row_named(mesh, "smooth normals").at("missed"), nullptr);
  EXPECT_GT(row_named(mesh, "smooth normals").at("normal_p99_deg"), 0);
}

TEST(AccuracyReport, measures_copies_with_fewer_bits_against_the_data_they_are_made_from) {
  const Workbench bench;
  bench.make_ball_raw();
  std::string bytes = read_file(bench / "ball.raw");
  bytes[0] = '\xff';  // the range is 0 to 255, and both copies contain every whole number of it
  write_file(bench / "ball.raw", bytes);
  ASSERT_EQ(
      bench.rhoray({"pack", "ball.raw", "--raw", "24x24x24:uint8", "--type", "F32", "-o", "f.rho", "-q"}).exit_code, 0);
  run_well(bench, "f.rho --iso 60.3 -o out" + small);
  const json results = results_of(bench, "out");
  for (const char* bits : {"8 bits", "16 bits"}) {
    EXPECT_LE(row_named(results, bits).at("depth_p99_cells"), 1e-5) << bits;
    EXPECT_EQ(row_named(results, bits).at("missed"), 0) << bits;
  }
}

TEST(AccuracyReport, looks_at_layers_one_by_one) {
  const Workbench bench;
  bench.make_ball();
  run_well(bench, "ball.rho --iso 60,120 --opacity 0.5 -o out" + small);
  const json results = results_of(bench, "out");
  ASSERT_EQ(results.at("layers").size(), 2U);
  EXPECT_THAT(results.at("layers")[1].at("layer").get<std::string>(), HasSubstr("isosurface 120"));
  EXPECT_EQ(results.at("rows").size() % 2, 0U);
  EXPECT_TRUE(std::filesystem::exists(bench / "out/layer2_true.png"));
}

TEST(AccuracyReport, is_complete_after_an_interrupt) {
  const Workbench bench;
  bench.make_ball();
  const pid_t child = ::fork();
  if (child == 0) {
    ::setenv("PATH", "/nowhere", 1);  // plots take most of the time of small pictures
    if (::chdir(bench.path().c_str()) == 0)
      ::execl(RHORAY_PROGRAM, "rhoray", "accuracy", "ball.rho", "--iso", "60", "-o", "out", "--size", "320x240",
              "--repeat", "1000", "-q", nullptr);
    ::_exit(127);
  }
  for (int wait = 0; wait < 1200 && !std::filesystem::exists(bench / "out/report.html"); ++wait)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ::kill(child, SIGINT);
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  const json results = results_of(bench, "out");
  EXPECT_THAT(results.at("stage").get<std::string>(), HasSubstr("Interrupted."));
  EXPECT_EQ(csv_rows(read_file(bench / "out/results.csv")).size(), results.at("rows").size());
  EXPECT_GT(results.at("rows").size(), 20U) << "a whole pass";
  EXPECT_THAT(read_file(bench / "out/report.html"), testing::EndsWith("</html>\n"));
  for (const auto& entry : std::filesystem::directory_iterator(bench / "out"))
    EXPECT_FALSE(entry.is_directory()) << entry.path() << ": passing files are left";
}

TEST(AccuracyReport, refuses_what_cannot_be_studied_in_one_line) {
  const Workbench bench;
  bench.make_ball();
  std::filesystem::create_directory(bench / "full");
  write_file(bench / "full/something", "x");
  write_file(bench / "file", "x");
  const auto refused = [&](const std::string& words, int exit_code, const std::string& fact) {
    const RunResult run = bench.shell("rhoray accuracy " + words + " --size 40x30");
    EXPECT_EQ(run.exit_code, exit_code) << words;
    EXPECT_THAT(run.err, HasSubstr(fact)) << words;
  };
  refused("ball.rho", 2, "-o: missing");
  refused("ball.rho --iso 1000 -o out", 2, "1000");
  refused("ball.rho --iso 60 -o full", 2, "is not empty");
  refused("ball.rho --iso 60 -o file", 2, "is not a folder");
  refused("ball.rho --iso 60 -o no/such/folder", 2, "the folder cannot be made");
  refused("ball.rho --iso 60 -o /proc/accuracy", 5, "the folder cannot be made");
  refused("nothing.rho --iso 60 -o out", 3, "nothing.rho");
  refused("ball.rho --iso 60 --repeat 0 -o out", 2, "--repeat");
  refused("ball.rho --iso 60 --camera-position 0,0,500 --camera-target 0,0,1000 --camera-up 0,1,0 -o out", 2,
          "none of 1,200 rays hits anything");
  EXPECT_EQ(read_file(bench / "full/something"), "x");
}

/// Runs the command in a separate process, in the bench's folder, after `prepare`, which returns
/// whether it succeeded.
int exit_code_after(const Workbench& bench, const std::function<bool()>& prepare, const std::string& words) {
  constexpr int not_prepared = 99;
  const pid_t child = ::fork();
  if (child == 0) {
    if (::chdir(bench.path().c_str()) != 0 || !prepare()) ::_exit(not_prepared);
    const std::string line = concat(RHORAY_PROGRAM " accuracy ", words);
    const int said = ::open("said", O_CREAT | O_WRONLY | O_TRUNC, 0600);
    if (said >= 0) ::dup2(said, STDERR_FILENO);
    ::execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    ::_exit(127);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(AccuracyReport, ends_with_exit_code_5_in_a_folder_that_cannot_be_written) {
  const Workbench bench;
  bench.make_ball();
  const RunResult run = bench.shell("rhoray accuracy ball.rho --iso 60 -o /proc/self --force" + small);
  EXPECT_EQ(run.exit_code, 5);
  EXPECT_THAT(run.err, HasSubstr("cannot make a folder here"));
}

TEST(AccuracyReport, ends_with_exit_code_5_on_a_full_disk_and_leaves_whole_files_only) {
  const Workbench bench;
  bench.make_ball();
  std::filesystem::create_directory(bench / "small");
  const auto mount_small_disk = [] {
    const bool alone = ::unshare(CLONE_NEWNS) == 0 || ::unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0;
    return alone && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
           ::mount("small", "small", "tmpfs", 0, "size=64k") == 0 && ::chdir(".") == 0;
  };
  const std::string words = "ball.rho --iso 60 -o small/out" + small + "; code=$?; ls -A small/out > left; exit $code";
  const int code = exit_code_after(bench, mount_small_disk, words);
  if (code == 99) GTEST_SKIP() << "no right to mount a small file system";
  EXPECT_EQ(code, 5) << read_file(bench / "said");
  const std::string left = read_file(bench / "left");
  EXPECT_THAT(left, testing::Not(HasSubstr("rhoray-scratch"))) << left;
  EXPECT_THAT(left, testing::Not(HasSubstr(".report.html."))) << left;
}

}  // namespace
}  // namespace rhoray::tests

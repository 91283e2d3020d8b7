#pragma once

#include <string>
#include <vector>

#include "tests/tools/workbench.h"

namespace rhoray::tests {

/// A command line that writes, to be run in a folder with the inputs of `make_inputs`.
struct WritingCommand {
  const char* name;
  /// The first word is a program beside `rhoray`. "OUT/" stands for the output folder.
  std::vector<std::string> words;
  std::vector<std::string> outputs;  ///< files below OUT/, all or the most important ones
  /// Replaces all outputs together, and does so again when it knows more; no two runs write the same.
  bool writes_interim_results = false;

  /// The words as they are run: with this output folder, and only errors on stderr.
  std::vector<std::string> line(const std::filesystem::path& out, bool replace_existing) const {
    std::vector<std::string> result = words;
    result[0] = (std::filesystem::path(RHORAY_PROGRAM).parent_path() / words[0]).string();
    for (std::string& word : result)
      if (word.starts_with("OUT/")) word = out / word.substr(4);
    if (words[0] == "rhoray") result.push_back("-q");
    if (replace_existing) result.push_back("--force");
    return result;
  }
};

/// Inputs of all commands: ball.rho (grid), box.vtu, box.rho (mesh), cube.off, small.png and
/// other.png.
inline void make_inputs(const Workbench& bench) {
  bench.make_ball();
  bench.make_box();
  bench.make_cube();
  for (const char* const name : {"small.png", "other.png"}) {
    const RunResult drawn = bench.rhoray(
        {"render", "ball.rho", "--iso", name[0] == 's' ? "100" : "180", "--size", "320x240", "-o", name, "-q"});
    if (drawn.exit_code != 0) throw std::runtime_error(drawn.err);
  }
}

inline std::vector<WritingCommand> writing_commands() {
  const auto render = [](const char* name, const std::string& file) {
    return WritingCommand{
        name, {"rhoray", "render", "ball.rho", "--iso", "100", "--size", "320x240", "-o", "OUT/" + file}, {file}};
  };
  const auto export_of = [](const char* name, const std::string& input, const std::string& file,
                            std::vector<std::string> more = {}) {
    WritingCommand command{name, {"rhoray", "export", input, "-o", "OUT/" + file}, {file}};
    command.words.insert(command.words.end(), more.begin(), more.end());
    return command;
  };
  return {
      render("render_png", "a.png"),
      render("render_jpeg", "a.jpg"),
      render("render_exr", "a.exr"),
      render("render_tiff", "a.tif"),
      export_of("export_vti", "ball.rho", "a.vti"),
      export_of("export_npy", "ball.rho", "a.npy"),
      export_of("export_vdb", "ball.rho", "a.vdb"),
      export_of("export_nvdb", "ball.rho", "a.nvdb"),
      export_of("export_grid_stl", "ball.rho", "a.stl", {"--iso", "100"}),
      export_of("export_tets_stl", "box.rho", "a.stl", {"--field", "length", "--iso", "0.7"}),
      export_of("export_vtu", "box.rho", "a.vtu"),
      {"import_vtu", {"rhoray", "import", "box.vtu", "-o", "OUT/a.vtu"}, {"a.vtu"}},
      {"tetrahedralize_vtu",
       {"rhoray", "tetrahedralize", "cube.off", "--max-volume", "0.002", "-o", "OUT/a.vtu"},
       {"a.vtu"}},
      {"pack_mesh", {"rhoray", "pack", "box.vtu", "-o", "OUT/a.rho"}, {"a.rho"}},
      {"pack_volume", {"rhoray", "pack", "ball.raw", "--raw", "24x24x24:uint8", "-o", "OUT/a.rho"}, {"a.rho"}},
      {"resample_rho", {"rhoray", "resample", "box.rho", "--size", "24", "-o", "OUT/a.rho"}, {"a.rho"}},
      {"resample_vdb", {"rhoray", "resample", "box.rho", "--size", "24", "-o", "OUT/a.vdb"}, {"a.vdb"}},
      {"compare_map", {"rhoray", "compare", "small.png", "other.png", "--map", "OUT/a.png"}, {"a.png"}},
      {"validate_report",
       {"rhoray", "validate", "ball.rho", "--iso", "100", "--samples", "200", "--report", "OUT/report"},
       {"report/report.txt", "report/report.json", "report/rays.csv", "report/errors.csv", "report/limits.csv",
        "report/signed_distance.png", "report/depth_error.png"}},
      {"accuracy_report",
       {"rhoray", "accuracy", "ball.rho", "--iso", "100", "--size", "48x32", "-o", "OUT/accuracy"},
       {"accuracy/results.csv", "accuracy/results.json", "accuracy/report.html"},
       true},
      {"bench_csv", {"rhoray", "bench", "open", "ball.rho", "--repeat", "1", "-o", "OUT/"}, {"open.csv", "open.json"}},
      {"recipes_nrrd", {"rhoray-recipes", "marschner-lobb", "--size", "32", "-o", "OUT/a.nhdr"}, {"a.nhdr", "a.raw"}},
      {"recipes_surface",
       {"rhoray-recipes", "torso-surface", "--cells", "4500", "-o", "OUT/a.smesh"},
       {"a.smesh", "a.mtr"}}};
}

}  // namespace rhoray::tests

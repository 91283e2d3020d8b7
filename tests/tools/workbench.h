#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "preprocess/import_mesh.h"
#include "tests/support/meshes.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// A folder with small inputs in which the real programs are run.
class Workbench {
 public:
  /// Packed copies of this process's programs are kept apart from the user's.
  Workbench() {
    static const TemporaryFolder cache;
    ::setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
  }

  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path operator/(std::string_view name) const { return folder_ / name; }

  /// Runs `rhoray` with these words, in the folder.
  RunResult rhoray(std::vector<std::string> words) const {
    words.insert(words.begin(), RHORAY_PROGRAM);
    return run_program(words, path());
  }

  /// Runs a line in a shell, where `rhoray` is the program under test.
  RunResult shell(const std::string& line) const {
    const std::string bin = std::filesystem::path(RHORAY_PROGRAM).parent_path().string();
    return run_program({"sh", "-c", "PATH='" + bin + "':$PATH; " + line}, path());
  }

  /// The report of `rhoray render WORDS`, which succeeds and draws a small picture.
  nlohmann::json drawn(std::vector<std::string> words) const {
    words.insert(words.begin(), "render");
    words.insert(words.end(), {"--json", "--force", "--size", "96x72"});
    const RunResult run = rhoray(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return nlohmann::json::parse(run.out);
  }

  /// Every file of the folder with its content.
  std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path()))
      files[entry.path().lexically_relative(path()).string()] =
          entry.is_regular_file() ? read_file(entry.path()) : std::string("folder");
    return files;
  }

  static constexpr int ball_edge = 24;

  /// ball.raw: 24^3 bytes that decrease with the distance from the centre: 255 there and 0 from 12
  /// samples away.
  void make_ball_raw() const {
    std::string bytes;
    for (int k = 0; k < ball_edge; ++k)
      for (int j = 0; j < ball_edge; ++j)
        for (int i = 0; i < ball_edge; ++i) {
          const double middle = (ball_edge - 1) / 2.0;
          const double distance =
              std::sqrt(std::pow(i - middle, 2) + std::pow(j - middle, 2) + std::pow(k - middle, 2));
          bytes += static_cast<char>(std::lround(std::max(0.0, 255 * (1 - distance / 12))));
        }
    write_file(folder_ / "ball.raw", bytes);
  }

  /// ball.rho, from ball.raw.
  void make_ball() const {
    make_ball_raw();
    const RunResult packed = rhoray({"pack", "ball.raw", "--raw", "24x24x24:uint8", "-o", "ball.rho", "-q"});
    if (packed.exit_code != 0) throw std::runtime_error("ball.rho was not made: " + packed.err);
  }

  /// photo.nrrd: 8 x 8 x 8 texels around ball.rho, redder to the right, with blue that increases
  /// upward.
  void make_photo_nrrd() const {
    std::string text =
        "NRRD0004\ntype: uchar\ndimension: 4\nspace dimension: 3\nsizes: 3 8 8 8\nkinds: RGB-color space space space\n"
        "space directions: none (3,0,0) (0,3,0) (0,0,3)\nspace origin: (1,1,1)\nencoding: raw\n\n";
    for (int k = 0; k < 8; ++k)
      for (int j = 0; j < 8; ++j)
        for (int i = 0; i < 8; ++i)
          for (const int component : {100 + 20 * i, 60, 20 * k}) text += static_cast<char>(component);
    write_file(folder_ / "photo.nrrd", text);
  }

  /// photo.rho, from photo.nrrd.
  void make_photo() const {
    make_photo_nrrd();
    const RunResult packed = rhoray({"pack", "photo.nrrd", "--color", "-o", "photo.rho", "-q"});
    if (packed.exit_code != 0) throw std::runtime_error("photo.rho was not made: " + packed.err);
  }

  /// box.vtu: the unit cube in 384 tetrahedra, with fields 'height' (z) and 'length' (distance from
  /// 0).
  void make_box_vtu() const {
    preprocess::NeutralMesh mesh = box_mesh({});
    add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
    add_point_field(mesh, "length", [](const Vec3& p) { return p.length(); });
    preprocess::export_mesh(mesh, folder_ / "box.vtu", false);
  }

  /// box.rho, from box.vtu.
  void make_box() const {
    make_box_vtu();
    const RunResult packed = rhoray({"pack", "box.vtu", "-o", "box.rho", "-q"});
    if (packed.exit_code != 0) throw std::runtime_error("box.rho was not made: " + packed.err);
  }

  /// cube.off of six squares, and cube.rho of twelve triangles.
  RunResult make_cube() const {
    write_file(folder_ / "cube.off",
               "OFF\n8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
               "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n");
    RunResult packed = rhoray({"pack", "cube.off", "-o", "cube.rho"});
    if (packed.exit_code != 0) throw std::runtime_error("cube.rho was not made: " + packed.err);
    return packed;
  }

 private:
  TemporaryFolder folder_;
};

/// The line of `text` that starts with `start`, without it; empty when there is none.
inline std::string line_after(const std::string& text, const std::string& start) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    if (line.starts_with(start)) return line.substr(start.size());
    at = end + 1;
  }
  return {};
}

}  // namespace rhoray::tests

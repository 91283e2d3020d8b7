#include <sys/utsname.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <thread>

#include "formats/base/error.h"
#include "formats/base/json.h"
#include "formats/base/number_text.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "tools/analysis/run_program.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/cli/version.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

namespace fs = std::filesystem;

struct SelftestCommand {
  CommonOptions common;
};

struct Check {
  enum class Result { passed, failed, left_out };

  std::string name;
  Result result = Result::passed;
  std::string text;
  double seconds = 0;
};

const char* word_of(Check::Result result) {
  constexpr const char* words[] = {"passed", "FAILED", "left out"};
  return words[static_cast<std::size_t>(result)];
}

// ---- the data -----------------------------------------------------------------------------------

/// Decreases with the distance from the centre of the unit cube, with waves.
double field_at(const Vec3& p) {
  return 1 - 2 * (p - Vec3(0.5)).length() + 0.1 * std::sin(9 * p.x) * std::sin(8 * p.y) * std::sin(7 * p.z);
}

void pack_cube_of_samples(const fs::path& path) {
  constexpr std::int64_t edge = 40;
  preprocess::NeutralVolume volume;
  volume.sample_count = Index3(edge), volume.type = formats::ElementType::F32;
  volume.field_name = "density";
  volume.owned_samples.resize(edge * edge * edge * sizeof(float));
  auto* sample = reinterpret_cast<float*>(volume.owned_samples.data());
  for (std::int64_t k = 0; k < edge; ++k)
    for (std::int64_t j = 0; j < edge; ++j)
      for (std::int64_t i = 0; i < edge; ++i)
        *sample++ = static_cast<float>(
            field_at(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) / (edge - 1)));
  volume.samples = volume.owned_samples;
  pack_volume(volume, path);
}

/// Each cube has six tetrahedra around one of its diagonals.
void pack_cube_of_tetrahedra(const fs::path& path) {
  constexpr std::uint64_t edge = 10, points = edge + 1;
  preprocess::NeutralMesh mesh;
  preprocess::NeutralField field;
  field.name = "density";
  for (std::uint64_t n = 0; n < points * points * points; ++n) {
    const Vec3 p = Vec3(static_cast<double>(n % points), static_cast<double>(n / points % points),
                        static_cast<double>(n / points / points)) /
                   static_cast<double>(edge);
    mesh.points.push_back({p.x, p.y, p.z});
    field.values.push_back(field_at(p));
  }
  mesh.point_fields.push_back(std::move(field));
  for (std::uint64_t n = 0; n < edge * edge * edge; ++n) {
    const std::uint64_t first = (n / edge / edge * points + n / edge % edge) * points + n % edge;
    std::array<std::uint64_t, 3> steps{1, points, points * points};
    do {
      const std::uint64_t a = first + steps[0], b = a + steps[1], c = b + steps[2];
      mesh.cells.push_back({first, a, b, c});
    } while (std::next_permutation(steps.begin(), steps.end()));
  }
  pack_mesh(mesh, path);
}

constexpr const char* cube_off =
    "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n"
    "4 2 3 7 6\n4 3 0 4 7\n";

// ---- the checks ---------------------------------------------------------------------------------

/// Runs the checks in a folder of its own, by the program that runs.
class SelfTest {
 public:
  explicit SelfTest(ProgressDisplay& display)
      : display_(display), scratch_(fs::temp_directory_path()), folder_(scratch_.path()) {}

  std::vector<Check> run() {
    check("files", [this] { check_files(); });
    for (const char* machine : {"scalar", "baseline", "avx2", "avx512"})
      check(concat("kernels ", machine), [&] { check_kernels(machine); });
    check("threads", [this] { check_threads(); });
    check_component("import", {"pack", "cube.off", "-o", "surface.rho"});
    check_component("tetrahedralization", {"tetrahedralize", "cube.off", "-o", "tetrahedra.vtu"});
    check_component("repair", {"tetrahedralize", "cube.off", "--repair", "-o", "repaired.vtu"});
    check_component("comparison with CGAL", {"validate", "mesh.rho", "--iso", "0.4", "--samples", "500"});
    check_component("OpenVDB", {"export", "volume.rho", "-o", "volume.vdb"});
    check_component("EXR pictures", {"render", "volume.rho", "--iso", "0.4", "--size", "40x30", "-o", "picture.exr"});
    return checks_;
  }

 private:
  template <class Act>
  void check(const std::string& name, const Act& act) {
    display_.show(name);
    const auto begin = std::chrono::steady_clock::now();
    Check& check = checks_.emplace_back(Check{.name = name, .text = {}});
    try {
      act();
    } catch (const std::exception& error) {
      check.result = Check::Result::failed;
      check.text = error.what();
    }
    check.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  ProgramRun run(std::vector<std::string> words, const std::vector<std::string>& environment = {}) const {
    words.insert(words.begin(), program_.string());
    return run_program({.words = words, .environment = environment, .folder = folder_.string()});
  }

  [[noreturn]] static void fail(const std::vector<std::string>& words, const ProgramRun& run) {
    throw Error(ErrorCode::internal, concat("`rhoray ", shell_line(words), "` ended with ", run.status, ": ",
                                            run.err.substr(0, run.err.find_last_not_of('\n') + 1)));
  }

  void require(int status, const std::vector<std::string>& words) const {
    if (const ProgramRun done = run(words); done.status != status) fail(words, done);
  }

  std::string bytes_of(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream file(folder_ / name, std::ios::binary);
    if (!(file << bytes).flush())
      throw Error(ErrorCode::resource, concat((folder_ / name).string(), ": cannot be written"));
  }

  void check_files() {
    pack_cube_of_samples(folder_ / "volume.rho");
    pack_cube_of_tetrahedra(folder_ / "mesh.rho");
    write("cube.off", cube_off);
    for (const char* name : {"volume.rho", "mesh.rho"}) {
      require(0, {"verify", name, "--deep"});
      std::string damaged = bytes_of(name);
      damaged[damaged.size() / 2] ^= 1;
      write("damaged.rho", damaged);
      require(4, {"verify", "damaged.rho"});
    }
    checks_.back().text = "a grid and a mesh packed and read back; a flipped bit in each was noticed";
  }

  /// Each picture is compared with exact arithmetic. Isosurfaces at `double` are the same, bit for
  /// bit, with every machine.
  void check_kernels(const std::string& machine) {
    const std::vector<std::string> scenes[] = {
        {"volume.rho", "--iso", "0.4"}, {"volume.rho", "--mode", "mip"}, {"mesh.rho", "--mode", "iso", "--iso", "0.4"}};
    std::size_t count = 0;
    for (const auto& scene : scenes)
      for (const std::string level : {"float", "double", "certified"}) {
        std::vector<std::string> words = scene;
        words.insert(words.end(), {"--accuracy", level, "--verify", "200"});
        const ProgramRun done = drawn(words, "RHORAY_MACHINE=" + machine);
        if (done.err.find("this processor does not have it") != std::string::npos) {
          checks_.back().result = Check::Result::left_out;
          checks_.back().text = "this processor does not have it";
          return;
        }
        if (done.status != 0) fail(words, done);
        const bool is_same_everywhere = level == "double" && scene.back() == "0.4";
        std::string& reference = pictures_[count++];
        const std::string picture = bytes_of("picture.png");
        if (reference.empty()) reference = picture;
        if (is_same_everywhere && picture != reference)
          throw Error(ErrorCode::internal, concat(shell_line(words), ": another picture than with scalar kernels"));
      }
    checks_.back().text = concat(count, " pictures agree with exact arithmetic");
  }

  void check_threads() {
    std::string reference;
    for (const std::string count : {"1", "2", "7"}) {
      const std::vector<std::string> words{"volume.rho", "--iso", "0.4", "--style", "presentation", "--threads", count};
      const ProgramRun done = drawn(words, "");
      if (done.status != 0) fail(words, done);
      const std::string picture = bytes_of("picture.png");
      if (reference.empty()) reference = picture;
      if (picture != reference)
        throw Error(ErrorCode::internal, concat("another picture with ", count, " threads than with 1"));
    }
    checks_.back().text = "the same picture with 1, 2 and 7";
  }

  /// Runs `rhoray render` with these words; the picture is picture.png.
  ProgramRun drawn(std::vector<std::string> words, const std::string& variable) const {
    words.insert(words.begin(), "render");
    words.insert(words.end(), {"--size", "160x120", "--quiet", "--force", "-o", "picture.png"});
    return run(std::move(words), variable.empty() ? std::vector<std::string>() : std::vector{variable});
  }

  void check_component(const std::string& name, const std::vector<std::string>& words) {
    check(name, [&] {
      const ProgramRun done = run(words);
      if (done.status == static_cast<int>(ErrorCode::unsupported) &&
          done.err.find("this needs the ") != std::string::npos) {
        checks_.back().result = Check::Result::left_out;
        const std::size_t hint = done.err.find("hint: ");
        checks_.back().text = concat("not installed: ", done.err.substr(hint + 6, done.err.find(';', hint) - hint - 6));
      } else if (done.status != 0) {
        fail(words, done);
      }
    });
  }

  ProgressDisplay& display_;
  const ScratchFolder scratch_;
  const fs::path folder_, program_ = fs::read_symlink("/proc/self/exe");
  std::map<std::size_t, std::string> pictures_;  ///< of the first machine, by number
  std::vector<Check> checks_;
};

// ---- the machine --------------------------------------------------------------------------------

/// The value of the first line "NAME: VALUE" or "NAME=VALUE" of a file; empty without one.
std::string value_in(const char* path, const std::string& name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(name)) continue;
    const std::size_t begin = line.find_first_not_of(" \t:=\"", name.size());
    const std::size_t end = line.find_last_not_of("\" ");
    return begin == std::string::npos ? "" : line.substr(begin, end + 1 - begin);
  }
  return {};
}

std::vector<std::pair<std::string, std::string>> description_of_machine() {
  utsname kernel{};
  ::uname(&kernel);
  return {{"program", version_line()},
          {"processor", concat(value_in("/proc/cpuinfo", "model name"), ", ",
                               counted(std::thread::hardware_concurrency(), "thread", "threads"))},
          {"memory", value_in("/proc/meminfo", "MemTotal")},
          {"system", concat(value_in("/etc/os-release", "PRETTY_NAME"), ", ", kernel.sysname, " ", kernel.release)}};
}

int run(const SelftestCommand& command) {
  ProgressDisplay display(command.common);
  SelfTest test(display);
  const std::vector<Check> checks = test.run();
  display.clear();
  const auto failed = std::count_if(checks.begin(), checks.end(),
                                    [](const Check& check) { return check.result == Check::Result::failed; });
  const auto machine = description_of_machine();
  if (command.common.json) {
    Json json{{"passed", failed == 0}, {"checks", Json::array()}};
    for (const auto& [name, text] : machine) json[name] = text;
    for (const Check& check : checks)
      json["checks"].push_back(
          {{"name", check.name}, {"result", word_of(check.result)}, {"text", check.text}, {"seconds", check.seconds}});
    std::puts(dump(json).c_str());
  } else {
    const auto row = [](const std::string& name, std::size_t width) {
      return name + std::string(std::max(name.size() + 2, width) - name.size(), ' ');
    };
    for (const auto& [name, text] : machine) std::puts(concat(row(name, 22), text).c_str());
    double seconds = 0;
    for (const Check& check : checks) {
      seconds += check.seconds;
      std::puts(concat(row(check.name, 22), row(word_of(check.result), 10), rounded(check.seconds, 2), " s",
                       check.text.empty() ? "" : "  ", check.text)
                    .c_str());
    }
    std::puts(failed == 0 ? concat("The program works on this machine; checked in ", rounded(seconds, 2), " s.").c_str()
                          : concat(counted(static_cast<std::uint64_t>(failed), "check", "checks"),
                                   " failed. A report of the fault should contain all of this output.")
                                .c_str());
  }
  return failed == 0 ? 0 : static_cast<int>(ErrorCode::internal);
}

}  // namespace

Subcommand selftest_subcommand() {
  const auto command = std::make_shared<SelftestCommand>();
  return {
      .name = "selftest",
      .summary = "Check the installed program on this machine",
      .group = "Measurements",
      .examples = {"rhoray selftest", "rhoray selftest --json"},
      .sections =
          {{.heading = "Checks",
            .entries =
                {{"files", "Packing, checksums, and that a flipped bit is noticed"},
                 {"kernels",
                  "Pictures by each instruction set of the processor: against exact arithmetic, and against each "
                  "other"},
                 {"threads", "The same picture with any number of threads"},
                 {"",
                  "The other checks start each installed worker program and load the module for pictures. Exit code 1 "
                  "if a check fails."}}}},
      .options = message_options(command->common, "Print the results as JSON to stdout"),
      .run = [command] { return run(*command); }};
}

}  // namespace rhoray::tools

// Packed files with valid checksums and wrong numbers: each is refused when it is opened, or it is
// rendered. The picture may be wrong; nothing may crash, hang or throw anything but an Error.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <new>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "formats/base/error.h"
#include "formats/brick_grid.h"
#include "formats/color_grid.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "render/query/machine.h"
#include "render/render.h"
#include "render/texture.h"
#include "tests/render/hostile/mutants.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/longer_table.h"
#include "tests/support/memory_file.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using render::Layer;
using render::Mode;
using render::Scene;

constexpr std::uint64_t mutant_count = 120;  // of each released file, for each machine

std::string released(const std::string& name) {
  return read_file(std::filesystem::path(RHORAY_RELEASED_FILES) / name);
}

formats::PackedFile opened(const std::string& bytes, const MemoryFile& memory) {
  memory.put(0, bytes);
  return formats::PackedFile::from_descriptor(memory.descriptor(), "hostile.rho");
}

/// Bounds and range from which scenes are made. They are those of the original file, so that rays
/// also reach what false bounds hide.
struct Look {
  Box3 bounds;
  Interval<double> range;
};

Interval<double> window_of(const Interval<double>& range) {
  return range.lo < range.hi && std::isfinite(range.hi - range.lo) ? range : Interval<double>{0, 1};
}

/// Every query that a volume of this kind supports, with each method.
std::vector<Scene> scenes_of(const render::Dataset& dataset, const Look& look) {
  const Interval<double> window = window_of(look.range);
  const double middle = std::midpoint(window.lo, window.hi);
  Scene scene;
  scene.camera = render::fit_camera(look.bounds, render::named_view("iso"), 1);
  scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, 2, 3}}};
  scene.lights[0].casts_shadows = true;
  std::vector<Scene> scenes;
  const auto add = [&](const Layer& layer) {
    scene.layers = {layer};
    scenes.push_back(scene);
  };
  if (dataset.is_surface()) {
    add({.mode = Mode::triangles});
    add({.mode = Mode::triangles, .material = {.normals = render::Normals::smooth, .opacity = 0.5}});
    if (dataset.has_fields())
      add({.mode = Mode::triangles,
           .material = {.color_by = render::FieldColors{.field = dataset.field().name, .range = window}}});
    return scenes;
  }
  for (const render::Accuracy accuracy :
       {render::Accuracy::preview, render::Accuracy::float32, render::Accuracy::float64, render::Accuracy::certified})
    add({.isovalue = middle, .method = render::method_of(accuracy)});
  add({.isovalue = middle, .method = render::method_of(render::Accuracy::float32), .material = {.opacity = 0.5}});
  for (const render::Accuracy accuracy : {render::Accuracy::float64, render::Accuracy::certified})
    add({.mode = Mode::mip, .method = render::method_of(accuracy), .window = window});
  Layer slice{.mode = Mode::slice};
  slice.plane = {.point = look.bounds.center(), .normal = {0.2, 0.3, 1}};
  slice.material.color_by = render::FieldColors{.field = dataset.field().name, .range = window};
  add(slice);
  return scenes;
}

void render_all(const render::Dataset& dataset, const Look& look, const std::vector<Scene>& scenes) {
  for (const Scene& scene : scenes)
    for (const bool use_hierarchy : {true, false}) {
      const bool is_mip = scene.layers[0].mode == Mode::mip;
      if (!use_hierarchy && !is_mip) continue;
      render::Framebuffer framebuffer;
      try {
        render::render(dataset, scene,
                       {.width = 12,
                        .height = 12,
                        .channels = {.depth = true, .normal = true, .cell = true, .value = true},
                        .threads = 1,
                        .use_hierarchy = use_hierarchy},
                       framebuffer);
      } catch (const Error&) {  // e.g. a camera inside an empty box
      }
    }
  if (!dataset.is_surface())
    dataset.isosurface_bounds(std::midpoint(window_of(look.range).lo, window_of(look.range).hi));
}

void check_deeply(const formats::PackedFile& file) {
  const std::string& kind = file.description().kind;
  if (kind == "grid") deep_findings(formats::BrickGrid(file));
  if (kind == "tets") deep_findings(formats::TetMesh(file));
  if (kind == "surface") deep_findings(formats::TriangleMesh(file));
}

/// Opens a mutant and does with it what a user could do. False when it is refused.
bool is_rendered(const std::string& bytes, const std::vector<Look>& looks) {
  const MemoryFile memory(bytes);
  try {
    const formats::PackedFile file = opened(bytes, memory);
    if (file.description().kind == formats::ColorGrid::kind) {
      const render::Texture texture = render::Texture::load(file);
      const std::string surface = released("1.3-surface.rho");
      const MemoryFile surface_memory(surface);
      const render::Dataset dataset = render::Dataset::load(opened(surface, surface_memory));
      std::vector<Scene> scenes = scenes_of(dataset, {dataset.bounds(), {}});
      for (Scene& scene : scenes) scene.layers[0].material.texture = texture;
      render_all(dataset, {dataset.bounds(), {}}, scenes);
      return true;
    }
    for (const Look& look : looks) {
      const std::size_t field = static_cast<std::size_t>(&look - looks.data());
      const std::vector<std::string> names = render::Dataset::load(file).field_names();
      const render::Dataset dataset = render::Dataset::load(file, field < names.size() ? names[field] : std::string());
      render_all(dataset, look, scenes_of(dataset, look));
      if (dataset.is_mesh()) render_all(dataset.boundary(), look, scenes_of(dataset.boundary(), look));
      if (field == 0)
        render_all(dataset, {dataset.bounds(), dataset.field().range},
                   scenes_of(dataset, {dataset.bounds(), dataset.field().range}));
    }
    check_deeply(file);
    return true;
  } catch (const Error&) {
    return false;
  }
}

std::vector<Look> looks_of(const std::string& bytes) {
  const MemoryFile memory(bytes);
  const formats::PackedFile file = opened(bytes, memory);
  if (file.description().kind == formats::ColorGrid::kind) return {};
  std::vector<Look> looks;
  const render::Dataset first = render::Dataset::load(file);
  if (first.is_surface()) return {{first.bounds(), {}}};
  for (const std::string& name : first.field_names()) {
    const render::Dataset dataset = render::Dataset::load(file, name);
    looks.push_back({dataset.bounds(), dataset.field().range});
  }
  return looks;
}

/// What the child process that handles mutants reports to its parent, even when it crashes.
struct Progress {
  std::atomic<std::uint64_t> next, refused, rendered;
  char thrown[200];
};

enum Ending { done = 0, threw = 3 };

/// Files derived from one valid file.
struct Mutants {
  std::string origin;  ///< the bytes of the valid file
  std::uint64_t count;
  std::function<Mutant(std::uint64_t)> make;
};

/// Handles the mutants from `progress.next` on; never returns.
[[noreturn]] void work(const Mutants& mutants, const char* machine, Progress& progress) {
  ::setenv("RHORAY_MACHINE", machine, 1);  // read once by each process, hence the child
  // For all mutants together, which take about one: only a hang needs so much.
  constexpr rlim_t cpu_seconds = 120;
  const rlimit limit{cpu_seconds, cpu_seconds};
  ::setrlimit(RLIMIT_CPU, &limit);
  try {
    const std::vector<Look> looks = looks_of(mutants.origin);
    for (; progress.next < mutants.count; ++progress.next) {
      const Mutant mutant = mutants.make(progress.next);
      if (is_rendered(mutant.bytes, looks))
        ++progress.rendered;
      else
        ++progress.refused;
    }
  } catch (const std::exception& exception) {
    std::snprintf(progress.thrown, sizeof progress.thrown, "%s", exception.what());
    ::_exit(threw);
  }
  ::_exit(done);
}

struct Outcome {
  std::uint64_t refused, rendered;
};

/// Each mutant must be refused or rendered. A child process handles them; if a mutant kills it,
/// another one continues behind that mutant.
Outcome expect_every_mutant_survives(const Mutants& mutants, render::Machine machine) {
  void* const shared = ::mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) throw std::runtime_error("no shared memory");
  Progress& progress = *new (shared) Progress{};
  for (int failures = 0; failures < 10 && progress.next < mutants.count; ++failures) {
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("fork failed");
    if (child == 0) work(mutants, render::name_of(machine), progress);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0) {
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == done) break;
    ADD_FAILURE() << render::name_of(machine) << ", mutant " << progress.next << ": "
                  << (WIFSIGNALED(status) ? concat("signal ", WTERMSIG(status))
                                          : concat("exit ", WEXITSTATUS(status), ": ", progress.thrown))
                  << "\n  " << mutants.make(progress.next).description;
    ++progress.next;
  }
  EXPECT_EQ(progress.next, mutants.count);
  const Outcome outcome{progress.refused, progress.rendered};
  ::munmap(shared, sizeof(Progress));
  return outcome;
}

std::vector<render::Machine> machines() {
  std::vector<render::Machine> all = wide_machines();
  all.push_back(render::Machine::scalar);
  return all;
}

class HostileFiles : public testing::TestWithParam<const char*> {};

TEST_P(HostileFiles, are_refused_or_rendered_on_every_machine) {
  const std::string file = released(GetParam());
  for (const render::Machine machine : machines()) {
    const Outcome outcome = expect_every_mutant_survives(
        {file, mutant_count, [&](std::uint64_t index) { return make_mutant(file, index); }}, machine);
    // If all mutants were refused, the renderer would not be tested; if all were rendered, the
    // checks would not.
    EXPECT_GT(outcome.refused, mutant_count / 20);
    EXPECT_GT(outcome.rendered, mutant_count / 5);
  }
}

INSTANTIATE_TEST_SUITE_P(Released, HostileFiles,
                         testing::Values("1.0-grid.rho", "1.0-tets.rho", "1.1-rectilinear-grid.rho",
                                         "1.1-sparse-grid.rho", "1.2-clustered-tets.rho", "1.3-surface.rho",
                                         "1.4-colors.rho", "1.7-tets.rho"),
                         [](const testing::TestParamInfo<const char*>& file) {
                           std::string name = file.param;
                           for (char& c : name)
                             if (c == '.' || c == '-') c = '_';
                           return name;
                         });

// `verify` called these files sound, and rendering them wrote past the end of arrays on the stack.
TEST(HostileTables, of_more_vertices_than_readers_keep_are_refused_and_others_rendered) {
  const Mutants longer{released("1.2-clustered-tets.rho"), 3, [](std::uint64_t index) {
                         const std::uint64_t added = std::array<std::uint64_t, 3>{240, 256, 400}[index];
                         return Mutant{with_longer_table(RHORAY_RELEASED_FILES, added),
                                       concat(added, " vertices behind the last table")};
                       }};
  for (const render::Machine machine : machines()) {
    const Outcome outcome = expect_every_mutant_survives(longer, machine);
    EXPECT_EQ(outcome.refused, 2U);
    EXPECT_EQ(outcome.rendered, 1U);
  }
}

}  // namespace
}  // namespace rhoray::tests

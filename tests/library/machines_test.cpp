// The instruction set that a context uses.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <regex>
#include <set>
#include <thread>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/run_program.h"

namespace rhoray::tests {
namespace {

constexpr std::pair<Machine, const char*> all_machines[] = {
    {Machine::scalar, "scalar"}, {Machine::baseline, "baseline"}, {Machine::avx2, "avx2"}, {Machine::avx512, "avx512"}};

std::vector<Machine> machines_here() {
  std::vector<Machine> machines;
  for (const auto& [machine, name] : all_machines)
    if (has_machine(machine)) machines.push_back(machine);
  return machines;
}

constexpr Size size{160, 120};
constexpr RenderOptions options{.size = size, .channels = all_channels, .max_samples = 4};

/// Layers at the levels whose last bits depend on the instruction set, with every effect that
/// traces rays.
Scene scene_of(const Dataset& grid, const Dataset& mesh) {
  Scene scene{.layers = {{.data = grid, .show = Isosurface{0.1234}, .method = Accuracy::float32},
                         {.data = grid, .show = Isosurface{-0.7}, .material = {.opacity = 0.4}},
                         {.data = mesh, .show = Isosurface{0.71}, .field = "radius", .method = Accuracy::preview},
                         {.data = grid, .show = Slice{.plane = {.point = {0, 0, 6}, .normal = {0.1, 0.2, 1}}}},
                         {.data = mesh, .show = MaximumProjection{}, .field = "x"}},
              .lights = {Light{}, Light{.kind = Light::Kind::directional,
                                        .place = {1, -2, 3},
                                        .casts_shadows = true,
                                        .size = 4,
                                        .samples = 3}},
              .occlusion = {.samples = 3, .radius = 1},
              .clip = Clip{.planes = {{.point = {0, 4, 0}, .normal = {0, 1, 0.1}}}, .is_inverted = true}};
  scene.layers[0].material.specular = 0.8;
  scene.camera = fit_camera(scene, size);
  return scene;
}

Picture drawn_on(std::optional<Machine> machine, const Scene& scene) {
  Picture picture;
  RenderContext({.threads = 2, .machine = machine}).render(scene, options, picture);
  return picture;
}

/// The depths that the program reports of pixels X,Y:X,Y, in their order.
std::vector<float> depths_by_program(const std::string& picks, const std::string& machine,
                                     const TemporaryFolder& folder) {
  const RunResult run = run_program({"env", "RHORAY_MACHINE=" + machine, RHORAY_PROGRAM, "render", "drawn.json", "-o",
                                     "picked.png", "--force", "--json", "--pick", picks},
                                    folder.path());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  std::vector<float> depths;
  const std::regex form(R"("depth": ?([-+.e0-9]+))");
  for (std::sregex_iterator at(run.out.begin(), run.out.end(), form), end; at != end; ++at)
    depths.push_back(std::stof((*at)[1]));
  return depths;
}

TEST(Machines, draw_what_the_program_draws_with_RHORAY_MACHINE) {
  const TemporaryFolder folder;
  gyroid_grid({.file = folder / "grid.rho"});
  ball_mesh(6, {.file = folder / "mesh.rho"});
  const Scene scene = scene_of(Dataset::open(folder / "grid.rho"), Dataset::open(folder / "mesh.rho"));
  const std::string document = to_document(scene, {.size = size, .max_samples = options.max_samples}).json();
  const Picture scalar = drawn_on(Machine::scalar, scene), best = drawn_on(best_machine(), scene);
  // Colours of 8 bits may be the same on all; depths are not.
  std::vector<std::size_t> pixels;
  std::string picks;
  for (std::size_t pixel = 0; pixel < scalar.depth().size() && pixels.size() < 30; ++pixel) {
    if (scalar.depth()[pixel] == best.depth()[pixel] || std::isinf(scalar.depth()[pixel] + best.depth()[pixel]))
      continue;
    pixels.push_back(pixel);
    const auto width = static_cast<std::size_t>(size.width);
    picks += (picks.empty() ? "" : ":") + std::to_string(pixel % width) + "," + std::to_string(pixel / width);
  }
  ASSERT_EQ(pixels.size(), best_machine() == Machine::scalar ? 0U : 30U);
  for (const auto& [machine, name] : all_machines) {
    if (!has_machine(machine)) continue;
    const Picture picture = drawn_on(machine, scene);
    EXPECT_TRUE(drawn_by_program(document, folder.path(), name).bytes == srgb_of(picture)) << name;
    if (pixels.empty()) continue;
    std::vector<float> depths;
    for (const std::size_t pixel : pixels) depths.push_back(picture.depth()[pixel]);
    EXPECT_EQ(depths_by_program(picks, name, folder), depths) << name;
  }
}

TEST(Machines, of_two_contexts_do_not_mix) {
  const Scene scene = scene_of(gyroid_grid(), ball_mesh());
  const std::vector<Machine> machines = machines_here();
  std::vector<std::string> expected, found(2 * machines.size());
  for (const Machine machine : machines) expected.push_back(bits_of(drawn_on(machine, scene)));
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < found.size(); ++i)
    threads.emplace_back([&, i] {
      RenderContext context({.threads = 2, .machine = machines[i / 2]});
      Picture picture;
      for (int time = 0; time < 3; ++time) {
        context.refine(scene, options, {}, picture);
        found[i] += bits_of(picture);
      }
    });
  threads.clear();
  const auto without_cost = [&](const std::string& bits) {
    return bits.substr(0, bits.size() - sizeof(std::uint32_t) * static_cast<std::size_t>(size.width * size.height));
  };
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t bytes = expected[i / 2].size();
    ASSERT_EQ(found[i].size(), 3 * bytes);
    for (std::size_t time = 0; time < 3; ++time)
      EXPECT_TRUE(without_cost(found[i].substr(time * bytes, bytes)) == without_cost(expected[i / 2])) << i;
  }
}

TEST(Machines, answer_rays_of_a_context_and_of_a_scratch) {
  const Dataset grid = gyroid_grid();
  const MadeRays rays = random_rays(grid.bounds(), 3000);
  const RayCaster caster(grid, Isosurface{0.1234}, Accuracy::float32);
  const FieldSampler sampler(grid, {}, Accuracy::float32);
  std::set<std::vector<double>> answers;
  for (const Machine machine : machines_here()) {
    RenderContext context({.machine = machine});
    RayScratch scratch(machine);
    EXPECT_EQ(context.machine(), machine);
    const std::vector<double> nothing(rays.size());
    std::vector<double> by_context = nothing, by_scratch = nothing, largest = nothing, largest_by_scratch = nothing;
    caster.first_hits(rays.rays(), {.t = by_context}, context);
    caster.first_hits(rays.rays(), {.t = by_scratch}, scratch);
    EXPECT_EQ(by_context, by_scratch);
    sampler.largest_values(rays.rays(), {.t = largest}, context);
    sampler.largest_values(rays.rays(), {.t = largest_by_scratch}, scratch);
    EXPECT_EQ(largest, largest_by_scratch);
    answers.insert(by_context);
    if (machine != best_machine()) continue;
    RayScratch best;
    caster.first_hits(rays.rays(), {.t = by_scratch}, best);
    EXPECT_EQ(by_context, by_scratch);
  }
  EXPECT_GT(answers.size(), machines_here().size() > 1 ? 1U : 0U);
}

TEST(Machines, are_the_best_unless_chosen_whatever_the_environment_says) {
  ::setenv("RHORAY_MACHINE", "scalar", 1);
  const RenderContext context;
  ::unsetenv("RHORAY_MACHINE");
  EXPECT_EQ(context.machine(), best_machine());
  EXPECT_EQ(best_machine(), machines_here().back());
  EXPECT_TRUE(has_machine(Machine::scalar));
  const Scene scene = scene_of(gyroid_grid(), ball_mesh());
  EXPECT_TRUE(bits_of(drawn_on({}, scene)) == bits_of(drawn_on(best_machine(), scene)));
}

TEST(Machines, that_are_not_there_are_refused) {
  const auto none = static_cast<Machine>(17);
  const std::string expected = ": found 17; expected scalar, baseline, avx2 or avx512";
  expect_refused(ErrorCode::usage, "ContextOptions::machine" + expected, [&] { RenderContext({.machine = none}); });
  expect_refused(ErrorCode::usage, "RayScratch" + expected, [&] { RayScratch scratch(none); });
  expect_refused(ErrorCode::usage, "has_machine" + expected, [&] { has_machine(none); });
  const Dataset grid = gyroid_grid();
  const Scene scene = certified_scene(grid, 0.1, size);
  expect_refused(ErrorCode::usage, "Goal::machine" + expected,
                 [&] { choose_method(scene, 0, size, {.max_error = 1e-3, .machine = none}); });
  for (const auto& [machine, name] : all_machines) {
    if (has_machine(machine)) continue;
    const std::string words = std::string(name) + "; this processor has";
    expect_refused(ErrorCode::unsupported, words, [absent = machine] { RenderContext({.machine = absent}); });
    expect_refused(ErrorCode::unsupported, words, [absent = machine] { RayScratch scratch(absent); });
  }
}

}  // namespace
}  // namespace rhoray::tests

// The threads in which calls compute.
#include <gtest/gtest.h>

#include <ctime>
#include <functional>

#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"

namespace rhoray::tests {
namespace {

double cpu_seconds(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Seconds that all threads but the calling one compute while `act` runs.
double seconds_in_other_threads(const std::function<void()>& act) {
  const auto others = [] { return cpu_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_seconds(CLOCK_THREAD_CPUTIME_ID); };
  const double before = others();
  act();
  return others() - before;
}

TEST(Threads, of_calls_that_may_use_one_are_the_callers) {
  const Size size{640, 480};
  const Dataset grid = gyroid_grid(), mesh = ball_mesh();
  Scene scene{.layers = {{.data = grid, .show = Isosurface{0.1}, .method = Accuracy::certified},
                         {.data = mesh, .show = Isosurface{0.71}, .field = "radius"},
                         {.data = mesh, .show = MaximumProjection{}, .field = "x"}},
              .lights = {{.kind = Light::Kind::directional, .place = {1, -2, 3}, .casts_shadows = true}},
              .occlusion = {.samples = 4, .radius = 1}};
  scene.camera = fit_camera(scene, size);
  const std::pair<const char*, std::function<void(RenderContext&)>> calls[] = {
      {"render",
       [&](RenderContext& context) {
         grid.drop_prepared(), mesh.drop_prepared();  // preparing is part of the call
         Picture picture;
         context.render(scene, {.size = size, .max_samples = 4}, picture);
       }},
      {"refine",
       [&](RenderContext& context) {
         Picture picture;
         context.refine(scene, {.size = size, .max_samples = 4}, {}, picture);
       }},
      {"choose_method",
       [&](RenderContext&) {
         Scene alone = scene;
         alone.layers.erase(alone.layers.begin() + 1, alone.layers.end());
         choose_method(alone, 0, {64, 48}, {.max_error = 1e-3, .threads = 1});
       }},
  };
  for (const auto& [name, call] : calls) {
    RenderContext one({.threads = 1});
    const double before = cpu_seconds(CLOCK_PROCESS_CPUTIME_ID);
    const double others = seconds_in_other_threads([&, &act = call] { act(one); });
    // Threads of earlier contexts may still look for work for some milliseconds.
    EXPECT_LT(others, 0.1 * (cpu_seconds(CLOCK_PROCESS_CPUTIME_ID) - before)) << name;
  }
}

}  // namespace
}  // namespace rhoray::tests

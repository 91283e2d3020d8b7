// Long calls say how far they have come, and end if the function that hears it throws.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <set>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

constexpr Size size{64, 64};
constexpr std::size_t ray_count = 3000;

/// A long call, of data that no other call has prepared or proven.
struct Call {
  std::string name;
  std::vector<std::string> phases;  ///< that it reports, besides others
  std::function<void(const Watch&)> run;
};

/// Answers of many rays, and what they are asked with.
struct Query {
  explicit Query(const Dataset& data) : rays(random_rays(data.bounds(), ray_count)) {}

  MadeRays rays;
  std::vector<double> numbers = std::vector<double>(ray_count);
  std::vector<std::uint8_t> flags = std::vector<std::uint8_t>(ray_count);
  AllHits all;
  RayScratch scratch;
  RenderContext context;
};

const std::string of_grid = "checking ranges (macrocells)", of_mesh = "checking ranges (clusters)";
const std::string rays_traced = "tracing (rays)";

std::vector<Call> calls_that_open_and_copy(const TemporaryFolder& folder) {
  ball_mesh(6, {.file = folder / "ball.rho"});
  octahedron({.file = folder / "octahedron.rho"});
  const auto ball = folder / "ball.rho";
  return {{"pack a grid", {"writing samples (bytes)"}, [](const Watch& watch) { gyroid_grid({.watch = watch}); }},
          {"pack a mesh", {"writing (bytes)"}, [](const Watch& watch) { ball_mesh(3, {.watch = watch}); }},
          {"pack a surface", {"writing"}, [](const Watch& watch) { octahedron({.watch = watch}); }},
          {"open a mesh", {"checking points (elements)"}, [=](const Watch& watch) { Dataset::open(ball, watch); }},
          {"open a surface",
           {"checking triangles (elements)"},
           [file = folder / "octahedron.rho"](const Watch& watch) { Dataset::open(file, watch); }},
          {"boundary",
           {"finding the boundary (points)"},
           [](const Watch& watch) { ball_mesh().boundary("part", 1, watch); }},
          {"damaged_blocks",
           {"comparing checksums (bytes)"},
           [=](const Watch& watch) { Dataset::open(ball).damaged_blocks(0, watch); }},
          {"save",
           {"writing (bytes)"},
           [file = folder / "saved.rho"](const Watch& watch) { ball_mesh().save(file, true, watch); }},
          {"unpack_grid", {"copying (rows)"}, [](const Watch& watch) { unpack_grid(gyroid_grid(), {}, watch); }},
          {"unpack_mesh",
           {"copying (points)", "copying (cells)", "copying a field (values)"},
           [](const Watch& watch) { unpack_mesh(ball_mesh(), watch); }},
          {"fit_camera of a grid",
           {"finding the surface (macrocells)"},
           [](const Watch& watch) {
             fit_camera({.layers = {{gyroid_grid(), Isosurface{0.1}}}}, size, {}, watch);
           }},
          {"fit_camera of a mesh",
           {"finding the surface (cells)"},
           [](const Watch& watch) {
             fit_camera({.layers = {{ball_mesh(), Isosurface{0.5}}}}, size, {}, watch);
           }},
          {"fit_camera of another field",
           {"checking points (elements)"},
           [](const Watch& watch) {
             fit_camera({.layers = {{.data = ball_mesh(), .show = Isosurface{0.1}, .field = "x"}}}, size, {}, watch);
           }},
          {"resolve",
           {"finding the surface (cells)"},
           [path = folder.path()](const Watch& watch) {
             resolve(SceneDocument::parse(R"({"data": {"a": {"file": "ball.rho"}},
                                          "layers": [{"type": "isosurface", "isovalue": 1}]})"),
                     files_in(path), watch);
           }},
          {"files_in", {"checking points (elements)"}, [path = folder.path()](const Watch& watch) {
             files_in(path, watch)("ball.rho");
           }}};
}

std::vector<Call> calls_that_draw() {
  return {{"render",
           {of_grid, "preparing (layers)", "tracing (tiles)", "antialiasing (tiles)"},
           [](const Watch& watch) {
             Picture picture;
             RenderContext().render(certified_scene(gyroid_grid(), 0.1, size), {.size = size, .max_samples = 4},
                                    picture, watch);
           }},
          {"render of a mesh",
           {of_mesh, "tracing (tiles)"},
           [](const Watch& watch) {
             Picture picture;
             RenderContext().render(certified_scene(ball_mesh(), 0.5, size), {.size = size}, picture, watch);
           }},
          {"refine",
           {of_grid, "tracing (tiles)"},
           [](const Watch& watch) {
             Picture picture;
             RenderContext().refine(certified_scene(gyroid_grid(), 0.1, size), {.size = size}, {}, picture, watch);
           }},
          {"probe",
           {of_grid},
           [](const Watch& watch) {
             RenderContext().probe(certified_scene(gyroid_grid(), 0.1, size), size, 4, 4, 16, watch);
           }},
          {"choose_method",
           {of_grid, "tracing in exact arithmetic (rays)", "trying methods (methods)"},
           [](const Watch& watch) {
             choose_method(certified_scene(gyroid_grid(), 0.1, size), 0, size, {.max_error = 0.1}, watch);
           }},
          {"self_check", {of_grid, rays_traced}, [](const Watch& watch) {
             Scene scene = certified_scene(gyroid_grid(), 0.1, size);
             scene.layers[0].method = Accuracy::float64;
             const Picture picture = rendered(scene, {.size = size, .channels = {.depth = true}});
             self_check(scene, picture, {.watch = watch});
           }}};
}

std::vector<Call> calls_that_ask() {
  const auto caster = [](const Dataset& data) { return RayCaster(data, Isosurface{0.1}, Accuracy::float64); };
  return {
      {"RayCaster",
       {of_grid},
       [](const Watch& watch) { RayCaster(gyroid_grid(), Isosurface{0.1}, Accuracy::certified, {}, watch); }},
      {"FieldSampler",
       {of_mesh},
       [](const Watch& watch) { FieldSampler(ball_mesh(), "radius", Accuracy::certified, watch); }},
      {"first_hits on the calling thread",
       {rays_traced},
       [=](const Watch& watch) {
         Query query(gyroid_grid());
         caster(gyroid_grid()).first_hits(query.rays.rays(), {.t = query.numbers}, query.scratch, watch);
       }},
      {"first_hits on threads",
       {"preparing", rays_traced},
       [](const Watch& watch) {
         Query query(ball_mesh());
         const RayCaster of_facets(ball_mesh(), Isosurface{0.5}, Accuracy::float32);
         of_facets.first_hits(query.rays.rays(), {.t = query.numbers}, query.context, watch);
       }},
      {"any_hits on the calling thread",
       {rays_traced},
       [=](const Watch& watch) {
         Query query(gyroid_grid());
         caster(gyroid_grid()).any_hits(query.rays.rays(), query.flags, query.scratch, watch);
       }},
      {"any_hits on threads",
       {rays_traced},
       [=](const Watch& watch) {
         Query query(gyroid_grid());
         caster(gyroid_grid()).any_hits(query.rays.rays(), query.flags, query.context, watch);
       }},
      {"all_hits on the calling thread",
       {of_grid, rays_traced},
       [=](const Watch& watch) {
         Query query(gyroid_grid());
         caster(gyroid_grid()).all_hits(query.rays.rays(), query.all, query.scratch, 16, watch);
       }},
      {"all_hits on threads",
       {of_grid, rays_traced},
       [=](const Watch& watch) {
         Query query(gyroid_grid());
         caster(gyroid_grid()).all_hits(query.rays.rays(), query.all, query.context, 16, watch);
       }},
      {"largest_values on the calling thread",
       {rays_traced},
       [](const Watch& watch) {
         Query query(gyroid_grid());
         FieldSampler(gyroid_grid()).largest_values(query.rays.rays(), {.value = query.numbers}, query.scratch, watch);
       }},
      {"largest_values on threads",
       {rays_traced},
       [](const Watch& watch) {
         Query query(gyroid_grid());
         FieldSampler(gyroid_grid()).largest_values(query.rays.rays(), {.value = query.numbers}, query.context, watch);
       }},
      {"at", {"evaluating (points)"}, [](const Watch& watch) {
         Query query(gyroid_grid());
         FieldSampler(gyroid_grid()).at(query.rays.rays().origins, query.numbers, {}, watch);
       }}};
}

std::vector<Call> all_calls(const TemporaryFolder& folder) {
  std::vector<Call> all = calls_that_open_and_copy(folder);
  for (const std::vector<Call>& more : {calls_that_draw(), calls_that_ask()})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

TEST(Progress, of_every_call_rises_to_the_end_of_its_phases) {
  const TemporaryFolder folder;
  for (const Call& call : all_calls(folder)) {
    SCOPED_TRACE(call.name);
    std::atomic<int> running = 0;
    std::string phase;
    std::uint64_t last = 0, whole = 0;
    std::set<std::string> finished;
    call.run([&](std::string_view now, std::uint64_t done, std::uint64_t total) {
      EXPECT_EQ(++running, 1) << "two calls at a time";
      EXPECT_FALSE(now.empty());
      const bool begins = now != phase || done < last;
      EXPECT_TRUE(!begins || (done == 0 && last == whole)) << now << ": " << done << " after " << last;
      EXPECT_TRUE(total == 0 || done <= total) << now << ": " << done << " of " << total;
      phase = now, last = done, whole = total;
      if (done == total) finished.insert(phase);
      --running;
    });
    for (const std::string& expected : call.phases) EXPECT_THAT(finished, testing::Contains(expected));
    EXPECT_EQ(last, whole) << phase;
  }
}

/// Expects that an exception of the progress function reaches the caller as it was thrown.
template <class Exception>
void expect_to_end_every_call(const Exception& exception) {
  const TemporaryFolder folder;
  for (const Call& call : all_calls(folder)) {
    SCOPED_TRACE(call.name);
    for (const int begun_phases : {1, 2}) {  // the second one begins among threads, or not at all
      int calls = 0;
      const auto fail = [&](auto, std::uint64_t done, auto) {
        if (done > 0 || ++calls == begun_phases) throw exception;
      };
      EXPECT_THROW(call.run(fail), Exception);
    }
    EXPECT_NO_THROW(call.run({}));
  }
}

TEST(Progress, that_throws_ends_every_call_with_the_same_exception) {
  expect_to_end_every_call(std::length_error("of the caller"));
  expect_to_end_every_call(std::system_error(std::make_error_code(std::errc::permission_denied)));
}

TEST(Progress, that_throws_leaves_the_context_and_the_data_usable) {
  const Scene scene = certified_scene(gyroid_grid(), 0.1, size);
  RenderContext context;
  Picture picture;
  const RenderOptions options{.size = size, .max_samples = 4};
  const std::vector<std::string> phases{of_grid, "preparing (layers)", "tracing (tiles)", "antialiasing (tiles)"};
  for (const std::string& last : phases) {
    const auto fail = [&](std::string_view phase, std::uint64_t done, auto) {
      if (phase == last && done > 0) throw 7;
    };
    EXPECT_THROW(context.render(scene, options, picture, fail), int) << last;
  }
  EXPECT_TRUE(context.render(scene, options, picture).complete);
  EXPECT_TRUE(bits_of(picture) == bits_of(rendered(scene, options)));
}

TEST(Progress, may_request_a_stop) {
  const TemporaryFolder folder;
  for (const Call& call : all_calls(folder)) {
    if (call.name.starts_with("render") || call.name == "refine") continue;  // they return: see below
    SCOPED_TRACE(call.name);
    std::stop_source stop;
    const Watch watch(stop.get_token(), [&](auto, auto, auto) { stop.request_stop(); });
    expect_refused(ErrorCode::interrupted, "interrupted", [&] { call.run(watch); });
  }
  std::stop_source stop;
  Picture picture;
  const auto in_the_second_tile = [&](std::string_view phase, std::uint64_t done, auto) {
    if (phase == "tracing (tiles)" && done == 2) stop.request_stop();
  };
  const Scene scene = certified_scene(gyroid_grid(), 0.1, size);
  const RenderResult result =
      RenderContext({.threads = 1}).render(scene, {.size = size}, picture, {stop.get_token(), in_the_second_tile});
  EXPECT_FALSE(result.complete);
  EXPECT_EQ(result.statistics.rays, 2U * 32 * 32);
}

TEST(Watch, converts_from_a_token_a_function_or_both) {
  int calls = 0;
  const auto count = [&](auto, auto, auto) { ++calls; };
  std::stop_source stop;
  gyroid_grid({.watch = Progress(count)});
  EXPECT_GT(calls, 0);
  calls = 0;
  EXPECT_TRUE(Watch().stop == std::stop_token() && !Watch().progress);
  EXPECT_TRUE(Watch(stop.get_token()).stop == stop.get_token());
  stop.request_stop();
  expect_refused(ErrorCode::interrupted, "interrupted", [&] { gyroid_grid({.watch = {stop.get_token(), count}}); });
  EXPECT_EQ(calls, 0);
}

}  // namespace
}  // namespace rhoray::tests

// Calls that are stopped, and callbacks that throw.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

constexpr Size size{128, 96};

Scene plain_scene() {
  return certified_scene(gyroid_grid(), 0.1, size);
}

TEST(Stopping, refine_sends_its_first_pass_even_if_it_was_stopped_before) {
  const Scene scene = plain_scene();
  std::stop_source stop;
  stop.request_stop();
  RenderContext context;
  Picture picture;
  std::vector<int> passes;
  const RenderResult result = context.refine(scene, {.size = size, .channels = {.depth = true}},
                                             {.first_spacing = 16,
                                              .pass_done =
                                                  [&](int spacing) {
                                                    passes.push_back(spacing);
                                                    return true;
                                                  }},
                                             picture, stop.get_token());
  EXPECT_FALSE(result.complete);
  EXPECT_EQ(passes, std::vector{16});
  // Each traced pixel is that of the whole picture.
  const Picture whole = rendered(scene, {.size = size, .channels = {.depth = true}});
  ASSERT_EQ(picture.depth().size(), whole.depth().size());
  for (std::size_t y = 0; y < 96; y += 16)
    for (std::size_t x = 0; x < 128; x += 16) EXPECT_EQ(picture.depth()[y * 128 + x], whole.depth()[y * 128 + x]);
}

TEST(Stopping, refine_ends_after_the_pass_in_which_it_is_stopped_and_can_go_on_later) {
  const Scene scene = plain_scene();
  RenderContext context;
  for (const bool by_token : {true, false}) {
    std::stop_source stop;
    Picture picture;
    std::vector<int> passes;
    const auto pass_done = [&](int spacing) {
      passes.push_back(spacing);
      if (spacing == 4 && by_token) stop.request_stop();
      return spacing != 4 || by_token;
    };
    const RenderResult result =
        context.refine(scene, {.size = size, .max_samples = 4}, {.pass_done = pass_done}, picture, stop.get_token());
    EXPECT_FALSE(result.complete);
    EXPECT_EQ(passes, (std::vector{8, 4}));
    passes.clear();
    const auto all_passes = [&](int spacing) {
      passes.push_back(spacing);
      return true;
    };
    const RenderOptions options{.size = size, .channels = all_channels, .max_samples = 4};
    EXPECT_TRUE(context.refine(scene, options, {.pass_done = all_passes}, picture).complete);
    EXPECT_EQ(passes, (std::vector{8, 4, 2, 1}));
    EXPECT_TRUE(bits_of(picture) == bits_of(rendered(scene, options)));
  }
}

TEST(Stopping, false_after_the_last_pass_leaves_samples_out) {
  const Scene scene = plain_scene();
  RenderContext context;
  Picture picture;
  const auto until_last = [](int spacing) { return spacing != 1; };
  EXPECT_TRUE(context.refine(scene, {.size = size}, {.pass_done = until_last}, picture).complete);
  const RenderResult smoothed =
      context.refine(scene, {.size = size, .max_samples = 16}, {.pass_done = until_last}, picture);
  EXPECT_EQ(smoothed.complete, bits_of(picture) == bits_of(rendered(scene, {.size = size, .max_samples = 16})));
}

TEST(Stopping, render_draws_nothing_if_it_was_stopped_before) {
  const Scene scene = plain_scene();
  std::stop_source stop;
  stop.request_stop();
  RenderContext context;
  Picture picture;
  EXPECT_FALSE(context.render(scene, {.size = size}, picture, stop.get_token()).complete);
  EXPECT_EQ(picture.color().size(), 4U * 128 * 96);
  EXPECT_TRUE(context.render(scene, {.size = size}, picture).complete);
  EXPECT_TRUE(bits_of(picture) == bits_of(rendered(scene, {.size = size})));
}

TEST(Stopping, of_a_window_is_said_too) {
  const Scene scene = plain_scene();
  std::stop_source stop;
  stop.request_stop();
  RenderContext context;
  Picture picture;
  const RenderOptions options{.size = size, .window = Rect{32, 32, 64, 32}};
  EXPECT_FALSE(context.render(scene, options, picture, stop.get_token()).complete);
  EXPECT_EQ(picture.window(), (Rect{32, 32, 64, 32}));
  EXPECT_TRUE(context.render(scene, options, picture).complete);
}

TEST(Stopping, of_rays_throws) {
  std::stop_source stop;
  stop.request_stop();
  const Dataset grid = gyroid_grid();
  const MadeRays rays = random_rays(grid.bounds(), 3000);
  std::vector<double> t(3000);
  std::vector<std::uint8_t> is_hit(3000);
  RenderContext context;
  const RayCaster caster(grid, Isosurface{0}, Accuracy::float64);
  const std::string words = "interrupted";
  expect_refused(ErrorCode::interrupted, words,
                 [&] { caster.first_hits(rays.rays(), {.t = t}, context, stop.get_token()); });
  expect_refused(ErrorCode::interrupted, words,
                 [&] { caster.any_hits(rays.rays(), is_hit, context, stop.get_token()); });
  AllHits all;
  caster.all_hits(rays.rays(), all, context);  // proves the stored ranges
  expect_refused(ErrorCode::interrupted, words,
                 [&] { caster.all_hits(rays.rays(), all, context, 4096, stop.get_token()); });
  expect_refused(ErrorCode::interrupted, words,
                 [&] { FieldSampler(grid).largest_values(rays.rays(), {.t = t}, context, stop.get_token()); });
  caster.first_hits(rays.rays(), {.t = t}, context);
}

std::stop_token stopped_before() {
  std::stop_source stop;
  stop.request_stop();
  return stop.get_token();
}

/// The file with the upper bound of the last interval of an array moved to its lower bound. Opening
/// it checks no range.
void narrow_last_interval(const std::filesystem::path& file, const std::string& array) {
  const Dataset data = Dataset::open(file);
  const ArrayView view = data.array(array);
  ASSERT_EQ(view.type(), ElementType::F32);
  std::string bytes = read_file(file);
  const std::string_view stored(static_cast<const char*>(view.first()), static_cast<std::size_t>(view.count()) * 4);
  const std::size_t end = bytes.find(stored) + stored.size();
  ASSERT_LE(end, bytes.size());
  bytes.replace(end - 4, 4, bytes.substr(end - 8, 4));
  write_file(file, bytes);
}

/// Everything that proves stored ranges, with a token.
void expect_each(ErrorCode code, const std::string& words, const Dataset& data, const std::stop_token& stop) {
  const MadeRays rays = random_rays(data.bounds(), 100);
  AllHits hits;
  RenderContext context;
  expect_refused(code, words, [&] { RayCaster(data, Isosurface{0.1}, Accuracy::certified, {}, stop); });
  expect_refused(code, words, [&] { FieldSampler(data, {}, Accuracy::exact, stop); });
  const RayCaster caster(data, Isosurface{0.1}, Accuracy::float64);  // proves nothing itself
  expect_refused(code, words, [&] { caster.all_hits(rays.rays(), hits, context, 16, stop); });
  Scene scene = certified_scene(data, 0.1, size);
  scene.layers[0].method = Accuracy::float32;
  expect_refused(code, words, [&] { context.probe(scene, size, 4, 4, 16, stop); });
  const Picture picture = rendered(scene, {.size = size, .channels = {.depth = true}});
  expect_refused(code, words, [&] { self_check(scene, picture, {.pixels = 50, .watch = stop}); });
}

TEST(Stopping, of_a_proof_leaves_it_to_the_next_call) {
  const Scene scene = plain_scene();
  const Dataset& grid = scene.layers[0].data;
  RenderContext context;
  Picture picture;
  for (int time = 0; time < 2; ++time) {
    const RenderResult stopped = context.render(scene, {.size = size}, picture, stopped_before());
    EXPECT_FALSE(stopped.complete);
    EXPECT_EQ(stopped.statistics.rays, 0U);
    EXPECT_EQ(stopped.statistics.range_proof_s, 0);
    expect_each(ErrorCode::interrupted, "interrupted", grid, stopped_before());
  }
  const std::stop_source live;
  const RenderResult whole = context.render(scene, {.size = size}, picture, live.get_token());
  EXPECT_TRUE(whole.complete);
  EXPECT_GT(whole.statistics.range_proof_s, 0);
  EXPECT_TRUE(bits_of(picture) == bits_of(rendered(scene, {.size = size})));
  EXPECT_NO_THROW(RayCaster(grid, Isosurface{0.1}, Accuracy::certified, {}, stopped_before()));
}

TEST(Stopping, of_a_proof_does_not_hide_damage_late_in_a_file) {
  const TemporaryFolder folder;
  gyroid_grid({.file = folder / "grid.rho"});
  narrow_last_interval(folder / "grid.rho", "macro.1");
  const Dataset grid = Dataset::open(folder / "grid.rho");
  const Scene scene = certified_scene(grid, 0.1, size);
  RenderContext context;
  Picture picture;
  const std::stop_source live;
  for (int time = 0; time < 2; ++time) {
    EXPECT_FALSE(context.render(scene, {.size = size}, picture, stopped_before()).complete);
    expect_each(ErrorCode::interrupted, "interrupted", grid, stopped_before());
    expect_each(ErrorCode::invalid, "grid.rho: an interval that lacks a value", grid, live.get_token());
    expect_refused(ErrorCode::invalid, "grid.rho: an interval that lacks a value",
                   [&] { context.render(scene, {.size = size}, picture, live.get_token()); });
  }
}

/// A ball with smooth normals, in the light of a lamp that casts shadows.
Scene shaded_scene(const Dataset& data, const decltype(Layer::show)& show) {
  Scene scene{.layers = {{.data = data, .show = show, .material = {.normals = Normals::smooth}}},
              .lights = {{.kind = Light::Kind::directional, .place = {1, -2, 3}, .casts_shadows = true}}};
  scene.camera = fit_camera(scene, size);
  return scene;
}

// Facets, occupied blocks, normals and occluders are kept for the next picture.
TEST(Stopping, at_any_time_changes_nothing_in_the_next_picture) {
  using Clock = std::chrono::steady_clock;
  const TemporaryFolder folder;
  const Samples<float> samples = samples_of<float>(64, 64, 64, [](auto i, auto j, auto k) {
    return gyroid(0.5 * static_cast<double>(i), 0.5 * static_cast<double>(j), 0.5 * static_cast<double>(k));
  });
  pack(GridArrays{.fields = {samples.field("gyroid")}}, AxisOrder::zyx, {.file = folder / "grid.rho"});
  ball_mesh(16, {.file = folder / "mesh.rho"});
  // Each opens its file again: nothing is prepared of it.
  const std::function<Scene()> scenes[] = {
      [&] { return shaded_scene(Dataset::open(folder / "grid.rho"), Isosurface{0.1}); },
      [&] { return shaded_scene(Dataset::open(folder / "mesh.rho"), Isosurface{0.7}); },
      [&] { return shaded_scene(Dataset::open(folder / "mesh.rho").boundary(), Triangles{}); }};
  for (const auto& make : scenes) {
    const Clock::time_point begin = Clock::now();
    const std::string expected = bits_of(rendered(make(), {.size = size}));
    const Clock::duration longest = Clock::now() - begin;
    constexpr int count = 24;
    int stopped = 0;
    for (int time = 0; time < count; ++time) {
      const Scene scene = make();
      RenderContext context;
      Picture picture;
      std::stop_source stop;
      if (time == 0) stop.request_stop();
      const std::jthread stopping([&] {
        std::this_thread::sleep_for(longest * time / count);
        stop.request_stop();
      });
      stopped += !context.render(scene, {.size = size}, picture, stop.get_token()).complete;
      for (int again = 0; again < 2; ++again) {  // certain shadows are computed by the second one
        EXPECT_TRUE(context.render(scene, {.size = size}, picture).complete);
        EXPECT_TRUE(bits_of(picture) == expected) << time;
      }
    }
    EXPECT_GE(stopped, 1);
  }
}

TEST(Stopping, of_the_choice_of_a_method_throws) {
  std::stop_source stop;
  stop.request_stop();
  const Scene scene = plain_scene();
  EXPECT_THROW(
      try { choose_method(scene, 0, size, {.max_error = 0.1}, stop.get_token()); } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::interrupted);
        throw;
      },
      Error);
}

TEST(Stopping, of_a_search_through_all_data_throws) {
  const TemporaryFolder folder;
  gyroid_grid({.file = folder / "grid.rho"});
  std::stop_source stop;
  stop.request_stop();
  const Dataset grid = Dataset::open(folder / "grid.rho"), mesh = ball_mesh();
  for (const auto& [data, show] : {std::pair<Dataset, decltype(Layer::show)>{grid, Isosurface{0.1}},
                                   {mesh, Isosurface{0.5}},
                                   {mesh.boundary(), Triangles{}}}) {
    const Scene scene{.layers = {{.data = data, .show = show}}};
    EXPECT_NO_THROW(fit_camera(scene, size));
    expect_refused(ErrorCode::interrupted, "", [&] { fit_camera(scene, size, {}, stop.get_token()); });
  }
  EXPECT_TRUE(grid.damaged_blocks().empty());
  for (const unsigned threads : {1U, 0U})
    expect_refused(ErrorCode::interrupted, "", [&] { grid.damaged_blocks(threads, stop.get_token()); });
}

void expect_stopped(const std::function<void()>& act) {
  expect_refused(ErrorCode::interrupted, "interrupted", act);
}

TEST(Stopping, of_opening_copying_and_saving_throws) {
  const TemporaryFolder folder;
  ball_mesh(3, {.file = folder / "ball.rho"});
  octahedron({.file = folder / "octahedron.rho"});
  const std::stop_token stop = stopped_before();
  expect_stopped([&] { Dataset::open(folder / "ball.rho", stop); });
  expect_stopped([&] { Dataset::open(folder / "octahedron.rho", stop); });
  const Dataset mesh = Dataset::open(folder / "ball.rho");
  expect_stopped([&] { mesh.boundary(stop); });
  expect_stopped([&] { mesh.boundary("part", 1, stop); });
  expect_stopped([&] { unpack_mesh(mesh, stop); });
  expect_stopped([&] { unpack_grid(gyroid_grid(), {}, stop); });
  expect_stopped([&] { ball_mesh().save(folder / "saved.rho", false, stop); });
  EXPECT_FALSE(std::filesystem::exists(folder / "saved.rho"));
  EXPECT_EQ(unpack_mesh(mesh).points.size(), 64U);
  EXPECT_EQ(mesh.boundary("part", 1).kind(), DataKind::triangles);
}

TEST(Stopping, of_queries_on_the_calling_thread_writes_no_answer) {
  const std::stop_token stop = stopped_before();
  const Dataset grid = gyroid_grid();
  const MadeRays rays = random_rays(grid.bounds(), 20);
  const RayCaster caster(grid, Isosurface{0}, Accuracy::certified);
  const FieldSampler sampler(grid);
  RayScratch scratch;
  std::vector<double> t(20, -7);
  std::vector<std::uint8_t> is_hit(20, 7);
  AllHits all;
  expect_stopped([&] { caster.first_hits(rays.rays(), {.t = t}, scratch, stop); });
  expect_stopped([&] { caster.any_hits(rays.rays(), is_hit, scratch, stop); });
  expect_stopped([&] { caster.all_hits(rays.rays(), all, scratch, 10, stop); });
  expect_stopped([&] { sampler.largest_values(rays.rays(), {.value = t}, scratch, stop); });
  expect_stopped([&] { sampler.at(rays.rays().origins, t, {}, stop); });
  EXPECT_EQ(t, std::vector<double>(20, -7));
  EXPECT_EQ(is_hit, std::vector<std::uint8_t>(20, 7));
  EXPECT_TRUE(all.first.empty());
  sampler.at(rays.rays().origins, t);
  EXPECT_TRUE(std::isnan(t[0])) << "it starts outside";
}

TEST(Stopping, ends_the_loading_of_another_field) {
  const std::stop_token stop = stopped_before();
  const Dataset mesh = ball_mesh(3);
  Scene scene{.layers = {{.data = mesh, .show = Isosurface{0.1}, .field = "x"}}};
  scene.camera = fit_camera(mesh.bounds(), size);
  RenderContext context;
  Picture picture;
  EXPECT_FALSE(context.render(scene, {.size = size}, picture, stop).complete);
  EXPECT_TRUE(picture.color().empty()) << "the picture stays as it was";
  const RenderOptions bad{.size = size, .window = Rect{-1, 0, 10, 10}};
  EXPECT_FALSE(context.render(scene, bad, picture, stop).complete);
  EXPECT_TRUE(picture.color().empty());
  expect_stopped([&] { context.probe(scene, size, 4, 4, 16, stop); });
  expect_stopped([&] { fit_camera(scene, size, {}, stop); });
  expect_stopped([&] { RayCaster(mesh, Isosurface{0.1}, Accuracy::float32, "x", stop); });
  expect_stopped([&] { FieldSampler(mesh, "x", Accuracy::float32, stop); });
  EXPECT_TRUE(context.render(scene, {.size = size}, picture).complete);
}

TEST(Stopping, of_a_documents_choices_throws) {
  const TemporaryFolder folder;
  ball_mesh(3, {.file = folder / "ball.rho"});
  for (const std::string layer : {R"({"type": "isosurface", "isovalue": 1})", R"({"type": "boundary"})"}) {
    const SceneDocument document =
        SceneDocument::parse(R"({"data": {"a": {"file": "ball.rho"}}, "layers": [)" + layer + "]}");
    expect_stopped([&] { resolve(document, files_in(folder.path(), stopped_before())); });
    expect_stopped([&] { resolve(document, files_in(folder.path()), stopped_before()); });
    EXPECT_TRUE(resolve(document, files_in(folder.path())).scene.camera);
  }
}

TEST(Stopping, of_packing_leaves_no_file) {
  const TemporaryFolder folder;
  for (const bool before : {true, false}) {
    std::stop_source stop;
    if (before) stop.request_stop();
    PackOptions options{.watch = {stop.get_token(), [&](auto, auto, auto) { stop.request_stop(); }}};
    for (const std::filesystem::path& file : {std::filesystem::path(), folder / "stopped.rho"}) {
      options.file = file;
      expect_refused(ErrorCode::interrupted, "interrupted", [&] { gyroid_grid(options); });
      expect_refused(ErrorCode::interrupted, "interrupted", [&] { ball_mesh(3, options); });
      expect_refused(ErrorCode::interrupted, "interrupted", [&] { octahedron(options); });
    }
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Callbacks, that_throw_end_packing_and_leave_no_file) {
  const TemporaryFolder folder;
  const PackOptions options{.file = folder / "thrown.rho",
                            .watch = [](auto, auto, auto) { throw std::out_of_range("of the caller"); }};
  EXPECT_THROW(gyroid_grid(options), std::out_of_range);
  EXPECT_THROW(ball_mesh(3, options), std::out_of_range);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Callbacks, that_throw_reach_the_caller_and_leave_the_context_usable) {
  const Scene scene = plain_scene();
  RenderContext context;
  Picture picture;
  const Passes passes{.pass_done = [](int spacing) -> bool {
    if (spacing == 2) throw std::out_of_range("of the caller");
    return true;
  }};
  EXPECT_THROW(context.refine(scene, {.size = size}, passes, picture), std::out_of_range);
  const Passes refusing{.pass_done = [](int) -> bool { throw Error(ErrorCode::invalid, "of the caller"); }};
  expect_refused(ErrorCode::invalid, "of the caller",
                 [&] { context.refine(scene, {.size = size}, refusing, picture); });
  EXPECT_TRUE(context.render(scene, {.size = size}, picture).complete);
  EXPECT_TRUE(bits_of(picture) == bits_of(rendered(scene, {.size = size})));
}

// As an error of the library itself does: what the context holds is not trusted any more.
TEST(Callbacks, that_throw_an_internal_error_end_the_use_of_their_context) {
  const Scene scene = plain_scene();
  RenderContext context;
  Picture picture;
  const Passes failing{.pass_done = [](int) -> bool { throw Error(ErrorCode::internal, "a defect"); }};
  expect_refused(ErrorCode::internal, "a defect", [&] { context.refine(scene, {.size = size}, failing, picture); });
  expect_refused(ErrorCode::internal, "an earlier call of this RenderContext found a defect of the library",
                 [&] { context.render(scene, {.size = size}, picture); });
  EXPECT_TRUE(RenderContext().render(scene, {.size = size}, picture).complete);
}

/// Expects that an exception of any callback reaches the caller as it was thrown.
template <class Exception>
void expect_to_reach_the_caller(const Exception& exception) {
  EXPECT_THROW(gyroid_grid({.watch = [&](auto, auto, auto) { throw exception; }}), Exception);
  RenderContext context;
  Picture picture;
  const Passes passes{.pass_done = [&](int) -> bool { throw exception; }};
  EXPECT_THROW(context.refine(plain_scene(), {.size = size}, passes, picture), Exception);
  const SceneDocument document =
      SceneDocument::parse(R"({"data": {"a": {"file": "a.rho"}}, "layers": [{"type": "mip"}]})");
  EXPECT_THROW(resolve(document, [&](const auto&) -> Dataset { throw exception; }), Exception);
}

TEST(Callbacks, that_throw_exceptions_of_the_standard_library_reach_the_caller_with_them) {
  const std::error_code denied = std::make_error_code(std::errc::permission_denied);
  expect_to_reach_the_caller(std::filesystem::filesystem_error("of the caller", denied));
  expect_to_reach_the_caller(std::system_error(denied));
  expect_to_reach_the_caller(std::length_error("of the caller"));
  expect_to_reach_the_caller(7);
}

TEST(Callbacks, that_open_data_may_throw) {
  const SceneDocument document =
      SceneDocument::parse(R"({"data": {"a": {"file": "a.rho"}}, "layers": [{"type": "mip"}]})");
  EXPECT_THROW(resolve(document, [](const auto&) -> Dataset { throw std::out_of_range("of the caller"); }),
               std::out_of_range);
}

}  // namespace
}  // namespace rhoray::tests

// Pictures do not depend on windows, threads, memory, or the caller's floating-point environment.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/equal_bytes.h"
#include "tests/support/host_floating_point.h"

namespace rhoray::tests {
namespace {

constexpr Size size{150, 100};

/// A scene with transparent and opaque layers of two datasets, shadows and occlusion.
Scene rich_scene() {
  const Dataset grid = gyroid_grid();
  Scene scene{.layers = {{.data = grid, .show = Isosurface{0.7}},
                         {.data = grid, .show = Isosurface{0}, .material = {.opacity = 0.5}},
                         {.data = ball_mesh(), .show = Isosurface{0.9}, .field = "radius"}},
              .lights = {{.kind = Light::Kind::directional, .place = {1, -1, 2}, .casts_shadows = true}},
              .occlusion = {.samples = 4, .radius = 2}};
  scene.camera = fit_camera(scene, size, {});
  return scene;
}

constexpr RenderOptions rich_options() {
  return {.size = size, .channels = all_channels, .max_samples = 16};
}

/// Copies a window into a picture's bytes.
template <class T>
void paste(std::span<const T> from, const Rect& window, std::size_t components, std::vector<T>& to) {
  for (int row = 0; row < window.height; ++row)
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(row * window.width) * components),
                static_cast<std::size_t>(window.width) * components,
                to.begin() + static_cast<std::ptrdiff_t>(
                                 static_cast<std::size_t>((window.y + row) * size.width + window.x) * components));
}

TEST(Windows, in_any_order_make_the_whole_picture) {
  const Scene scene = rich_scene();
  RenderContext context({.threads = 2});
  Picture whole, part;
  const RenderResult at_once = context.render(scene, rich_options(), whole);
  EXPECT_GT(at_once.statistics.edge_pixels, 100U);
  constexpr std::size_t pixels = 150 * 100;
  std::vector<float> color(4 * pixels), depth(pixels), normal(3 * pixels);
  std::vector<std::uint64_t> cell(pixels);
  std::vector<double> value(pixels);
  std::vector<std::uint32_t> cost(pixels);
  std::vector<Rect> parts = windows(size, 32);
  ASSERT_EQ(parts.size(), 20U);
  std::shuffle(parts.begin(), parts.end(), std::mt19937(7));
  Statistics sum;
  for (const Rect& window : parts) {
    RenderOptions options = rich_options();
    options.window = window;
    const RenderResult result = context.render(scene, options, part);
    EXPECT_TRUE(result.complete);
    EXPECT_EQ(part.size(), size);
    EXPECT_EQ(part.window(), window);
    sum += result.statistics;
    paste(part.color(), window, 4, color), paste(part.depth(), window, 1, depth);
    paste(part.normal(), window, 3, normal), paste(part.cell(), window, 1, cell);
    paste(part.value(), window, 1, value), paste(part.cost(), window, 1, cost);
  }
  EXPECT_TRUE(equal_bytes(whole.color(), color));
  EXPECT_TRUE(equal_bytes(whole.depth(), depth));
  EXPECT_TRUE(equal_bytes(whole.normal(), normal));
  EXPECT_TRUE(equal_bytes(whole.cell(), cell));
  EXPECT_TRUE(equal_bytes(whole.value(), value));
  EXPECT_TRUE(equal_bytes(whole.cost(), cost));
  EXPECT_EQ(sum.edge_pixels, at_once.statistics.edge_pixels);
}

TEST(Windows, count_what_the_whole_picture_counts) {
  const Scene scene = rich_scene();
  RenderContext context;
  Picture picture;
  const Statistics whole = context.render(scene, {.size = size}, picture).statistics;
  Statistics sum;
  for (const Rect& window : windows(size))
    sum += context.render(scene, {.size = size, .window = window}, picture).statistics;
  EXPECT_EQ(sum.rays, 15000U);
  EXPECT_EQ(sum.rays, whole.rays);
  EXPECT_EQ(sum.hits, whole.hits);
  EXPECT_EQ(sum.shadow_rays, whole.shadow_rays);
  EXPECT_EQ(sum.occlusion_rays, whole.occlusion_rays);
}

TEST(Windows, cover_each_pixel_once_and_follow_their_neighbours) {
  for (const auto& [of, edge] :
       {std::pair{Size{1, 1}, 1}, {Size{150, 100}, 64}, {Size{33, 65}, 32}, {Size{64, 64}, 999}}) {
    std::vector<int> covered(static_cast<std::size_t>(of.width * of.height));
    Rect before{};
    for (const Rect& window : windows(of, edge)) {
      for (int y = window.y; y < window.y + window.height; ++y)
        for (int x = window.x; x < window.x + window.width; ++x)
          ++covered.at(static_cast<std::size_t>(y * of.width + x));
      EXPECT_EQ(window.x % 32, 0);
      EXPECT_TRUE(window.x == before.x || window.y == before.y);
      before = window;
    }
    EXPECT_EQ(std::count(covered.begin(), covered.end(), 1), of.width * of.height);
  }
}

TEST(Windows, that_do_not_follow_the_tiles_are_the_whole_pictures_too) {
  const Scene scene = rich_scene();
  const Picture whole = rendered(scene, rich_options());
  for (const Rect& window : {Rect{17, 5, 61, 33}, Rect{149, 99, 1, 1}, Rect{0, 40, 150, 1}}) {
    RenderOptions options = rich_options();
    options.window = window;
    const Picture part = rendered(scene, options);
    for (int y = 0; y < window.height; ++y)
      for (int x = 0; x < window.width; ++x)
        for (int c = 0; c < 4; ++c)
          ASSERT_EQ(part.color()[static_cast<std::size_t>((y * window.width + x) * 4 + c)],
                    whole.color()[static_cast<std::size_t>(((window.y + y) * 150 + window.x + x) * 4 + c)])
              << x << ' ' << y;
  }
}

TEST(SameBits, for_any_number_of_threads_and_fresh_or_kept_memory) {
  const Scene scene = rich_scene();
  Scene other = rich_scene();
  other.layers.pop_back();
  const std::string expected = bits_of(rendered(scene, rich_options(), 1));
  for (const unsigned threads : {2U, 8U, 0U}) {
    RenderContext context({.threads = threads});
    Picture picture;
    for (int turn = 0; turn < 2; ++turn) {
      context.render(scene, rich_options(), picture);
      EXPECT_TRUE(bits_of(picture) == expected) << threads << " threads, turn " << turn;
      context.render(other, {.size = {40, 30}}, picture);
    }
    EXPECT_EQ(picture.color().size(), 4U * 40 * 30);
    EXPECT_TRUE(picture.depth().empty());
  }
}

TEST(SameBits, in_the_callers_arena) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the thread sanitizer cannot follow Debian's oneTBB, which starts the threads here";
#endif
  const Scene scene = rich_scene();
  const std::string expected = bits_of(rendered(scene, rich_options(), 1));
  const auto bits = [&] {
    RenderContext context({.threads = 2, .uses_callers_arena = true});
    Picture picture;
    context.render(scene, rich_options(), picture);
    return bits_of(picture);
  };
  EXPECT_TRUE(bits() == expected) << "outside of every arena of ours";
  for (const int threads : {1, 2}) {
    tbb::task_arena arena(threads);
    EXPECT_TRUE(arena.execute(bits) == expected) << threads;
  }
  // Several pictures inside a parallel loop of the caller.
  std::vector<std::string> all(4);
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) { all[i] = bits(); });
  for (const std::string& each : all) EXPECT_TRUE(each == expected);
  // Contexts with threads of their own inside such a loop.
  tbb::parallel_for(std::size_t{0}, all.size(),
                    [&](std::size_t i) { all[i] = bits_of(rendered(scene, rich_options(), 2)); });
  for (const std::string& each : all) EXPECT_TRUE(each == expected);
}

TEST(SameBits, for_any_floating_point_environment_of_the_caller) {
  // Denormal values: with FTZ or DAZ they would be 0.
  const Samples<double> samples =
      samples_of<double>(9, 9, 9, [](auto i, auto j, auto k) { return 1e-310 * static_cast<double>(i * i + j * k); });
  // The caller computes with the caller's rounding: only answers of the library are compared.
  const MadeRays rays = random_rays({{0, 0, 0}, {2.4, 5.6, 8.8}}, 50);
  const auto results = [&] {
    std::string bits;
    const Dataset grid =
        pack(GridArrays{.fields = {samples.field("denormal")}, .spacing = {0.3, 0.7, 1.1}}, AxisOrder::zyx);
    for (const Accuracy accuracy : {Accuracy::float64, Accuracy::certified}) {
      Scene scene{.layers = {{.data = grid, .show = Isosurface{30e-310}, .method = accuracy}}};
      scene.camera = fit_camera(scene, {48, 48}, {});
      bits += bits_of(rendered(scene, {.size = {48, 48}, .channels = all_channels, .max_samples = 4}));
    }
    std::vector<double> t(50), value(50);
    RayScratch scratch;
    RayCaster(grid, Isosurface{30e-310}, Accuracy::exact).first_hits(rays.rays(), {.t = t}, scratch);
    FieldSampler(grid).at(rays.rays().origins, value);
    AllHits all;
    RayCaster(grid, Isosurface{30e-310}, Accuracy::exact).all_hits(rays.rays(), all, scratch);
    for (const auto* const list : {&t, &value, &all.t, &all.error})
      bits.append(reinterpret_cast<const char*>(list->data()), list->size() * sizeof(double));
    return bits;
  };
  const std::string expected = results();
  for (const HostFloatingPoint& host : host_environments()) {
    const InHostFloatingPoint here(host);
    const std::string found = results();
    EXPECT_TRUE(here.is_kept()) << host.name;
    EXPECT_TRUE(found == expected) << host.name;
    Picture picture;
    EXPECT_THROW(RenderContext().render({}, {}, picture), Error);
    EXPECT_TRUE(here.is_kept()) << host.name << ": after an error";
  }
}

TEST(Contexts, render_the_same_data_at_a_time) {
  const Scene scene = rich_scene();
  const std::string expected = bits_of(rendered(scene, rich_options(), 1));
  std::vector<std::string> found(4);
  {
    std::vector<std::jthread> threads;
    for (std::string& bits : found) threads.emplace_back([&] { bits = bits_of(rendered(scene, rich_options(), 2)); });
  }
  for (const std::string& bits : found) EXPECT_TRUE(bits == expected);
}

TEST(Contexts, refuse_a_second_call_during_a_call) {
  const Scene scene = rich_scene();
  RenderContext context({.threads = 1});
  Picture first, second;
  std::string message;
  const Passes passes{.pass_done = [&](int spacing) {
    if (spacing == 8)
      std::jthread([&] {
        expect_refused(ErrorCode::usage, "was called during another call",
                       [&] { context.render(scene, {.size = size}, second); });
      });
    // Its own callback may not call it either, also not for rays.
    expect_refused(ErrorCode::usage, "was called during another call", [&] { context.refine(scene, {}, {}, second); });
    const MadeRays rays = random_rays(scene.layers[0].data.bounds(), 3);
    std::vector<double> t(3);
    expect_refused(ErrorCode::usage, "was called during another call", [&] {
      RayCaster(scene.layers[0].data, Isosurface{0}, Accuracy::float64).first_hits(rays.rays(), {.t = t}, context);
    });
    return true;
  }};
  RenderOptions options = rich_options();
  options.channels.cost = false;  // of meshes it depends on which rays are traced together
  EXPECT_TRUE(context.refine(scene, options, passes, first).complete);
  EXPECT_EQ(second.size(), (Size{0, 0}));
  EXPECT_TRUE(bits_of(first) == bits_of(rendered(scene, options)));
}

TEST(Contexts, refuse_calls_after_a_fork) {
  const Scene scene = rich_scene();
  RenderContext context({.threads = 2});
  Picture picture;
  context.render(scene, {.size = {40, 30}}, picture);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    try {
      context.render(scene, {.size = {40, 30}}, picture);
      ::_exit(9);
    } catch (const Error& error) {
      const bool is_said = std::string(error.what()).find("was forked") != std::string::npos;
      ::_exit(is_said ? static_cast<int>(error.code()) : 8);
    }
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), static_cast<int>(ErrorCode::usage));
  context.render(scene, {.size = {40, 30}}, picture);
}

TEST(Pictures, are_values) {
  const Scene scene = rich_scene();
  Picture picture = rendered(scene, {.size = {40, 30}, .channels = all_channels});
  const std::string bits = bits_of(picture);
  const Picture copy = picture;
  Picture moved = std::move(picture);
  EXPECT_TRUE(bits_of(moved) == bits);
  EXPECT_EQ(picture.size(), (Size{0, 0}));  // NOLINT(bugprone-use-after-move): it is empty
  EXPECT_TRUE(picture.color().empty() && Picture(picture).color().empty());
  RenderContext().render(scene, {.size = {8, 8}}, picture);
  EXPECT_EQ(picture.color().size(), 4U * 64);
  picture = rendered(scene, {.size = {8, 8}});
  EXPECT_EQ(picture.size(), (Size{8, 8}));
  EXPECT_TRUE(bits_of(copy) == bits);
  moved = picture;
  EXPECT_EQ(moved.color().size(), 4U * 64);
}

}  // namespace
}  // namespace rhoray::tests

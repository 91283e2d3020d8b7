#include <gtest/gtest.h>

#include <atomic>
#include <stop_token>
#include <thread>

#include "render/ray_caster.h"
#include "render/render.h"
#include "render/truth.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/expect_error.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"
#include "tests/support/narrowed.h"

// Certified and exact results skip cells by stored ranges. The ranges are proven first, once, and
// only for these methods.

namespace rhoray::tests {
namespace {

using render::Accuracy;
using render::Framebuffer;
using render::FrameOptions;
using render::method_of;
using render::Mode;
using render::Scene;

constexpr FrameOptions small{.width = 48, .height = 36};

std::string file_of(const TracedDataset& traced) {
  return read_file(traced.dataset().file().name());
}
std::string grid_file() {
  return file_of(TracedDataset(sampled_volume<float>({25, 22, 27}, {}, distance_field({12, 10, 13}))));
}
std::string mesh_file(bool has_clusters) {
  preprocess::PackMeshOptions options;
  options.structure = has_clusters ? preprocess::MeshStructure::clusters : preprocess::MeshStructure::leaves;
  return file_of(TracedDataset(box_mesh({.cells = {6, 6, 6}}, distance_field({0.5, 0.5, 0.5})), options));
}

Scene scene_of(const render::Dataset& dataset, const render::Method& method, Mode mode = Mode::isosurface) {
  Scene scene;
  const Interval<double> range = dataset.field().range;
  scene.camera = fit_camera(dataset.bounds(), render::named_view("iso"), 4.0 / 3);
  scene.layers[0].mode = mode;
  scene.layers[0].isovalue = range.lo / 2 + range.hi / 2;
  scene.layers[0].window = range;
  scene.layers[0].method = method;
  return scene;
}

struct Sound {
  const char* name;
  std::string file;
  const char* array;
  IntervalStep step;
};
std::vector<Sound> sound_files() {
  return {{"grid", grid_file(), "macro.2", IntervalStep::macro_levels},
          {"leaf lists", mesh_file(false), "range.0.0", IntervalStep::macro_levels},
          {"clusters", mesh_file(true), "range.0.0", IntervalStep::cluster_ranges},
          {"boxes", mesh_file(true), "cluster.boxes.0", IntervalStep::cluster_boxes}};
}

TEST(RangeProof, is_made_once_before_the_first_frame_that_proves_and_never_for_others) {
  for (const Sound& sound : sound_files()) {
    SCOPED_TRACE(sound.name);
    const TracedDataset traced(sound.file);
    const render::Dataset& dataset = traced.dataset();
    Framebuffer picture;
    render::RenderContext memory;
    const auto proven_bytes = [&](const render::Dataset& of, Accuracy accuracy, Mode mode = Mode::isosurface) {
      return render::render(of, scene_of(of, method_of(accuracy), mode), small, picture, memory).range_proof.bytes;
    };
    for (const Accuracy accuracy : {Accuracy::preview, Accuracy::float32, Accuracy::float64})
      EXPECT_EQ(proven_bytes(dataset, accuracy), 0U);
    EXPECT_EQ(render::RayCaster(dataset, 1, method_of(Accuracy::float64)).range_proof().bytes, 0U);
    EXPECT_GT(proven_bytes(dataset, Accuracy::certified), sound.file.size() / 4);
    for (const Accuracy accuracy : {Accuracy::certified, Accuracy::exact, Accuracy::float32})
      EXPECT_EQ(proven_bytes(dataset, accuracy), 0U);
    EXPECT_EQ(proven_bytes(dataset, Accuracy::certified, Mode::mip), 0U);
    const render::Dataset copy = dataset;
    EXPECT_EQ(proven_bytes(copy, Accuracy::exact), 0U) << "copies share the proof";
    EXPECT_EQ(render::RayCaster(copy, 1, method_of(Accuracy::exact)).range_proof().bytes, 0U);
    const render::Dataset again = render::Dataset::load(dataset.file().name());
    EXPECT_GT(render::RayCaster(again, 1, method_of(Accuracy::exact)).range_proof().bytes, 0U) << "mapped anew";
    EXPECT_EQ(proven_bytes(again, Accuracy::certified), 0U);
  }
}

TEST(RangeProof, refuses_frames_and_rays_every_time_where_ranges_are_too_narrow) {
  for (const Sound& sound : sound_files()) {
    SCOPED_TRACE(sound.name);
    const TracedDataset traced(narrowed(sound.file, sound.array, sound.step));
    const render::Dataset& dataset = traced.dataset();
    Framebuffer picture;
    EXPECT_GT(render::render(dataset, scene_of(dataset, method_of(Accuracy::float32)), small, picture).rays, 0U);
    for (int time = 0; time < 2; ++time)
      for (const Accuracy accuracy : {Accuracy::certified, Accuracy::exact}) {
        const render::Method method = method_of(accuracy);
        for (const Mode mode : {Mode::isosurface, Mode::mip}) {
          Framebuffer none;
          expect_error(ErrorCode::invalid,
                       "packed.rho: ", [&] { render::render(dataset, scene_of(dataset, method, mode), small, none); });
          EXPECT_EQ(none.pixel_count(), 0U);
        }
        expect_error(ErrorCode::invalid, "packed.rho: ", [&] { render::RayCaster(dataset, 1, method); });
        expect_error(ErrorCode::invalid, "packed.rho: ", [&] { dataset.prove_ranges(); });
      }
  }
}

TEST(RangeProof, asks_only_of_volumes_whose_answers_are_proven) {
  const TracedDataset sound(grid_file()), spoilt(narrowed(grid_file(), "macro.1", IntervalStep::macro_levels));
  const std::vector<render::Dataset> datasets{sound.dataset(), spoilt.dataset()};
  Scene scene = scene_of(datasets[0], method_of(Accuracy::certified));
  scene.layers.push_back(scene.layers[0]);
  scene.layers[1].dataset = 1;
  scene.layers[1].method = method_of(Accuracy::float32);
  Framebuffer picture;
  EXPECT_GT(render::render(datasets, scene, small, picture).range_proof.bytes, 0U);
  scene.layers[1].method = method_of(Accuracy::certified);
  expect_error(ErrorCode::invalid, "level 1", [&] { render::render(datasets, scene, small, picture); });
}

TEST(RangeProof, is_made_once_although_several_threads_ask) {
  const TracedDataset traced(grid_file());
  std::atomic<std::uint64_t> bytes = 0, times = 0;
  {
    std::vector<std::jthread> threads;
    for (int thread = 0; thread < 8; ++thread)
      threads.emplace_back([&] {
        const std::uint64_t read = traced.dataset().prove_ranges(1).bytes;
        bytes += read;
        times += read > 0;
      });
  }
  EXPECT_EQ(times, 1U);
  EXPECT_GT(bytes, 0U);
}

// ---- stop requests ------------------------------------------------------------------------------

std::stop_token stopped_before() {
  std::stop_source stop;
  stop.request_stop();
  return stop.get_token();
}

/// Calls everything that proves, with a token that was stopped before.
void expect_all_stopped(const render::Dataset& dataset) {
  const std::stop_token stopped = stopped_before();
  const render::Method certified = method_of(Accuracy::certified);
  const auto expect_stopped = [](const auto& act) { expect_error(ErrorCode::interrupted, "interrupted", act); };
  expect_stopped([&] { dataset.prove_ranges(0, stopped); });
  expect_stopped([&] { render::RayCaster(dataset, 1, certified, 1, {}, stopped); });
  const std::vector<render::Ray> ray(1, {Vec3(0, 0, 0), Vec3(1, 1, 1)});
  for (const Mode mode : {Mode::isosurface, Mode::mip})
    expect_stopped([&] {
      render::trace_rays({.dataset = dataset, .mode = mode, .isovalue = 1, .method = certified, .watch = stopped}, ray);
    });
  render::RenderContext memory;
  Framebuffer picture;
  const render::FrameStatistics statistics = render::refine(dataset, scene_of(dataset, certified), small,
                                                            {.first_spacing = 1, .watch = stopped}, picture, memory);
  EXPECT_EQ(statistics.rays, 0U);
  EXPECT_EQ(statistics.range_proof.bytes, 0U);
  EXPECT_EQ(picture.pixel_count(), 48U * 36);
}

TEST(RangeProof, that_was_stopped_is_neither_done_nor_failed) {
  for (const Sound& sound : sound_files()) {
    SCOPED_TRACE(sound.name);
    const std::uint64_t whole = TracedDataset(sound.file).dataset().prove_ranges().bytes;
    const TracedDataset traced(sound.file);
    const render::Dataset& dataset = traced.dataset();
    for (int time = 0; time < 2; ++time) expect_all_stopped(dataset);
    const std::stop_source live;
    EXPECT_EQ(dataset.prove_ranges(0, live.get_token()).bytes, whole);
    EXPECT_EQ(dataset.prove_ranges(0, stopped_before()).bytes, 0U) << "done: nothing is left to be stopped";

    const TracedDataset spoilt(narrowed(sound.file, sound.array, sound.step));
    for (int time = 0; time < 2; ++time) {
      expect_all_stopped(spoilt.dataset());
      expect_error(ErrorCode::invalid, "packed.rho: ", [&] { spoilt.dataset().prove_ranges(0, live.get_token()); });
    }
  }
}

TEST(RangeProof, of_many_callers_is_made_once_by_one_that_is_not_stopped) {
  for (int time = 0; time < 20; ++time) {
    const TracedDataset traced(grid_file());
    std::atomic<std::uint64_t> times = 0, stopped = 0;
    std::stop_source stop;
    const auto prove = [&](const std::stop_token& token) {
      try {
        times += traced.dataset().prove_ranges(1, token).bytes > 0;
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::interrupted) << error.what();
        ++stopped;
      }
    };
    {
      std::vector<std::jthread> threads;
      for (int thread = 0; thread < 6; ++thread)
        threads.emplace_back([&, thread] { prove(thread % 2 == 0 ? std::stop_token() : stop.get_token()); });
      stop.request_stop();  // at any time during the calls
    }
    EXPECT_EQ(times, 1U);
    EXPECT_LE(stopped, 3U);
    EXPECT_EQ(traced.dataset().prove_ranges().bytes, 0U);
  }
}

// A proof identified by the address of the data in memory would be used for the next file mapped
// there.
TEST(RangeProof, is_not_taken_for_that_of_a_file_loaded_later) {
  const std::string sound = grid_file(), spoilt = narrowed(sound, "macro.1", IntervalStep::macro_levels);
  for (int time = 0; time < 20; ++time) {
    EXPECT_GT(TracedDataset(sound).dataset().prove_ranges().bytes, 0U);
    expect_error(ErrorCode::invalid, "level 1", [&] { TracedDataset(spoilt).dataset().prove_ranges(); });
  }
}

}  // namespace
}  // namespace rhoray::tests

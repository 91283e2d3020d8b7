// The cost of showing another isovalue of a grid: with extracted triangles, and directly. The
// paper's Table 6 with systems of today.

#include "tools/lab/extraction.h"

#include "formats/base/error.h"
#include "formats/base/read_value.h"
#include "preprocess/pack_volume.h"
#include "render/load.h"
#include "tools/lab/peers/ours.h"
#include "tools/lab/peers/triangles.h"
#include "tools/lab/plain_grid.h"
#include "tools/lab/rounds.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"
#ifdef RHORAY_WITH_EMBREE
#include "render/isovalue.h"
#include "render/scene_spec.h"
#include "tools/lab/peers/embree_triangles.h"
#endif

namespace rhoray::study {

namespace {

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path input;
  std::string field;
  std::vector<std::string> isovalues{"auto"};
  render::PictureSize size{512, 512};
  int repeat = 3;
  std::optional<double> cgal_triangles;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

/// Milliseconds of CPU time, one entry per repetition.
struct Times {
  std::vector<double> extraction, build, frame;
};

Json median_of(const std::vector<double>& times) {
  return times.empty() ? Json() : Json(tools::spread_of(times).median);
}

/// One row: a system that shows an isovalue.
/// @param picture_ms  until its first picture: the cost of an isovalue, and a frame
Json row_of(const std::string& system, double isovalue, const Times& times, const Json& triangles, const Json& mb) {
  std::vector<double> picture;
  for (std::size_t i = 0; i < times.frame.size(); ++i)
    picture.push_back((times.extraction.empty() ? 0 : times.extraction[i]) +
                      (times.build.empty() ? 0 : times.build[i]) + times.frame[i]);
  return {{"isovalue", isovalue},
          {"system", system},
          {"triangles", triangles},
          {"memory_mb", mb},
          {"extraction_ms", median_of(times.extraction)},
          {"build_ms", median_of(times.build)},
          {"frame_ms", median_of(times.frame)},
          {"to_picture_ms", median_of(picture)}};
}

class Study {
 public:
  Study(const Settings& settings, const preprocess::NeutralVolume& grid, const std::filesystem::path& packed)
      : settings_(settings), volume_(render::Dataset::load(packed)) {
    data_.grid = &grid;
    data_.packed_file = packed;
    data_.bounds = volume_.bounds();
    data_.range = volume_.field().range;
  }

  std::vector<Json> rows_of(const std::string& isovalue_text, tools::ProgressDisplay& display) const {
    const double isovalue = render::choose_isovalue(isovalue_text, volume_.field()).value;
    const PeerView view{.camera = tools::study_camera(tools::StudyView::front, volume_, isovalue,
                                                      double{1} * settings_.size.width / settings_.size.height),
                        .width = settings_.size.width,
                        .height = settings_.size.height};
    std::vector<Json> rows;
    for (const auto& make : {marching_cubes, synchronized_templates, flying_edges}) {
      display.show(concat("isovalue ", isovalue, ": ", make()->maker()));
      rows.push_back(row_of_triangles(make, isovalue, view));
    }
    if (settings_.cgal_triangles) {
      display.show(concat("isovalue ", isovalue, ": CGAL's surface mesher"));
      rows.push_back(row_of_triangles([&] { return cgal_mesher(*settings_.cgal_triangles); }, isovalue, view));
    }
    for (const char* level : {"float", "certified"}) {
      display.show(concat("isovalue ", isovalue, ": Rhoray, ", level));
      rows.push_back(own_row(level, isovalue, view));
    }
    return rows;
  }

 private:
  /// Triangles and, where Embree is available, its scene of them, made anew each time.
  template <class Make>
  Json row_of_triangles(const Make& make, double isovalue, [[maybe_unused]] const PeerView& view) const {
    Times times;
    Json triangles, mb;
    bool is_complete = true;
    std::string name = make()->maker();
    for (int i = 0; i < settings_.repeat; ++i) {
      const std::shared_ptr<Triangles> surface = make();
      times.extraction.push_back(surface->extract(data_, isovalue).extraction_ms);
      triangles = surface->triangle_count(), mb = surface->memory_mb();
      is_complete = is_complete && surface->is_complete();
#ifdef RHORAY_WITH_EMBREE
      const PeerPointer embree = embree_packets(embree_triangles(surface));
      times.build.push_back(embree->prepare(data_, isovalue).build_ms);
      times.frame.push_back(cpu_ms_of([&] { embree->draw(view); }));
#endif
    }
#ifdef RHORAY_WITH_EMBREE
    name += ", Embree";
#endif
    if (!is_complete) name += ", not finished";
    return row_of(name, isovalue, times, triangles, mb);
  }

  Json own_row(const std::string& level, double isovalue, const PeerView& view) const {
    Times times;
    for (int i = 0; i < settings_.repeat; ++i) {
      const PeerPointer own = own_isosurface(level);
      times.build.push_back(own->prepare(data_, isovalue).build_ms);
      times.frame.push_back(cpu_ms_of([&] { own->draw(view); }));
    }
    return row_of(concat("Rhoray, ", level), isovalue, times, Json(), Json());
  }

  const Settings& settings_;
  render::Dataset volume_;
  PeerData data_;
};

int run(const Settings& settings) {
  require_publishable(settings.common, {"extraction"});
  require_within("--repeat", settings.repeat, 1, 1000);
  tools::Table table{"extraction", "Another isovalue, by triangles and directly: CPU time of one thread", {}, {}};
  const tools::ScratchFolder scratch(settings.scratch);
  {
    tools::ProgressDisplay display(settings.common);
    display.show("reading and packing");
    preprocess::NeutralVolume grid = plain_grid(settings.input, settings.field);
    const std::filesystem::path file = scratch.path() / "grid.rho";
    preprocess::pack_volume(grid, file);
    grid.samples = grid.owned_samples;
    const Index3 n = grid.sample_count;
    table.context = context_with({{"file", settings.input.filename().string()},
                                  {"samples", {n.x, n.y, n.z}},
                                  {"type", formats::element_name(grid.type)},
                                  {"size", {settings.size.width, settings.size.height}},
                                  {"view", "front"},
                                  {"repeat", settings.repeat}});
    const Study study(settings, grid, file);
    for (const std::string& isovalue : settings.isovalues)
      for (Json& row : study.rows_of(isovalue, display)) table.rows.push_back(std::move(row));
  }
  publish(table, settings.common);
  return 0;
}

}  // namespace

tools::Subcommand extraction() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "extraction",
      .summary = "Another isovalue of a grid, by triangles and directly: the paper's Table 6",
      .examples = {"rhoray-study extraction torso-ct.rho --iso 250 -o results",
                   "rhoray-study extraction small.rho --iso 250 --cgal 40000 -o results"},
      .options = tools::all_options(
          {{tools::file_option("FILE", "Packed grid", settings->input),
            tools::value_option("--iso", "V[,V]", "Isovalues; default auto", settings->isovalues),
            tools::value_option("--field", "NAME", "Field; default the first", settings->field),
            tools::value_option("--size", "WxH", "Pixels; default 512x512", settings->size),
            tools::value_option("--repeat", "N", "Repetitions; default 3", settings->repeat),
            tools::number_option("--cgal", "TRIANGLES",
                                 "Also CGAL's surface mesher, asked for about so many; it takes minutes",
                                 {100, 10'000'000}, settings->cgal_triangles),
            tools::value_option("--scratch", "FOLDER", "For the packed grid", settings->scratch),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)},
           tools::output_options(settings->common, "FOLDER for extraction.csv and .json")}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study

#include "tools/rhoray/bench/tables.h"

#include <algorithm>
#include <fstream>

#include "formats/base/error.h"
#include "formats/base/pending_file.h"
#include "formats/packed_file.h"
#include "preprocess/pack.h"
#include "render/document.h"
#include "tools/analysis/cpu_meter.h"
#include "tools/analysis/measure.h"
#include "tools/rhoray/bench/parts.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/version.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::tools {

namespace {

constexpr double gibibyte = 1024.0 * 1024.0 * 1024.0;

Json picture_context(const BenchOptions& options, const render::Dataset& dataset) {
  Json json = bench_context(options);
  json["size"] = {options.size.width, options.size.height};
  json["field"] = dataset.field().name;
  if (!options.normals.empty()) json["normals"] = options.normals;
  if (!options.color_by.empty()) json["color_by"] = options.color_by;
  json["samples_or_cells"] = dataset.is_mesh() ? "tetrahedra" : "grid";
  return json;
}

/// A picture that is traced again and again in memory that is kept, and what came out last.
struct Shot {
  std::string scene;
  render::ResolvedScene plan;
  render::Framebuffer picture{};
  render::RenderContext memory{};
  render::FrameStatistics statistics{};

  double trace(const render::Dataset& dataset) {
    statistics = render::render(dataset, plan.scene, plan.frame, picture, memory);
    return statistics.wall_s;
  }
  Shot another() const { return {.scene = scene, .plan = plan}; }
};

render::ResolvedScene plan_of(const render::SceneSpec& scene_spec, const render::Dataset& dataset) {
  render::ResolvedScene plan =
      resolve_layers(scene_spec, [&](const render::DataSpec&, formats::Space) { return dataset; });
  aim_camera(scene_spec, plan);
  return plan;
}

std::vector<Shot> shots(const BenchOptions& options, const render::Dataset& dataset) {
  std::vector<Shot> list;
  render::SceneSpec scene_spec{.data = std::vector<render::DataSpec>(1), .layers = std::vector<render::LayerSpec>(1)};
  scene_spec.style = "fast";
  scene_spec.image.size = options.size;
  scene_spec.accuracy = options.accuracy;
  scene_spec.camera.view = options.view;
  scene_spec.layers[0].normals = options.normals;
  scene_spec.layers[0].color_by = options.color_by;
  const auto add = [&](const std::string& scene) {
    Shot shot{.scene = scene, .plan = plan_of(scene_spec, dataset)};
    shot.plan.frame.threads = options.threads;
    if (scene.empty()) shot.scene = concat("iso ", shot.plan.scene.layers[0].isovalue);
    list.push_back(std::move(shot));
  };
  for (const std::string& isovalue : options.isovalues) {
    scene_spec.layers[0].isovalues = {isovalue};
    add({});
  }
  if (options.mip) {
    scene_spec.layers[0].type = render::LayerType::mip;
    add("mip");
  }
  return list;
}

/// 1, 2, 4, ... and the largest.
std::vector<unsigned> thread_counts(unsigned largest) {
  std::vector<unsigned> counts;
  for (unsigned count = 1; count < largest; count *= 2) counts.push_back(count);
  counts.push_back(largest);
  return counts;
}

/// Reads the file once and writes as many bytes as the packed data has raw, and waits until they
/// are on disk. The data file of a detached header is not read, which is to packing's disadvantage.
double copy_seconds(const BenchOptions& options, const std::filesystem::path& folder, std::uint64_t raw_bytes) {
  const Stopwatch watch;
  std::vector<char> buffer(std::size_t{4} << 20);
  std::ifstream in(options.input, std::ios::binary);
  while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || in.gcount() > 0) {
  }
  PendingFile out(folder / "copy", {.replace_existing = true});
  for (std::uint64_t left = raw_bytes; left > 0;) {
    const std::uint64_t part = std::min<std::uint64_t>(left, buffer.size());
    out.append(std::string_view(buffer.data(), static_cast<std::size_t>(part)));
    left -= part;
  }
  out.publish();
  return watch.seconds();
}

/// Bytes of the packed file beyond points and fields, for one tetrahedron; null for grids.
Json bytes_per_tetrahedron(const formats::PackedFile& file, const preprocess::PackReport& packed) {
  const auto* mesh = std::get_if<formats::TetMeshDescription>(&packed.description);
  if (mesh == nullptr) return nullptr;
  std::uint64_t plain = file.entry("points").byte_count;
  for (std::size_t f = 0; file.has(concat("field.", f)); ++f) plain += file.entry(concat("field.", f)).byte_count;
  return static_cast<double>(packed.file_bytes - plain) / static_cast<double>(mesh->cell_count);
}

/// Changes a picture to one that was not shown before.
struct Change {
  const char* name;
  void (*act)(render::Scene& scene, const render::Dataset& dataset);
};

/// By a ten-thousandth of the range.
void next_isovalue(render::Scene& scene, const render::Dataset& dataset) {
  const Interval<double> range = dataset.field().range;
  scene.layers[0].isovalue += 1e-4 * (range.hi - range.lo);
}

/// By one degree about the z axis.
void next_view(render::Scene& scene, const render::Dataset&) {
  render::Camera& camera = scene.camera;
  const Vec3 from_target = camera.position - camera.target;
  constexpr double cosine = 0.99984769515639123, sine = 0.017452406437283513;
  camera.position = camera.target + Vec3(cosine * from_target.x - sine * from_target.y,
                                         sine * from_target.x + cosine * from_target.y, from_target.z);
}

/// A picture that is changed and shown, then shown again without a change. Before each time a
/// picture of few pixels is made: what it takes more after a change than without is what the change
/// takes before the first pixel.
class ChangingPicture {
 public:
  ChangingPicture(const Shot& shot, const Change& change, const render::Dataset& dataset)
      : shot_(shot.another()), few_pixels_(shot.another()), change_(change), volume_(dataset) {
    few_pixels_.plan.frame.width = few_pixels_.plan.frame.height = 4;
    few_pixels_.plan.frame.threads = 1;
  }

  double show_next() {
    change_.act(shot_.plan.scene, volume_);
    few_pixels_.plan.scene = shot_.plan.scene;
    changed_ms_ = few_pixels_ms();
    return shot_.trace(volume_);
  }
  double show_again() {
    extra_ms_.push_back(changed_ms_ - few_pixels_ms());
    return shot_.trace(volume_);
  }

  /// Of all times but the first, which was not timed.
  std::vector<double> extra_ms() const { return {extra_ms_.begin() + 1, extra_ms_.end()}; }
  std::string hash() const { return picture_hash(shot_.picture); }

 private:
  double few_pixels_ms() {
    return 1e3 * meter_.measure([&] { few_pixels_.trace(volume_); }).cpu_s;
  }

  Shot shot_, few_pixels_;
  Change change_;
  const render::Dataset& volume_;
  CpuMeter meter_;
  double changed_ms_ = 0;
  std::vector<double> extra_ms_;
};

}  // namespace

Table phases_table(const BenchOptions& options, const Step& step) {
  const render::Dataset dataset = load_dataset(options.packed, options.field);
  std::vector<Shot> plain = shots(options, dataset), timed;
  for (const Shot& shot : plain) timed.push_back(shot.another());
  for (Shot& shot : timed) shot.plan.frame.time_phases = true;
  const std::size_t count = plain.size();
  std::vector<render::FrameStatistics::Phases> phases(count);
  const auto seconds = interleaved(2 * count, options.repeat, [&](std::size_t row) {
    Shot& shot = row < count ? plain[row] : timed[row - count];
    step(shot.scene);
    const double taken = shot.trace(dataset);
    if (row >= count) {
      phases[row - count].traversal += shot.statistics.phases.traversal;
      phases[row - count].intersection += shot.statistics.phases.intersection;
      phases[row - count].shading += shot.statistics.phases.shading;
    }
    return taken;
  });

  Table table{"phases",
              "Where the time goes (shares of CPU time), and frames per second",
              picture_context(options, dataset),
              {}};
  for (std::size_t i = 0; i < count; ++i) {
    const double all = phases[i].traversal + phases[i].intersection + phases[i].shading;
    const Spread frame = spread_of(seconds[i]);
    const render::FrameStatistics& statistics = plain[i].statistics;
    Json row{{"scene", plain[i].scene},
             {"traversal_percent", 100 * phases[i].traversal / all},
             {"intersection_percent", 100 * phases[i].intersection / all},
             {"shading_percent", 100 * phases[i].shading / all},
             {"fps", 1 / frame.median}};
    add_spread(row, "frame_s", frame);
    row["rays"] = statistics.rays;
    row["hits"] = statistics.hits;
    row["cells_visited"] = statistics.cells_visited;
    row["cells_solved"] = statistics.cells_solved;
    row["machine"] = statistics.machine;
    row["picture"] = picture_hash(plain[i].picture);
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table threads_table(const BenchOptions& options, const Step& step) {
  const render::Dataset dataset = load_dataset(options.packed, options.field);
  const std::vector<unsigned> counts =
      thread_counts(options.threads == 0 ? std::max(1u, this_machine().core_count) : options.threads);
  std::vector<Shot> rows;
  for (const Shot& shot : shots(options, dataset))
    for (const unsigned threads : counts) {
      rows.push_back(shot.another());
      rows.back().plan.frame.threads = threads;
    }
  std::vector<std::vector<double>> cpu_seconds(rows.size());
  const auto seconds = interleaved(rows.size(), options.repeat, [&](std::size_t row) {
    step(concat(rows[row].scene, ", ", rows[row].plan.frame.threads, " threads"));
    const double cpu_before = usage_so_far().cpu_s;
    const double taken = rows[row].trace(dataset);
    cpu_seconds[row].push_back(usage_so_far().cpu_s - cpu_before);
    return taken;
  });

  Table table{"threads", "Frames per second by number of threads", picture_context(options, dataset), {}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const unsigned threads = rows[i].plan.frame.threads;
    const Spread frame = spread_of(seconds[i]), one_thread = spread_of(seconds[i - i % counts.size()]);
    const double speedup = one_thread.median / frame.median;
    Json row{{"scene", rows[i].scene},
             {"threads", threads},
             {"fps", 1 / frame.median},
             {"speedup", speedup},
             {"efficiency", speedup / threads}};
    add_spread(row, "frame_s", frame);
    row["cpu_s"] = spread_of(cpu_seconds[i]).median;
    row["machine"] = rows[i].statistics.machine;
    row["picture"] = picture_hash(rows[i].picture);
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table views_table(const BenchOptions& options, const Step& step) {
  const render::Dataset dataset = load_dataset(options.packed, options.field);
  const double aspect = static_cast<double>(options.size.width) / static_cast<double>(options.size.height);
  struct Row {
    StudyView view;
    Shot shot;
    std::vector<double> cycles;
  };
  std::vector<Row> rows;
  for (const Shot& shot : shots(options, dataset))
    for (const StudyView view : study_views) {
      rows.push_back({view, shot.another(), {}});
      render::Scene& scene = rows.back().shot.plan.scene;
      const bool is_surface = scene.layers[0].mode == render::Mode::isosurface;
      scene.camera =
          study_camera(view, dataset, is_surface ? std::optional(scene.layers[0].isovalue) : std::nullopt, aspect);
    }
  CpuMeter meter;
  const auto seconds = interleaved(rows.size(), options.repeat, [&](std::size_t r) {
    Row& row = rows[r];
    step(concat(row.shot.scene, ", ", name_of(row.view)));
    double taken = 0;
    const Cost cost = meter.measure([&] { taken = row.shot.trace(dataset); });
    row.cycles.push_back(cost.cycles ? *cost.cycles : cost.cpu_s * core_frequency_hz());
    return taken;
  });

  Table table{"views", "The paper's four views", picture_context(options, dataset), {}};
  table.context["cycles"] = meter.counts_cycles() ? "counted by the processor" : "CPU time x measured frequency";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    Row& row = rows[r];
    row.cycles.erase(row.cycles.begin());  // the round that was not timed
    const Spread frame = spread_of(seconds[r]);
    const render::FrameStatistics& statistics = row.shot.statistics;
    const double rays = static_cast<double>(statistics.rays);
    Json json{{"scene", row.shot.scene}, {"view", name_of(row.view)}, {"fps", 1 / frame.median}};
    add_spread(json, "frame_s", frame);
    json["million_rays_per_s"] = 1e-6 * rays / frame.median;
    json["cycles_per_ray"] = spread_of(row.cycles).median / rays;
    json["covered"] = static_cast<double>(statistics.hits) / rays;
    json["cells_per_ray"] = static_cast<double>(statistics.cells_visited) / rays;
    json["picture"] = picture_hash(row.shot.picture);
    table.rows.push_back(std::move(json));
  }
  return table;
}

Table memory_table(const BenchOptions& options, const Step& step) {
  const render::Dataset dataset = load_dataset(options.packed, options.field);
  Table table{"memory", "Memory beyond the mapped file", picture_context(options, dataset), {}};
  render::Framebuffer picture;  // one for all rows: memory that is given back would still be counted
  for (Shot& shot : shots(options, dataset)) {
    step(shot.scene);
    shot.picture = std::move(picture);
    for (int frame = 0; frame < options.repeat; ++frame) shot.trace(dataset);
    const std::uint64_t picture_bytes = shot.picture.color.size() * sizeof(float), all = anonymous_bytes();
    table.rows.push_back({{"scene", shot.scene},
                          {"file_bytes", dataset.file().file_bytes()},
                          {"picture_bytes", picture_bytes},
                          {"anonymous_bytes", all},
                          {"beyond_file_and_picture_bytes", all - std::min(all, picture_bytes)},
                          {"machine", shot.statistics.machine},
                          {"picture", picture_hash(shot.picture)}});
    picture = std::move(shot.picture);
  }
  return table;
}

Table isovalue_table(const BenchOptions& options, const Step& step) {
  const render::Dataset dataset = load_dataset(options.packed, options.field);
  BenchOptions surfaces = options;
  surfaces.mip = false;
  Table table{"isovalue",
              "First picture after a change, and the preparation before its first pixel",
              picture_context(options, dataset),
              {}};
  for (const Shot& shot : shots(surfaces, dataset))
    for (const Change& change : {Change{"isovalue", next_isovalue}, Change{"view", next_view}}) {
      ChangingPicture picture(shot, change, dataset);
      const auto seconds = interleaved(2, options.repeat, [&](std::size_t row) {
        step(concat(shot.scene, ", another ", change.name));
        return row == 0 ? picture.show_next() : picture.show_again();
      });
      Json json{{"scene", shot.scene}, {"changed", change.name}};
      add_spread(json, "next_s", spread_of(seconds[0]));
      add_spread(json, "again_s", spread_of(seconds[1]));
      const Spread extra = spread_of(picture.extra_ms());
      json["change_ms"] = extra.median;
      json["change_ms_min"] = extra.smallest;
      json["change_ms_max"] = extra.largest;
      json["picture"] = picture.hash();
      table.rows.push_back(std::move(json));
    }
  return table;
}

Table open_table(const BenchOptions& options, const Step& step) {
  const formats::PackedFile file = formats::PackedFile::open(options.packed);
  struct Way {
    const char* name;
    std::function<void()> act;
  };
  const Way ways[] = {{"open", [&] { formats::PackedFile::open(options.packed); }},
                      {"open, ready for the first ray", [&] { load_dataset(options.packed, options.field); }},
                      {"checksums, 1 thread", [&] { file.damaged_blocks(1); }},
                      {"checksums, all threads", [&] { file.damaged_blocks(options.threads); }}};
  const auto seconds = interleaved(std::size(ways), options.repeat, [&](std::size_t row) {
    step(ways[row].name);
    const Stopwatch watch;
    ways[row].act();
    return watch.seconds();
  });
  Table table{"open", "Opening a packed file (page cache warm)", bench_context(options), {}};
  for (std::size_t i = 0; i < std::size(ways); ++i) {
    const Spread spread = spread_of(seconds[i]);
    Json row{{"what", ways[i].name}};
    add_spread(row, "seconds", spread);
    row["file_bytes"] = file.file_bytes();
    row["s_per_gib"] = spread.median / (static_cast<double>(file.file_bytes()) / gibibyte);
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table pack_table(const BenchOptions& options, const Step& step) {
  preprocess::PackOptions pack = pack_options(options.read);
  pack.memory_limit_bytes = options.memory_limit_bytes;
  pack.replace_existing = true;
  if (!options.field.empty()) pack.fields = {options.field};
  preprocess::check_pack(options.input, pack);
  const ScratchFolder scratch(options.scratch);
  const std::filesystem::path packed_path = scratch.path() / "packed.rho";
  preprocess::PackReport packed;
  std::vector<double> cpu_seconds;
  const auto seconds = interleaved(2, options.repeat, [&](std::size_t row) {
    step(row == 0 ? "packing" : "reading and writing once");
    if (row == 1) return copy_seconds(options, scratch.path(), packed.raw_bytes);
    const Stopwatch watch;
    const double cpu_before = usage_so_far().cpu_s;
    packed = preprocess::pack(options.input, packed_path, pack);
    cpu_seconds.push_back(usage_so_far().cpu_s - cpu_before);
    return watch.seconds();
  });
  cpu_seconds.erase(cpu_seconds.begin());  // the round that was not timed

  Table table{
      "pack", "Packing, compared with reading the file and writing the raw data once", bench_context(options), {}};
  const Spread packing = spread_of(seconds[0]), copying = spread_of(seconds[1]);
  Json row{{"content", content_of(packed)}};
  add_spread(row, "pack_s", packing);
  row["pack_cpu_s"] = spread_of(cpu_seconds).median;
  add_spread(row, "copy_s", copying);
  row["pack_over_copy"] = packing.median / copying.median;
  row["raw_bytes"] = packed.raw_bytes;
  row["file_bytes"] = packed.file_bytes;
  row["file_over_raw"] = static_cast<double>(packed.file_bytes) / static_cast<double>(packed.raw_bytes);
  row["extra_bytes_per_tetrahedron"] = bytes_per_tetrahedron(formats::PackedFile::open(packed_path), packed);
  const Usage usage = usage_so_far();
  row["peak_bytes"] = usage.peak_bytes;
  row["worker_peak_bytes"] = usage.worker_peak_bytes;
  table.rows.push_back(std::move(row));
  return table;
}

}  // namespace rhoray::tools

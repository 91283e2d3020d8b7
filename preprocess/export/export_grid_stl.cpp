#include <cmath>

#include "formats/base/error.h"
#include "formats/base/pending_file.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/export/lost_facts.h"
#include "preprocess/export/stl_file.h"
#include "preprocess/export_grid.h"
#include "preprocess/process/counts.h"
#include "preprocess/process/run_writer.h"
#include "preprocess/process/worker_names.h"

namespace rhoray::preprocess {

ExportReport export_grid_stl(const std::filesystem::path& packed, double isovalue, const std::filesystem::path& output,
                             const ExportOptions& options) {
  if (!std::isfinite(isovalue))
    throw Error(ErrorCode::usage, concat("isovalue ", isovalue, "; expected a finite number"));
  const OpenedGrid opened = open_grid(packed, options.field, options.source_name);
  // here rather than in the worker process
  require_even_steps(opened, "the surface of a grid");
  PendingFile file(output, {.replace_existing = options.replace_existing});
  WorkerRequest request;
  request.program = import_worker;
  request.arguments = {"write-stl", packed.string(), options.field, concat(isovalue), file.open_name().string()};
  request.memory_limit_bytes = options.memory_limit_bytes;
  constexpr std::uint64_t most_triangles_in_cell = 5, triangle_bytes = 50;
  const auto samples = static_cast<std::uint64_t>(volume(opened.description().layout.sample_count));
  request.output_bytes = most_triangles_in_cell * triangle_bytes * samples;
  ExportReport report;
  const std::vector<std::uint64_t> counts = take_counts(run_writer(std::move(request), file), 2);
  const StlCounts triangles{.written = counts[0], .vanished = counts[1]};
  file.publish();
  report.triangle_count = triangles.written;
  report.file_bytes = std::filesystem::file_size(output);
  note_vanished(triangles, report.notes);
  note_lost_facts(opened, options.field, stl_facts, report.notes);
  return report;
}

}  // namespace rhoray::preprocess

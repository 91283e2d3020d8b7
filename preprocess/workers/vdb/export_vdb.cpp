#include "formats/base/error.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/export/lost_facts.h"
#include "preprocess/export_grid.h"
#include "preprocess/process/counts.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/process/run_writer.h"
#include "preprocess/process/worker_names.h"

namespace rhoray::preprocess {
namespace {

/// Adds notes on values that an OpenVDB grid represents differently.
void note_values(const formats::FieldSummary& field, std::vector<std::string>& notes) {
  using formats::ElementType;
  const bool needs_doubles =
      field.type == ElementType::F64 || field.type == ElementType::I32 || field.type == ElementType::U32;
  if (needs_doubles)
    notes.push_back(concat("field '", field.name, "' is written as a grid of doubles, which some programs refuse"));
  if (field.no_data_count != 0)
    notes.push_back(concat(count_text(field.no_data_count, "sample", "samples"), " without data written as inactive"));
}

}  // namespace

ExportReport export_vdb(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options) {
  const std::string extension = extension_of(output);
  if (extension != ".vdb" && extension != ".nvdb")
    throw Error(ErrorCode::usage,
                concat(output.string(), ": found extension '", extension, "'; expected .vdb or .nvdb"));
  const OpenedGrid opened = open_grid(packed, options.field, options.source_name);
  require_even_steps(opened, extension);
  const formats::FieldSummary& field = opened.summary();
  if (field.range.is_empty())
    throw Error(ErrorCode::invalid, concat(opened.name(), ": field '", field.name, "' holds no finite value"));

  PendingFile file(output, {.replace_existing = options.replace_existing});
  WorkerRequest request;
  request.program = vdb_worker;
  request.arguments = {"write", packed.string(), field.name, file.open_name().string(), extension};
  request.memory_limit_bytes = options.memory_limit_bytes;
  // Numbers of 8 bytes in whole nodes, of which a grid's border fills part.
  const auto samples = static_cast<std::uint64_t>(volume(opened.description().layout.sample_count));
  request.output_bytes = 16 * sizeof(double) * samples;
  ExportReport report;
  report.file_bytes = take_counts(run_writer(std::move(request), file), 1).front();
  file.publish();
  note_values(field, report.notes);
  note_lost_facts(opened, options.field, extension == ".vdb" ? vdb_facts : nvdb_facts, report.notes);
  return report;
}

}  // namespace rhoray::preprocess

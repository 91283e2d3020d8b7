#include <cmath>

#include "formats/base/error.h"
#include "formats/base/pending_file.h"
#include "preprocess/import/reading/time_steps.h"
#include "preprocess/import/worker_arguments.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/process/child_process.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/process/messages.h"
#include "preprocess/process/run_writer.h"
#include "preprocess/process/worker_names.h"
#include "preprocess/subdivide.h"

namespace rhoray::preprocess {
namespace {

namespace fs = std::filesystem;

template <class Options>
formats::PackedFile run_reader(const fs::path& path, std::vector<std::string> arguments, const Options& options,
                               std::string_view program = import_worker) {
  WorkerRequest request;
  request.program = program;
  request.doing = "reading " + path.string();
  request.arguments = std::move(arguments);
  request.memory_limit_bytes = options.memory_limit_bytes;
  request.scratch_folder = options.scratch_folder;
  request.input_bytes = bytes_of_single_file(path);
  if (options.progress)
    request.progress = [&](std::uint64_t done, std::uint64_t total) {
      options.progress("reading (bytes)", done, total);
    };
  return run_worker(request);
}

/// Upper bound of a VTU file's size for this mesh: VTK writes 8-byte numbers, at most in base64.
std::uint64_t vtu_bytes_bound(const NeutralMesh& mesh) {
  std::uint64_t numbers = 3 * mesh.points.size() + 7 * mesh.cells.size();
  for (const auto* fields : {&mesh.point_fields, &mesh.cell_fields})
    for (const NeutralField& field : *fields) numbers += field.values.size();
  return 4 * sizeof(double) * numbers;
}

/// Keeps the directions of the axes and sets their lengths.
void set_spacing(Affine& map, const Vec3& spacing) {
  if (!(spacing.x > 0 && spacing.y > 0 && spacing.z > 0) || !std::isfinite(spacing.x + spacing.y + spacing.z))
    throw Error(ErrorCode::usage, concat("spacing: found ", spacing.x, ", ", spacing.y, ", ", spacing.z,
                                         "; expected three finite numbers above 0"));
  map.x_axis *= spacing.x / map.x_axis.length();
  map.y_axis *= spacing.y / map.y_axis.length();
  map.z_axis *= spacing.z / map.z_axis.length();
}

void set_origin(Affine& map, const Vec3& origin) {
  if (!std::isfinite(origin.x + origin.y + origin.z))
    throw Error(ErrorCode::usage, "origin: found a number that is not finite; expected three finite numbers");
  map.origin = origin;
}

}  // namespace

NeutralVolume import_volume(const fs::path& path, const ImportVolumeOptions& options) {
  const std::string_view worker = options.raw ? import_worker : worker_for(path);
  const VolumeRequest request{
      .raw = options.raw, .field = options.field, .colors = options.colors, .time = options.time};
  if (worker != import_worker) refuse_time_step(options.time, path);
  NeutralVolume volume = receive_volume(run_reader(path, volume_arguments(path, request), options, worker), path);
  if (options.spacing) set_spacing(volume.world_from_grid, *options.spacing);
  if (options.origin) set_origin(volume.world_from_grid, *options.origin);
  return volume;
}

CellMesh import_cells(const fs::path& path, const ImportMeshOptions& options) {
  return receive_cell_mesh(run_reader(path, {"cells", path.string(), options.time}, options));
}

NeutralMesh import_mesh(const fs::path& path, const ImportMeshOptions& options) {
  CellMesh cells = import_cells(path, options);
  try {
    return subdivide(std::move(cells), {.max_error = options.max_error, .fields = options.error_fields},
                     options.progress);
  } catch (const Error& error) {  // the verb does not know the file
    throw Error(error.code(), concat(path.string(), ", ", error.what()), error.hint());
  }
}

NeutralSurface import_surface(const fs::path& path, const fs::path& sizes, const ImportMeshOptions& options) {
  return receive_surface(run_reader(path, {"surface", path.string(), sizes.string()}, options));
}

void export_mesh(const NeutralMesh& mesh, const fs::path& path, bool replace_existing) {
  if (extension_of(path) != ".vtu")
    throw Error(ErrorCode::usage, concat(path.string(), ": found extension '", extension_of(path), "'; expected .vtu"));
  PendingFile output(path, {.replace_existing = replace_existing});
  WorkerRequest request;
  request.program = import_worker;
  request.arguments = {"write-vtu", output.open_name().string()};
  request.output_bytes = vtu_bytes_bound(mesh);
  request.write_input = [&](int descriptor) { send(mesh, descriptor); };
  run_writer(std::move(request), output);
  output.publish();
}

}  // namespace rhoray::preprocess

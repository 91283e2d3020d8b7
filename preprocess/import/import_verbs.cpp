#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>

#include "formats/base/trouble.h"
#include "preprocess/import/foreign_file.h"
#include "preprocess/import/foreign_names.h"
#include "preprocess/import/worker_arguments.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/subdivide.h"
#include "preprocess/worker/child_process.h"
#include "preprocess/worker/handover.h"

namespace rhoray::preprocess {
namespace {

namespace fs = std::filesystem;

formats::PackedFile run_reader(const fs::path& path, std::vector<std::string> arguments,
                               std::uint64_t memory_limit_bytes, std::string_view program = import_worker) {
  WorkerRequest request;
  request.program = program;
  request.doing = "reading " + path.string();
  request.arguments = std::move(arguments);
  request.memory_limit_bytes = memory_limit_bytes;
  return run_worker(request);
}

/// The same directions at other distances.
void set_spacing(Affine& map, const Vec3& spacing) {
  if (!(spacing.x > 0 && spacing.y > 0 && spacing.z > 0) || !std::isfinite(spacing.x + spacing.y + spacing.z))
    throw Error(Trouble::usage, concat("spacing: found ", spacing.x, ", ", spacing.y, ", ", spacing.z,
                                       "; expected three finite numbers above 0"));
  map.x_axis *= spacing.x / map.x_axis.length();
  map.y_axis *= spacing.y / map.y_axis.length();
  map.z_axis *= spacing.z / map.z_axis.length();
}

void set_origin(Affine& map, const Vec3& origin) {
  if (!std::isfinite(origin.x + origin.y + origin.z))
    throw Error(Trouble::usage, "origin: found a number that is not finite; expected three finite numbers");
  map.origin = origin;
}

/// A new file in the folder of `path`, removed again unless it is given its name.
class PendingFile {
 public:
  explicit PendingFile(const fs::path& path) : final_(path) {
    const fs::path pending = concat(path.string(), ".", ::getpid(), ".vtu");
    const int descriptor = ::open(pending.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0) throw unwritable();
    ::close(descriptor);
    pending_ = pending;
  }
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  ~PendingFile() {
    if (!pending_.empty()) ::unlink(pending_.c_str());
  }

  const fs::path& path() const { return pending_; }

  void publish(bool replace_existing) {
    const int descriptor = ::open(pending_.c_str(), O_RDWR | O_CLOEXEC);
    if (descriptor < 0) throw unwritable();
    const bool is_on_disk = ::fsync(descriptor) == 0;
    ::close(descriptor);
    if (!is_on_disk) throw unwritable();
    const unsigned flags = replace_existing ? 0 : RENAME_NOREPLACE;
    if (::renameat2(AT_FDCWD, pending_.c_str(), AT_FDCWD, final_.c_str(), flags) != 0) throw unwritable();
    pending_.clear();
  }

  static Error exists(const fs::path& path) {
    return {Trouble::usage, concat(path.string(), ": found a file of this name; expected none"),
            "use --force to replace it"};
  }

 private:
  Error unwritable() const {
    if (errno == EEXIST) return exists(final_);
    const bool is_full = errno == ENOSPC || errno == EDQUOT;
    return {is_full ? Trouble::resource : Trouble::unreadable,
            concat(final_.string(), ": cannot be written: ", std::strerror(errno))};
  }

  fs::path final_, pending_;
};

}  // namespace

NeutralVolume import_volume(const fs::path& path, const ImportVolumeOptions& options) {
  NeutralVolume volume =
      take_volume(run_reader(path, volume_arguments(path, {.raw = options.raw, .field = options.field}),
                             options.memory_limit_bytes, options.raw ? import_worker : worker_for(path)));
  if (options.spacing) set_spacing(volume.world_from_grid, *options.spacing);
  if (options.origin) set_origin(volume.world_from_grid, *options.origin);
  return volume;
}

CellMesh import_cells(const fs::path& path, const ImportMeshOptions& options) {
  return take_cell_mesh(run_reader(path, {"cells", path.string(), options.time}, options.memory_limit_bytes));
}

NeutralMesh import_mesh(const fs::path& path, const ImportMeshOptions& options) {
  CellMesh cells = import_cells(path, options);
  try {
    return subdivide(std::move(cells), {.max_error = options.max_error});
  } catch (const Error& error) {  // the verb knows no file
    throw Error(error.trouble(), concat(path.string(), ", ", error.what()), error.hint());
  }
}

NeutralSurface import_surface(const fs::path& path, const fs::path& sizes, const ImportMeshOptions& options) {
  return take_surface(run_reader(path, {"surface", path.string(), sizes.string()}, options.memory_limit_bytes));
}

void export_mesh(const NeutralMesh& mesh, const fs::path& path, bool replace_existing) {
  if (extension_of(path) != ".vtu")
    throw Error(Trouble::usage, concat(path.string(), ": found extension '", extension_of(path), "'; expected .vtu"));
  if (!replace_existing && fs::exists(path)) throw PendingFile::exists(path);
  PendingFile pending(path);
  WorkerRequest request;
  request.program = import_worker;
  request.doing = "writing " + path.string();
  request.arguments = {"write-vtu", pending.path().string()};
  request.write_input = [&](int descriptor) { hand_over(mesh, descriptor); };
  run_worker(request);
  pending.publish(replace_existing);
}

}  // namespace rhoray::preprocess

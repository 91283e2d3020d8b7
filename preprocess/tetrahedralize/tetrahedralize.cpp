#include "preprocess/tetrahedralize.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cmath>

#include "formats/base/trouble.h"
#include "preprocess/tetrahedralize/job.h"
#include "preprocess/worker/child_process.h"
#include "preprocess/worker/handover.h"

namespace rhoray::preprocess {

namespace {

void check_volume(double v) {
  if (!(v >= 0 && std::isfinite(v)))
    throw Error(Trouble::usage, concat("maximum volume ", v, "; expected 0 (no limit) or a positive volume"));
}

void check(const SizeField& sizes) {
  if (const auto* mesh = std::get_if<NeutralMesh>(&sizes); mesh != nullptr && mesh->point_fields.empty())
    throw Error(Trouble::usage, "size field: the mesh has no point field; expected one with wanted edge lengths");
  if (const auto* d = std::get_if<SizeByDistance>(&sizes))
    if (!(d->near > 0 && d->far >= d->near && d->growth >= 0 && std::isfinite(d->far + d->growth)))
      throw Error(Trouble::usage, concat("size field: near ", d->near, ", far ", d->far, ", growth ", d->growth,
                                         "; expected 0 < near <= far and a growth of at least 0"));
}

void check(const TetrahedralizeOptions& options) {
  const double q = options.quality;
  if (!(q == 0 || (q >= 1 && std::isfinite(q))))
    throw Error(Trouble::usage, concat("quality ", q, "; expected 0 or a ratio of at least 1"),
                "1.4 is a good ratio; below about 1.2 TetGen may not come to an end");
  check_volume(options.max_volume);
  for (const auto& limit : options.region_volumes) check_volume(limit.max_volume);
  if (!options.regions && (!options.region_volumes.empty() || options.empty_cavities))
    throw Error(Trouble::usage, "volumes of single regions and empty cavities need the numbers of regions");
  check_tetgen_switches(options.tetgen);
  if (options.size_field) check(*options.size_field);
}

/// The size field in an anonymous file that the worker inherits.
class SizeFile {
 public:
  explicit SizeFile(const SizeField* sizes) {
    if (sizes == nullptr) return;
    parcel_.descriptor = memfd_create("rhoray-sizes", 0);
    if (parcel_.descriptor < 0) throw Error(Trouble::resource, "filling a surface: no descriptor for the size field");
    if (const auto* volume = std::get_if<NeutralVolume>(sizes)) {
      parcel_.kind = "volume";
      hand_over(*volume, parcel_.descriptor);
    } else if (const auto* mesh = std::get_if<NeutralMesh>(sizes)) {
      parcel_.kind = "mesh";
      hand_over(*mesh, parcel_.descriptor);
    } else {
      parcel_.kind = "distance";
      hand_over(std::get<SizeByDistance>(*sizes).surface, parcel_.descriptor);
    }
  }
  SizeFile(const SizeFile&) = delete;
  SizeFile& operator=(const SizeFile&) = delete;
  ~SizeFile() {
    if (parcel_.descriptor >= 0) close(parcel_.descriptor);
  }
  const SizeParcel& parcel() const { return parcel_; }

 private:
  SizeParcel parcel_;
};

}  // namespace

NeutralMesh tetrahedralize(const NeutralSurface& surface, const TetrahedralizeOptions& options) {
  check(options);
  const SizeFile sizes(options.size_field.get());
  WorkerRequest request;
  request.program = "rhoray-tetgen-worker";
  request.doing = "filling a surface with tetrahedra";
  request.arguments = arguments_of(options, sizes.parcel());
  request.write_input = [&](int descriptor) { hand_over(surface, descriptor); };
  request.memory_limit_bytes = options.memory_limit_bytes;
  request.time_limit_s = options.time_limit_s;
  return take_mesh(run_worker(request));
}

}  // namespace rhoray::preprocess

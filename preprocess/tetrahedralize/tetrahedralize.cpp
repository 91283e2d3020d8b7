#include "preprocess/tetrahedralize.h"

#include <cmath>

#include "formats/base/trouble.h"
#include "preprocess/tetrahedralize/job.h"
#include "preprocess/worker/child_process.h"
#include "preprocess/worker/handover.h"

namespace rhoray::preprocess {

namespace {

void check(const TetrahedralizeOptions& options) {
  const double q = options.quality, v = options.max_volume;
  if (!(q == 0 || (q >= 1 && std::isfinite(q))))
    throw Error(Trouble::usage, concat("quality ", q, "; expected 0 or a ratio of at least 1"),
                "1.4 is a good ratio; below about 1.2 TetGen may not come to an end");
  if (!(v >= 0 && std::isfinite(v)))
    throw Error(Trouble::usage, concat("maximum volume ", v, "; expected 0 (no limit) or a positive volume"));
}

}  // namespace

NeutralMesh tetrahedralize(const NeutralSurface& surface, const TetrahedralizeOptions& options) {
  check(options);
  WorkerRequest request;
  request.program = "rhoray-tetgen-worker";
  request.doing = "filling a surface with tetrahedra";
  request.arguments = arguments_of(options);
  request.write_input = [&](int descriptor) { hand_over(surface, descriptor); };
  request.memory_limit_bytes = options.memory_limit_bytes;
  request.time_limit_s = options.time_limit_s;
  return take_mesh(run_worker(request));
}

}  // namespace rhoray::preprocess

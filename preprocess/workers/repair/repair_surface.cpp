#include "preprocess/repair_surface.h"

#include "formats/base/error.h"
#include "preprocess/process/child_process.h"
#include "preprocess/process/messages.h"
#include "preprocess/workers/repair/report.h"

namespace rhoray::preprocess {

RepairedSurface repair_surface(const NeutralSurface& surface, const RepairOptions& options) {
  if (!(options.wrap >= 0 && options.wrap <= 1))
    throw Error(ErrorCode::usage, concat("wrap ", options.wrap, "; expected 0 (mend) or a share of the box diagonal"));
  if (!(options.max_move >= 0 && options.max_move <= 1))
    throw Error(ErrorCode::usage, concat("largest move ", options.max_move, "; expected a share of the box diagonal"));
  WorkerRequest request;
  request.program = "rhoray-repair-worker";
  request.doing = options.wrap > 0 ? "wrapping a surface" : "repairing a surface";
  request.arguments = repair::arguments_of(options);
  request.write_input = [&](int descriptor) { send(surface, descriptor); };
  request.memory_limit_bytes = options.memory_limit_bytes;
  request.time_limit_s = options.time_limit_s;

  RepairedSurface result;
  result.surface = receive_surface(run_worker(request));
  if (result.surface.notes.empty()) throw Error(ErrorCode::internal, "the repairing worker sent no report");
  result.report = repair::report_from(result.surface.notes.back());
  result.surface.notes = repair::sentences(result.report);
  return result;
}

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <functional>

#include "formats/packed_file.h"
#include "preprocess/process/worker_request.h"

namespace rhoray::preprocess {

/// Runs the worker to its end and returns what it handed over, a packed file without a name.
///
/// The worker runs under limits of its memory, of the files that it writes, of how many it has open, and of the time
/// that it may do nothing (limits.h); it leaves no core file.
///
/// The worker is started as `program ARGUMENTS...` with the descriptors' numbers in RHORAY_INPUT_FD and
/// RHORAY_OUTPUT_FD. It ends with 0 after writing its output, or with a ErrorCode's number after printing the fact as
/// its last line of stderr, and before it, where it has one, a line "hint: ...". That refusal is thrown here again as
/// the same Error. A worker that dies (signal, limit) or breaks this promise is reported as an Error that says what it
/// was doing, how it ended and what it printed last.
formats::PackedFile run_worker(const WorkerRequest& request);

/// Inside a worker: says how far it is, a few times a second at most; elsewhere nothing. May be called from any thread.
void report_worker_progress(std::uint64_t done, std::uint64_t total);

/// The other side: runs `act(input descriptor or -1, output descriptor)` inside a worker's main and keeps the promise
/// above. Returns the exit code.
int worker_main(const std::function<void(int input, int output)>& act);

}  // namespace rhoray::preprocess

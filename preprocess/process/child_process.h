#pragma once

#include <cstdint>
#include <functional>

#include "formats/packed_file.h"
#include "preprocess/process/worker_request.h"

namespace rhoray::preprocess {

/// Runs the worker to its end and returns its output, a packed file without a name.
///
/// The worker runs under limits of its memory, the files that it writes, its number of open files,
/// and the time that it may be idle (limits.h). It leaves no core file.
///
/// The worker is started as `program ARGUMENTS...` with the descriptors' numbers in RHORAY_INPUT_FD
/// and RHORAY_OUTPUT_FD. On success it exits with 0 after writing its output. On a refusal it exits
/// with an ErrorCode's number after printing the reason as its last line of stderr; a line "hint:
/// ..." may come before it. That refusal is rethrown here as the same Error. A worker that dies
/// (signal, limit) or breaks this protocol is reported as an Error that says what it was doing and
/// how it ended. All else that it prints is passed on as the text of libraries (library_text.h).
formats::PackedFile run_worker(const WorkerRequest& request);

/// Inside a worker: reports its progress, a few times a second at most. Does nothing elsewhere.
/// Thread-safe.
void report_worker_progress(std::uint64_t done, std::uint64_t total);

/// The worker's side: runs `act(input descriptor or -1, output descriptor)` in a worker's main and
/// follows the protocol above. Returns 0; a refusal ends the process.
int worker_main(const std::function<void(int input, int output)>& act);

}  // namespace rhoray::preprocess

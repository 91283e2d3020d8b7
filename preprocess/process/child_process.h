#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "formats/packed_file.h"

namespace rhoray::preprocess {

/// One act in a process of its own, so that a foreign library's crash, abort or runaway ends there and becomes a
/// sentence.
struct WorkerRequest {
  std::string program;  ///< name of a program beside our own ("rhoray-import-worker"), or in RHORAY_WORKER_DIR
  std::string doing;    ///< for messages: "reading bone.vtu"
  std::vector<std::string> arguments;
  std::function<void(int descriptor)> write_input;  ///< fills what the worker reads; may be empty
  /// Private writable memory of the worker; 0 = default_memory_limit of limits.h.
  std::uint64_t memory_limit_bytes = 0;
  /// When not empty, what goes over and the large arrays of the worker lie in nameless files of this folder instead
  /// of memory, and memory_limit_bytes counts anonymous memory only (memory_cap.h).
  std::filesystem::path scratch_folder;
  double time_limit_s = 0;  ///< CPU time of the worker; 0 = none
  /// Told what the worker reports of its progress. When it throws, the worker is ended and the exception passed on.
  std::function<void(std::uint64_t done, std::uint64_t total)> progress{};
  /// Size of the files that the worker reads, for the default limit of its memory; 0 = not known.
  std::uint64_t input_bytes = 0;
  /// Bound for a file that the worker writes beside its answer; 0 = it writes none.
  std::uint64_t output_bytes = 0;
  /// The worker is stopped after this time in which it used no CPU time and read or wrote no byte; 0 = never.
  double idle_limit_s = 60;
};

/// Runs the worker to its end and returns what it handed over, a packed file without a name.
///
/// The worker runs under limits of its memory, of the files that it writes, of how many it has open, and of the time
/// that it may do nothing (limits.h); it leaves no core file.
///
/// The worker is started as `program ARGUMENTS...` with the descriptors' numbers in RHORAY_INPUT_FD and
/// RHORAY_OUTPUT_FD. It ends with 0 after writing its output, or with a Trouble's number after printing the fact as its
/// last line of stderr, and before it, where it has one, a line "hint: ...". That refusal is thrown here again as the
/// same Error. A worker that dies (signal, limit) or breaks this promise is reported as an Error that says what it was
/// doing, how it ended and what it printed last.
formats::PackedFile run_worker(const WorkerRequest& request);

/// Inside a worker: says how far it is, a few times a second at most; elsewhere nothing. May be called from any thread.
void report_worker_progress(std::uint64_t done, std::uint64_t total);

/// The other side: runs `act(input descriptor or -1, output descriptor)` inside a worker's main and keeps the promise
/// above. Returns the exit code.
int worker_main(const std::function<void(int input, int output)>& act);

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace rhoray::preprocess {

/// One task in a separate process, so that a foreign library's crash, abort or runaway ends there
/// and becomes an error message.
struct WorkerRequest {
  /// a program beside our own ("rhoray-import-worker"), or in RHORAY_WORKER_DIR
  std::string program;
  std::string doing;  ///< for messages: "reading bone.vtu"
  std::vector<std::string> arguments;
  std::function<void(int descriptor)> write_input;  ///< writes the worker's input; may be empty
  /// Private writable memory of the worker; 0 = default_memory_limit of limits.h.
  std::uint64_t memory_limit_bytes = 0;
  /// When not empty, the messages and the large arrays of the worker are files without names in
  /// this folder instead of memory, and memory_limit_bytes counts anonymous memory only
  /// (process/memory_cap.h).
  std::filesystem::path scratch_folder;
  double time_limit_s = 0;  ///< CPU time of the worker; 0 = none
  /// Receives the worker's progress reports. When it throws, the worker is ended and the exception
  /// is passed on.
  std::function<void(std::uint64_t done, std::uint64_t total)> progress{};
  /// Size of the files that the worker reads, for the default limit of its memory; 0 = not known.
  std::uint64_t input_bytes = 0;
  /// Limit for a file that the worker writes in addition to its answer; 0 = it writes none.
  std::uint64_t output_bytes = 0;
  /// The worker is stopped after this much time without using CPU time or reading or writing a
  /// byte; 0 = never.
  double idle_limit_s = 60;
};

}  // namespace rhoray::preprocess

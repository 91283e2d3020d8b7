#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

namespace rhoray::preprocess {

/// Holds this process under a cap on anonymous memory, the kind that the system cannot drop: while it lives, every
/// Array of 1 MiB or more is a nameless file in `folder`, mapped, and the rest of the process may not grow beyond
/// `bytes` (RLIMIT_DATA; what threads reserve for their stacks comes on top, as it counts there but is hardly touched).
/// Beyond it allocating fails. Workers are held likewise by their own options (memory_limit_bytes and scratch_folder).
///
/// Not for several threads, one at a time, and arrays made meanwhile must be gone before it is.
class MemoryCap {
 public:
  /// Programs, libraries and buffers take about this much of any run: smaller caps could not be kept.
  static constexpr std::uint64_t smallest_bytes = std::uint64_t{16} << 20;

  /// Refuses caps below the smallest (ErrorCode::usage), and when the system does not take the limit
  /// (ErrorCode::resource).
  MemoryCap(std::uint64_t bytes, std::filesystem::path folder);
  MemoryCap(const MemoryCap&) = delete;
  MemoryCap& operator=(const MemoryCap&) = delete;
  ~MemoryCap();

  /// True when the folder's files are memory themselves (tmpfs), so that a cap there saves nothing.
  static bool folder_is_memory(const std::filesystem::path& folder);

 private:
  struct Before;
  std::unique_ptr<Before> before_;
};

}  // namespace rhoray::preprocess

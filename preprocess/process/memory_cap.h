#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

namespace rhoray::preprocess {

/// Keeps this process under a cap on anonymous memory, the kind that the system cannot drop. While
/// the object lives, every Array of 1 MiB or more is a mapped file without a name in `folder`. The
/// rest of the process may not grow beyond `bytes` (RLIMIT_DATA); beyond it, allocation fails.
/// Address space reserved for thread stacks comes on top: it counts towards the limit but is hardly
/// touched. Workers are limited in the same way by their own options (memory_limit_bytes and
/// scratch_folder).
///
/// Not thread-safe. Only one may exist at a time, and arrays made during its lifetime must be
/// destroyed before it.
class MemoryCap {
 public:
  /// Programs, libraries and buffers take about this much of any run, so smaller caps could not be
  /// kept.
  static constexpr std::uint64_t smallest_bytes = std::uint64_t{16} << 20;

  /// Refuses caps below the smallest (ErrorCode::usage). Refuses when the system does not accept
  /// the limit (ErrorCode::resource).
  MemoryCap(std::uint64_t bytes, std::filesystem::path folder);
  MemoryCap(const MemoryCap&) = delete;
  MemoryCap& operator=(const MemoryCap&) = delete;
  ~MemoryCap();

  /// True when the folder's files are held in memory (tmpfs), so that a cap there saves nothing.
  static bool folder_is_memory(const std::filesystem::path& folder);

 private:
  struct Before;
  std::unique_ptr<Before> before_;
};

}  // namespace rhoray::preprocess

#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace rhoray::preprocess {

struct WorkerRequest;

/// Returns the largest amount of memory that this process may use: the machine's, or less where
/// control groups (version 1 or 2) limit it.
std::uint64_t usable_memory_bytes();

/// Returns the smallest limit set by the control groups named in `own_groups` (the text of
/// /proc/self/cgroup) and by their ancestors; nothing where none is set.
/// @param root  where control groups are mounted, usually /sys/fs/cgroup
std::optional<std::uint64_t> group_memory_limit(const std::string& own_groups, const std::filesystem::path& root);

/// The private memory that a worker may have unless its caller sets a limit: 8 GiB plus 1024 times
/// the bytes of its input, but at most nine tenths of the usable memory. Deflated data grow at most
/// 1032 times and text at most 8 times. Every sound file that fits the machine's memory is
/// therefore read.
/// @param input_bytes  0 = not known, so that nine tenths of the usable memory are the limit
std::uint64_t default_memory_limit(std::uint64_t input_bytes, std::uint64_t usable_bytes);

/// All limits of a worker process. Lower limits that this process already has are kept.
struct WorkerLimits {
  /// private writable memory (RLIMIT_DATA); on top 16 MiB for the stack of each core's thread
  rlimit memory;
  rlimit file_size;  ///< of each file that it writes (RLIMIT_FSIZE)
  rlimit open_files;
  rlimit core;
  std::optional<rlimit> time;  ///< CPU time
};

/// Largest number of files that a worker may have open. Readers open few, and close those they have
/// mapped.
inline constexpr rlim_t most_open_files = 256;

/// Refuses when the system does not report this process's own limits (ErrorCode::internal).
WorkerLimits limits_for(const WorkerRequest& request);

/// Activity of a process so far, as far as the system shows it to others.
struct Activity {
  std::uint64_t computing_ticks = 0;  ///< in user and system mode, all threads
  /// by calls, and from disks for mapped files; 0 where not counted
  std::uint64_t read_bytes = 0, written_bytes = 0;

  friend bool operator==(const Activity&, const Activity&) = default;
};

/// Nothing when the process is gone or may not be inspected.
std::optional<Activity> activity_of(pid_t process);

/// Detects a process that does nothing. Only time in which it was checked often counts: while this
/// process was stopped, the other one probably was too.
class IdleWatch {
 public:
  /// @param limit_s  0 = never
  IdleWatch(pid_t process, double limit_s) : process_(process), limit_s_(limit_s) {}

  /// Longest wait before the next check, in milliseconds; -1 = for ever.
  int pause_ms() const;

  /// Checks the process. Returns true when it did nothing for the whole limit.
  /// @param elapsed_s  since the last check
  bool is_over(double elapsed_s);

 private:
  pid_t process_;
  double limit_s_;
  double idle_s_ = 0;
  std::optional<Activity> last_{};
};

}  // namespace rhoray::preprocess

#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace rhoray::preprocess {

struct WorkerRequest;

/// Memory that this process may use at most: the machine's, or less where control groups (version 1 or 2) say so.
std::uint64_t usable_memory_bytes();

/// The least limit that the control groups named in `own_groups` (the text of /proc/self/cgroup) and those around them
/// set; nothing where they set none.
/// @param root  where control groups are mounted, usually /sys/fs/cgroup
std::optional<std::uint64_t> group_memory_limit(const std::string& own_groups, const std::filesystem::path& root);

/// Private memory that a worker may have unless its caller says otherwise: 8 GiB and 1024 times the bytes of its input,
/// but at most nine tenths of the usable memory. Deflated bytes grow at most 1032 times and text at most 8 times, so
/// every sound file is read that the machine can hold.
/// @param input_bytes  0 = not known, so that nine tenths of the usable memory are the limit
std::uint64_t default_memory_limit(std::uint64_t input_bytes, std::uint64_t usable_bytes);

/// Every limit of a worker process. Limits that this process is under already stay where they are lower.
struct WorkerLimits {
  rlimit memory;     ///< private writable memory (RLIMIT_DATA); on top 16 MiB for the stack of each core's thread
  rlimit file_size;  ///< of each file that it writes (RLIMIT_FSIZE)
  rlimit open_files;
  rlimit core;
  std::optional<rlimit> time;  ///< of computing
};

/// How many files a worker may have open: readers have few, and close what they have mapped.
inline constexpr rlim_t most_open_files = 256;

/// Refuses (ErrorCode::internal) when the system does not tell this process's own limits.
WorkerLimits limits_for(const WorkerRequest& request);

/// What a process has done so far, as far as the system tells others.
struct Activity {
  std::uint64_t computing_ticks = 0;                ///< in user and system mode, all threads
  std::uint64_t read_bytes = 0, written_bytes = 0;  ///< by calls, and from disks for mapped files; 0 where not counted

  friend bool operator==(const Activity&, const Activity&) = default;
};

/// Nothing when the process is gone or may not be looked at.
std::optional<Activity> activity_of(pid_t process);

/// Notices a process that does nothing. Only time in which it was looked at often counts: while this process was
/// stopped, the other one probably was too.
class IdleWatch {
 public:
  /// @param limit_s  0 = never
  IdleWatch(pid_t process, double limit_s) : process_(process), limit_s_(limit_s) {}

  /// How long to wait at most before the next look, in milliseconds; -1 = for ever.
  int pause_ms() const;

  /// CandidateList at the process. True when it did nothing for the whole limit.
  /// @param elapsed_s  since the last look
  bool is_over(double elapsed_s);

 private:
  pid_t process_;
  double limit_s_;
  double idle_s_ = 0;
  std::optional<Activity> last_{};
};

}  // namespace rhoray::preprocess

#include "preprocess/process/limits.h"

#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/process/worker_request.h"

namespace rhoray::preprocess {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t mebibyte = std::uint64_t{1} << 20, gibibyte = std::uint64_t{1} << 30;

/// Address space that a thread's stack may reserve: the usual limit of 8 MiB, twice. It counts as
/// private memory but is hardly used.
constexpr std::uint64_t stack_bytes = 16 * mebibyte;

/// For the header of an answer, and for small files beside a large one.
constexpr std::uint64_t small_file_bytes = 64 * mebibyte;

constexpr auto unlimited = static_cast<std::uint64_t>(RLIM_INFINITY);

std::uint64_t capped_sum(std::uint64_t a, std::uint64_t b) {
  return a > unlimited - b ? unlimited : a + b;
}

std::string text_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The number at the start of a text; nothing for "max" and other text.
std::optional<std::uint64_t> number_in(const std::string& text) {
  std::uint64_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc() ? std::optional(number) : std::nullopt;
}

/// The smallest number that a group and its ancestors have in the file of this name.
std::optional<std::uint64_t> least_of_groups(const fs::path& root, const std::string& group, const char* file) {
  std::optional<std::uint64_t> least;
  for (fs::path path = fs::path(group).relative_path();; path = path.parent_path()) {
    if (const auto limit = number_in(text_of_file(root / path / file)))
      least = std::min(*limit, least.value_or(*limit));
    if (path.empty()) return least;
  }
}

std::uint64_t machine_memory_bytes() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return unlimited;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
}

using Resource = decltype(RLIMIT_DATA);

/// The requested limit, but not above this process's own.
rlimit within_own(Resource resource, const char* name, std::uint64_t soft, std::uint64_t hard) {
  rlimit own{};
  if (::getrlimit(resource, &own) != 0)
    throw Error(ErrorCode::internal, concat("the system does not tell the limit ", name, ": ", std::strerror(errno)));
  return {.rlim_cur = std::min<rlim_t>(soft, own.rlim_cur), .rlim_max = std::min<rlim_t>(hard, own.rlim_max)};
}

/// The largest file that a worker may have to write. Its answer is made from arrays in its memory.
/// With a scratch folder the answer is stored there, and the disk is the limit. Files that it
/// writes for the caller were declared.
std::uint64_t largest_file_bytes(const WorkerRequest& request, std::uint64_t memory_bytes) {
  std::uint64_t bytes = memory_bytes;
  if (struct statvfs disk{}; !request.scratch_folder.empty() && ::statvfs(request.scratch_folder.c_str(), &disk) == 0)
    bytes = std::max<std::uint64_t>(bytes, disk.f_bavail * disk.f_frsize);
  return capped_sum(std::max(bytes, request.output_bytes), small_file_bytes);
}

}  // namespace

std::optional<std::uint64_t> group_memory_limit(const std::string& own_groups, const fs::path& root) {
  std::optional<std::uint64_t> least;
  std::istringstream lines(own_groups);  // such as "0::/user.slice" or "4:memory:/job"
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const std::string group = line.substr(second + 1);
    std::optional<std::uint64_t> limit;
    if (controllers == ",,") limit = least_of_groups(root, group, "memory.max");
    if (controllers.find(",memory,") != std::string::npos)
      limit = least_of_groups(root / "memory", group, "memory.limit_in_bytes");
    if (limit) least = std::min(*limit, least.value_or(*limit));
  }
  return least;
}

std::uint64_t usable_memory_bytes() {
  const std::uint64_t machine = machine_memory_bytes();
  return std::min(machine, group_memory_limit(text_of_file("/proc/self/cgroup"), "/sys/fs/cgroup").value_or(machine));
}

std::uint64_t default_memory_limit(std::uint64_t input_bytes, std::uint64_t usable_bytes) {
  const std::uint64_t share = usable_bytes / 10 * 9;
  constexpr std::uint64_t growth = 1024, base = 8 * gibibyte;
  if (input_bytes == 0 || input_bytes > (unlimited - base) / growth) return share;
  return std::min(share, base + growth * input_bytes);
}

WorkerLimits limits_for(const WorkerRequest& request) {
  const std::uint64_t stacks = stack_bytes * std::max(1U, std::thread::hardware_concurrency());
  // A limit that was requested is kept to the byte.
  const std::uint64_t memory =
      request.memory_limit_bytes != 0
          ? request.memory_limit_bytes
          : capped_sum(default_memory_limit(request.input_bytes, usable_memory_bytes()), stacks);
  const std::uint64_t file_size = largest_file_bytes(request, memory);
  WorkerLimits limits{.memory = within_own(RLIMIT_DATA, "RLIMIT_DATA", memory, memory),
                      .file_size = within_own(RLIMIT_FSIZE, "RLIMIT_FSIZE", file_size, file_size),
                      .open_files = within_own(RLIMIT_NOFILE, "RLIMIT_NOFILE", most_open_files, most_open_files),
                      .core = {0, 0},
                      .time = std::nullopt};
  if (request.time_limit_s > 0) {
    const auto seconds = static_cast<std::uint64_t>(std::ceil(std::min(request.time_limit_s, 1e9)));
    // SIGXCPU first, SIGKILL if it is ignored.
    limits.time = within_own(RLIMIT_CPU, "RLIMIT_CPU", seconds, seconds + 2);
  }
  return limits;
}

std::optional<Activity> activity_of(pid_t process) {
  const std::string stat = text_of_file(concat("/proc/", process, "/stat"));
  const std::size_t name_end = stat.rfind(')');  // the program's name may hold any character
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream fields(stat.substr(name_end + 1));
  std::string passed_over;  // skipped: state, and ten numbers up to the fourteenth field of proc(5)
  for (int field = 3; field < 14; ++field) fields >> passed_over;
  Activity activity;
  std::uint64_t user = 0, system = 0;
  if (!(fields >> user >> system)) return std::nullopt;
  activity.computing_ticks = user + system;

  const std::string transfers = text_of_file(concat("/proc/", process, "/io"));
  std::istringstream lines(transfers);
  // on a kernel that does not count them, CPU time alone counts
  bool is_complete = transfers.empty();
  std::string name;
  for (std::uint64_t bytes = 0; lines >> name >> bytes;) {
    if (name == "rchar:" || name == "read_bytes:") activity.read_bytes += bytes;
    if (name == "wchar:" || name == "write_bytes:") activity.written_bytes += bytes;
    is_complete |= name == "write_bytes:";
  }
  return is_complete ? std::optional(activity) : std::nullopt;
}

int IdleWatch::pause_ms() const {
  if (limit_s_ <= 0) return -1;
  return static_cast<int>(std::clamp(1000 * limit_s_ / 8, 1.0, 1000.0));
}

bool IdleWatch::is_over(double elapsed_s) {
  if (limit_s_ <= 0) return false;
  const std::optional<Activity> now = activity_of(process_);
  const bool is_idle = now && now == last_;
  last_ = now;
  idle_s_ = is_idle ? idle_s_ + std::min(elapsed_s, 2e-3 * pause_ms()) : 0;
  return idle_s_ >= limit_s_;
}

}  // namespace rhoray::preprocess

#include "preprocess/process/memory_cap.h"

#include <linux/magic.h>
#include <sys/resource.h>
#include <sys/vfs.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory_resource>
#include <thread>
#include <utility>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "preprocess/process/scratch_memory.h"

namespace rhoray::preprocess {
namespace {

/// Address space that a thread's stack may reserve: the usual limit of 8 MiB, twice. Checksums and
/// sorting each use threads.
constexpr std::uint64_t stack_bytes = std::uint64_t{16} << 20;

rlim_t limit_with_stacks(std::uint64_t bytes) {
  return bytes + stack_bytes * std::max(1U, std::thread::hardware_concurrency());
}

}  // namespace

struct MemoryCap::Before {
  explicit Before(std::filesystem::path folder) : scratch(std::move(folder)) {}

  ScratchMemory scratch;
  std::pmr::memory_resource* resource = nullptr;
  rlimit limit{};
};

MemoryCap::MemoryCap(std::uint64_t bytes, std::filesystem::path folder)
    : before_(std::make_unique<Before>(std::move(folder))) {
  if (bytes < smallest_bytes)
    throw Error(ErrorCode::usage, concat("memory: found a cap of ", bytes, " bytes; expected at least ",
                                         smallest_bytes >> 20, "M, which the program and its libraries need"));
  const auto refuse = [&](const char* call) {
    throw Error(ErrorCode::resource, concat("memory: the system cannot limit this process to ", bytes, " bytes: ", call,
                                            ": ", std::strerror(errno)));
  };
  if (::getrlimit(RLIMIT_DATA, &before_->limit) != 0) refuse("getrlimit");
  rlimit limit = before_->limit;
  limit.rlim_cur = std::min(limit.rlim_cur, limit_with_stacks(bytes));
  if (::setrlimit(RLIMIT_DATA, &limit) != 0) refuse("setrlimit");
  before_->resource = std::pmr::set_default_resource(&before_->scratch);
}

MemoryCap::~MemoryCap() {
  // back to a limit that the system has accepted before
  RHORAY_CHECK(::setrlimit(RLIMIT_DATA, &before_->limit) == 0);
  std::pmr::set_default_resource(before_->resource);
}

bool MemoryCap::folder_is_memory(const std::filesystem::path& folder) {
  struct statfs facts {};
  if (::statfs(folder.c_str(), &facts) != 0) return false;
  return facts.f_type == TMPFS_MAGIC || facts.f_type == RAMFS_MAGIC;
}

}  // namespace rhoray::preprocess

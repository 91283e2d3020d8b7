#pragma once

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace rhoray::tools {

/// A file in memory that other code, or another process, opens by a path or inherits. Failures are
/// thrown as std::system_error.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view content = {}) : descriptor_(::memfd_create("rhoray", MFD_CLOEXEC)) {
    check(descriptor_ >= 0);
    for (std::size_t done = 0; done < content.size();) {
      const ssize_t count = ::write(descriptor_, content.data() + done, content.size() - done);
      check(count > 0);
      done += static_cast<std::size_t>(count);
    }
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  int descriptor() const { return descriptor_; }
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

  std::vector<std::byte> bytes() const {
    struct stat status {};
    check(::fstat(descriptor_, &status) == 0);
    std::vector<std::byte> all(static_cast<std::size_t>(status.st_size));
    for (std::size_t done = 0; done < all.size();) {
      const ssize_t count = ::pread(descriptor_, all.data() + done, all.size() - done, static_cast<off_t>(done));
      check(count > 0);
      done += static_cast<std::size_t>(count);
    }
    return all;
  }

 private:
  static void check(bool works) {
    if (!works) throw std::system_error(errno, std::system_category(), "a file in memory");
  }

  int descriptor_;
};

}  // namespace rhoray::tools

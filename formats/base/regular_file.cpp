#include "formats/base/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"

namespace rhoray {
namespace {

[[noreturn]] void refuse_by_system(const std::filesystem::path& path) {
  const int reason = errno;
  throw Error(ErrorCode::unreadable, concat(path.string(), ": ", std::system_category().message(reason)));
}

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

void require_regular(const std::filesystem::path& path, const struct stat& status) {
  if (S_ISREG(status.st_mode)) return;
  throw Error(ErrorCode::unreadable, concat(path.string(), ": found ", kind_of(status.st_mode), "; expected a file"),
              S_ISFIFO(status.st_mode) ? "save what comes through the pipe to a file first" : "");
}

std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());  // a folder lists its files in no particular order
  return names;
}

}  // namespace

void require_regular_file(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) refuse_by_system(path);
  require_regular(path, status);
}

void require_readable(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error_code;
  const std::filesystem::file_status status = std::filesystem::status(path, error_code);
  if (!std::filesystem::exists(status)) {
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    if (!std::filesystem::is_directory(folder, error_code))
      throw Error(ErrorCode::unreadable, concat(name, ": no such file; there is no folder ", folder.string()));
    throw Error(ErrorCode::unreadable, concat(name, ": no such file"),
                did_you_mean(path.filename().string(), names_in(folder)));
  }
  if (!std::filesystem::is_directory(status)) require_regular_file(path);
  if (::access(path.c_str(), R_OK) != 0)
    throw Error(ErrorCode::unreadable, concat(name, ": cannot be read (", std::strerror(errno), ")"));
}

int open_regular_file(const std::filesystem::path& path) {
  require_regular_file(path);  // opening some devices already has side effects
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) refuse_by_system(path);
  try {
    struct stat status {};
    if (::fstat(descriptor, &status) != 0) refuse_by_system(path);
    require_regular(path, status);  // another file may have taken the name meanwhile
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  return descriptor;
}

std::string first_bytes(const std::filesystem::path& path, std::size_t count) {
  int descriptor = -1;
  try {
    descriptor = open_regular_file(path);
  } catch (const Error&) {
    return {};
  }
  constexpr std::size_t first_read = 4096;  // grows: a file may be much shorter than what is asked for
  std::string bytes;
  std::size_t filled = 0;
  while (filled < count) {
    if (filled == bytes.size()) bytes.resize(std::min(count, std::max(first_read, 2 * filled)));
    const ssize_t got = ::read(descriptor, bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) filled = 0;
    if (got <= 0) break;
    filled += static_cast<std::size_t>(got);
  }
  ::close(descriptor);
  bytes.resize(filled);
  return bytes;
}

}  // namespace rhoray

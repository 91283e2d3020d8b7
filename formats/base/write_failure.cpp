#include "formats/base/write_failure.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

#include <cerrno>
#include <system_error>

namespace rhoray {
namespace {

ErrorCode error_code_of(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
    case EISDIR:
    case ELOOP:
    case ENAMETOOLONG:
      return ErrorCode::usage;
    default:
      return ErrorCode::resource;
  }
}

/// " (needed: 100 bytes, free: 10 bytes)", as far as known. Bytes that the file already occupies
/// count as free.
std::string space_text(int descriptor, std::uint64_t needed_bytes) {
  std::string text;
  if (needed_bytes > 0) text = concat("needed: ", needed_bytes, " bytes");
  struct statvfs disk {};
  struct stat file {};
  if (::fstatvfs(descriptor, &disk) == 0 && ::fstat(descriptor, &file) == 0) {
    constexpr std::uint64_t block_bytes = 512;  // the unit of st_blocks on Linux
    const std::uint64_t taken = block_bytes * static_cast<std::uint64_t>(file.st_blocks);
    text += concat(text.empty() ? "" : ", ", "free: ", disk.f_bavail * disk.f_frsize + taken, " bytes");
  }
  return text.empty() ? text : concat(" (", text, ")");
}

/// " (needed: 100 bytes, limit of this process: 10 bytes)"
std::string limit_text(std::uint64_t needed_bytes) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return {};
  return concat(" (", needed_bytes > 0 ? concat("needed: ", needed_bytes, " bytes, ") : std::string(),
                "limit of this process: ", limit.rlim_cur, " bytes)");
}

}  // namespace

Error write_failure(const std::string& name, const std::string& act, int error, int descriptor,
                    std::uint64_t needed_bytes) {
  std::string fact = concat(name, ": cannot ", act, ": ", std::system_category().message(error));
  if (error == ENOSPC || error == EDQUOT) fact += space_text(descriptor, needed_bytes);
  if (error == EFBIG) fact += limit_text(needed_bytes);
  return Error(error_code_of(error), fact);
}

}  // namespace rhoray

#include "preprocess/process/nameless_file.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "formats/base/error.h"

namespace rhoray::preprocess {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& folder, std::uint64_t bytes, int error) {
  throw Error(ErrorCode::resource, concat(folder.string(), ": cannot make a scratch file of ", bytes,
                                          " bytes here: ", std::strerror(error)));
}

/// Where the file system does not support files without names: opens a file and removes its name at
/// once.
int open_and_unlink(const std::filesystem::path& folder) {
  std::string name = (folder / ".rhoray-scratch-XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor >= 0) ::unlink(name.c_str());
  return descriptor;
}

/// Returns 0, or the error when the space cannot be reserved.
int reserve(int descriptor, std::uint64_t bytes) {
  if (bytes == 0) return 0;
  const auto size = static_cast<off_t>(bytes);
  int error = 0;
  do {
    error = ::fallocate(descriptor, 0, 0, size) == 0 ? 0 : errno;
  } while (error == EINTR);
  // Some file systems cannot reserve space. There the C library writes a byte into every block.
  return error == EOPNOTSUPP || error == ENOSYS ? ::posix_fallocate(descriptor, 0, size) : error;
}

}  // namespace

int open_nameless_file(const std::filesystem::path& folder, std::uint64_t bytes) {
  int descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor < 0 && (errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL))
    descriptor = open_and_unlink(folder);
  if (descriptor < 0) refuse(folder, bytes, errno);
  if (const int error = reserve(descriptor, bytes); error != 0) {
    ::close(descriptor);
    refuse(folder, bytes, error);
  }
  return descriptor;
}

}  // namespace rhoray::preprocess

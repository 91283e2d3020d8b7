// A library for LD_PRELOAD that records the changes that a program, and the workers that it starts,
// make in a folder.
//
//   RHORAY_RECORD_FOLDER    the folder, as an absolute path without symbolic links
//
//   RHORAY_RECORD_FILE      the record (recorded_calls.h), an existing file elsewhere; calls are
//                           appended to it
//
//   RHORAY_RECORD_MISSING   words for what the folder's file system lacks: anonymous (files),
//                           flags (of a rename)
//
// A call is recorded when it has succeeded. Calls that the C library makes itself (stdio) are not
// seen here. Therefore a reader of the record compares its outcome with the folder.

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <string_view>

#include "tests/faults/recorded_calls.h"

namespace {

using rhoray::tests::CallHeader;
using rhoray::tests::CallKind;

struct Plan {
  std::string_view folder;
  const char* record = nullptr;
  struct stat folder_status {};
  bool lacks_anonymous = false, lacks_rename_flags = false;

  Plan() {
    const char *name = std::getenv("RHORAY_RECORD_FOLDER"), *file = std::getenv("RHORAY_RECORD_FILE"),
               *missing = std::getenv("RHORAY_RECORD_MISSING");
    if (name == nullptr || file == nullptr || missing == nullptr || ::stat(name, &folder_status) != 0) return;
    folder = name;
    record = file;
    lacks_anonymous = std::strstr(missing, "anonymous") != nullptr;
    lacks_rename_flags = std::strstr(missing, "flags") != nullptr;
  }
};

const Plan& plan() {
  static const Plan plan;
  return plan;
}

/// Leaves errno as the recorded call set it.
class KeptErrno {
 public:
  KeptErrno() = default;
  KeptErrno(const KeptErrno&) = delete;
  KeptErrno& operator=(const KeptErrno&) = delete;
  ~KeptErrno() { errno = before_; }

 private:
  int before_ = errno;
};

/// The number of bytes in the record so far.
std::uint64_t record_bytes() {
  const KeptErrno kept;
  struct stat status {};
  return plan().record != nullptr && ::stat(plan().record, &status) == 0 ? static_cast<std::uint64_t>(status.st_size)
                                                                         : 0;
}

void record(CallHeader header, std::string_view name = {}, std::string_view second_name = {},
            const void* bytes = nullptr) {
  const KeptErrno kept;
  header.name_bytes = static_cast<std::uint32_t>(name.size());
  header.second_name_bytes = static_cast<std::uint32_t>(second_name.size());
  const iovec parts[] = {{&header, sizeof header},
                         {const_cast<char*>(name.data()), name.size()},
                         {const_cast<char*>(second_name.data()), second_name.size()},
                         {const_cast<void*>(bytes), header.byte_count}};
  const auto count = static_cast<long>(sizeof header + name.size() + second_name.size() + header.byte_count);
  const long file = ::syscall(SYS_openat, AT_FDCWD, plan().record, O_WRONLY | O_APPEND | O_CLOEXEC);
  // In one call, so that records of other threads do not interleave.
  if (file < 0 || ::syscall(SYS_writev, file, parts, std::size(parts)) != count) std::abort();
  ::syscall(SYS_close, file);
}

/// The inode number of an open file that was created in the folder, or of the folder itself; 0 for
/// any other.
std::uint64_t file_in_folder(int descriptor) {
  const KeptErrno kept;
  if (plan().record == nullptr || descriptor < 0) return 0;
  char link[32], path[PATH_MAX];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t count = ::readlink(link, path, sizeof path);
  struct stat status {};
  if (count <= 0 || ::fstat(descriptor, &status) != 0) return 0;
  const std::string_view found(path, static_cast<std::size_t>(count)), folder = plan().folder;
  const bool is_inside = found.starts_with(folder) && (found.size() == folder.size() || found[folder.size()] == '/');
  return is_inside ? status.st_ino : 0;
}

/// The name in the folder to which a path refers; empty when it refers to something elsewhere.
std::string_view name_in_folder(int from, std::string_view path) {
  const KeptErrno kept;
  if (plan().record == nullptr || path.size() >= PATH_MAX) return {};
  const std::size_t name_begin = path.rfind('/') + 1;
  char parent[PATH_MAX] = ".";
  path.copy(parent, name_begin);
  struct stat status {};
  const struct stat& folder = plan().folder_status;
  if (::fstatat(from, parent, &status, 0) != 0) return {};
  return status.st_ino == folder.st_ino && status.st_dev == folder.st_dev ? path.substr(name_begin) : "";
}

/// The inode number of a named file in the folder; 0 when there is none.
std::uint64_t file_of_name(int from, const char* path) {
  const KeptErrno kept;
  struct stat status {};
  return ::fstatat(from, path, &status, AT_SYMLINK_NOFOLLOW) == 0 ? status.st_ino : 0;
}

int open_recorded(int from, const char* path, int flags, mode_t mode) {
  const bool is_anonymous = (flags & O_TMPFILE) == O_TMPFILE;
  const std::string_view name = is_anonymous ? "" : name_in_folder(from, path);
  const bool is_new = is_anonymous || ((flags & O_CREAT) != 0 && !name.empty() && file_of_name(from, path) == 0);
  const auto descriptor = static_cast<int>(::syscall(SYS_openat, from, path, flags, mode));
  const std::uint64_t file = is_new || (flags & O_TRUNC) != 0 ? file_in_folder(descriptor) : 0;
  if (file == 0) return descriptor;
  if (is_anonymous && plan().lacks_anonymous) {
    ::syscall(SYS_close, descriptor);
    errno = EOPNOTSUPP;
    return -1;
  }
  record({.kind = is_new ? CallKind::create : CallKind::resize, .file = file}, name);
  return descriptor;
}

/// Records bytes that were written; returns `count`.
ssize_t written(int descriptor, const void* bytes, long count, off_t at) {
  const std::uint64_t file = count > 0 ? file_in_folder(descriptor) : 0;
  const auto first = static_cast<std::uint64_t>(at), size = static_cast<std::uint64_t>(count);
  if (file != 0) record({.kind = CallKind::write, .file = file, .at = first, .byte_count = size}, {}, {}, bytes);
  return count;
}

/// The file position, where the next write without an explicit offset goes.
off_t position(int descriptor) {
  const KeptErrno kept;
  return ::lseek(descriptor, 0, SEEK_CUR);
}

int resized(int descriptor, long result) {
  const std::uint64_t file = result == 0 ? file_in_folder(descriptor) : 0;
  struct stat status {};
  if (file != 0 && ::fstat(descriptor, &status) == 0)
    record({.kind = CallKind::resize, .file = file, .at = static_cast<std::uint64_t>(status.st_size)});
  return static_cast<int>(result);
}

int flush(int descriptor, long call) {
  const std::uint64_t before = record_bytes();
  const auto result = static_cast<int>(::syscall(call, descriptor));
  const std::uint64_t file = result == 0 ? file_in_folder(descriptor) : 0;
  const bool is_folder = file == plan().folder_status.st_ino;
  if (file != 0)
    record({.kind = is_folder ? CallKind::flush_folder : CallKind::flush_file, .file = file, .at = before});
  return result;
}

int rename_recorded(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
  const std::string_view old_name = name_in_folder(from_folder, from), new_name = name_in_folder(to_folder, to);
  if (flags != 0 && plan().lacks_rename_flags && !new_name.empty()) {
    errno = EINVAL;
    return -1;
  }
  const auto result = static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
  if (result == 0 && !(old_name.empty() && new_name.empty()))
    record({.kind = flags == RENAME_EXCHANGE ? CallKind::exchange : CallKind::rename}, old_name, new_name);
  return result;
}

int link_recorded(int from_folder, const char* from, int to_folder, const char* to, int flags) {
  const auto result = static_cast<int>(::syscall(SYS_linkat, from_folder, from, to_folder, to, flags));
  const std::string_view name = name_in_folder(to_folder, to);
  if (result == 0 && !name.empty()) record({.kind = CallKind::link, .file = file_of_name(to_folder, to)}, name);
  return result;
}

int unlink_recorded(int folder, const char* path, int flags) {
  const std::string_view name = name_in_folder(folder, path);
  const auto result = static_cast<int>(::syscall(SYS_unlinkat, folder, path, flags));
  if (result == 0 && !name.empty()) record({.kind = CallKind::unlink}, name);
  return result;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  return open_recorded(AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  return open_recorded(folder, path, flags, mode);
}

int open64(const char* path, int flags, ...) __attribute__((alias("open")));
int openat64(int folder, const char* path, int flags, ...) __attribute__((alias("openat")));

ssize_t write(int file, const void* bytes, size_t count) {
  const long done = ::syscall(SYS_write, file, bytes, count);
  return written(file, bytes, done, position(file) - done);
}

ssize_t writev(int file, const struct iovec* parts, int count) {
  const long done = ::syscall(SYS_writev, file, parts, count);
  off_t at = position(file) - done;
  for (long left = done; left > 0; ++parts) {
    const long part = std::min(left, static_cast<long>(parts->iov_len));
    written(file, parts->iov_base, part, at);
    at += part;
    left -= part;
  }
  return done;
}

ssize_t pwrite(int file, const void* bytes, size_t count, off_t at) {
  return written(file, bytes, ::syscall(SYS_pwrite64, file, bytes, count, at), at);
}

ssize_t pwrite64(int file, const void* bytes, size_t count, off_t at) {
  return pwrite(file, bytes, count, at);
}

int fallocate(int file, int mode, off_t first, off_t count) {
  return resized(file, ::syscall(SYS_fallocate, file, mode, first, count));
}

int ftruncate(int file, off_t size) noexcept {
  return resized(file, ::syscall(SYS_ftruncate, file, size));
}

int fsync(int file) {
  return flush(file, SYS_fsync);
}

int fdatasync(int file) {
  return flush(file, SYS_fdatasync);
}

int rename(const char* from, const char* to) noexcept {
  return rename_recorded(AT_FDCWD, from, AT_FDCWD, to, 0);
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
  return rename_recorded(from_folder, from, to_folder, to, 0);
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
  return rename_recorded(from_folder, from, to_folder, to, flags);
}

int link(const char* from, const char* to) noexcept {
  return link_recorded(AT_FDCWD, from, AT_FDCWD, to, 0);
}

int linkat(int from_folder, const char* from, int to_folder, const char* to, int flags) noexcept {
  return link_recorded(from_folder, from, to_folder, to, flags);
}

int unlink(const char* path) noexcept {
  return unlink_recorded(AT_FDCWD, path, 0);
}

int unlinkat(int folder, const char* path, int flags) noexcept {
  return unlink_recorded(folder, path, flags);
}

void* mmap(void* address, size_t bytes, int protection, int flags, int descriptor, off_t at) noexcept {
  const long result = ::syscall(SYS_mmap, address, bytes, protection, flags, descriptor, at);
  const bool writes = (protection & PROT_WRITE) != 0 && (flags & MAP_SHARED) != 0 && (flags & MAP_ANONYMOUS) == 0;
  const std::uint64_t file = writes && result != -1 ? file_in_folder(descriptor) : 0;
  if (file != 0) record({.kind = CallKind::map, .file = file});
  return reinterpret_cast<void*>(result);  // -1 is MAP_FAILED
}

void* mmap64(void* address, size_t bytes, int protection, int flags, int descriptor, off_t at) noexcept {
  return mmap(address, bytes, protection, flags, descriptor, at);
}

}  // extern "C"

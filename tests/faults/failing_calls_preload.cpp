// A library for LD_PRELOAD that makes one system call fail, in a program and in the workers that it
// starts.
//
//   RHORAY_FAIL_CALL    write, fsync, rename, close, mmap or fork
//
//   RHORAY_FAIL_AT      number of the failing call of that kind, from 1 on, counted over all
//                       processes; 0: no call fails, but calls are counted
//
//   RHORAY_FAIL_ERRNO   the value of errno then (a number)
//
//   RHORAY_FAIL_COUNT   a file of 8 bytes, the counter that the processes share
//
// Counted are write and close calls on regular files, all calls of fsync, rename and fork, and
// mappings of files (mmap), if they come from programs and shared libraries. Calls that the C
// library makes itself (stdio, malloc, the loader) are not seen here.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace {

struct Plan {
  const char* call = nullptr;
  std::uint64_t at = 0;
  int error = 0;
  std::atomic<std::uint64_t>* count = nullptr;

  Plan() {
    const char *name = std::getenv("RHORAY_FAIL_CALL"), *position = std::getenv("RHORAY_FAIL_AT"),
               *number = std::getenv("RHORAY_FAIL_ERRNO"), *file = std::getenv("RHORAY_FAIL_COUNT");
    if (name == nullptr || position == nullptr || number == nullptr || file == nullptr) return;
    const long descriptor = ::syscall(SYS_openat, AT_FDCWD, file, O_RDWR | O_CLOEXEC);
    if (descriptor < 0) return;
    constexpr off_t from = 0;  // an int would leave half of the argument undefined
    const long address =
        ::syscall(SYS_mmap, nullptr, sizeof *count, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, from);
    ::syscall(SYS_close, descriptor);
    if (address == -1) return;
    call = name;
    at = std::strtoull(position, nullptr, 10);
    error = std::atoi(number);
    count = reinterpret_cast<std::atomic<std::uint64_t>*>(address);
  }
};

/// Returns true for the call that is to fail, and sets errno.
bool must_fail(const char* call) {
  static const Plan plan;
  if (plan.count == nullptr || std::strcmp(plan.call, call) != 0) return false;
  if (plan.count->fetch_add(1) + 1 != plan.at) return false;
  errno = plan.error;
  return true;
}

bool is_regular_file(int file) {
  struct stat status {};
  return ::syscall(SYS_newfstatat, file, "", &status, AT_EMPTY_PATH) == 0 && S_ISREG(status.st_mode);
}

bool file_must_fail(const char* call, int file) {
  const int before = errno;
  if (!is_regular_file(file)) {
    errno = before;
    return false;
  }
  errno = before;
  return must_fail(call);
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

ssize_t write(int file, const void* bytes, size_t count) {
  return file_must_fail("write", file) ? -1 : static_cast<ssize_t>(::syscall(SYS_write, file, bytes, count));
}

ssize_t writev(int file, const struct iovec* parts, int count) {
  return file_must_fail("write", file) ? -1 : static_cast<ssize_t>(::syscall(SYS_writev, file, parts, count));
}

ssize_t pwrite(int file, const void* bytes, size_t count, off_t at) {
  return file_must_fail("write", file) ? -1 : static_cast<ssize_t>(::syscall(SYS_pwrite64, file, bytes, count, at));
}

ssize_t pwrite64(int file, const void* bytes, size_t count, off_t at) {
  return pwrite(file, bytes, count, at);
}

int fallocate(int file, int mode, off_t first, off_t count) {
  return file_must_fail("write", file) ? -1 : static_cast<int>(::syscall(SYS_fallocate, file, mode, first, count));
}

int ftruncate(int file, off_t size) noexcept {
  return file_must_fail("write", file) ? -1 : static_cast<int>(::syscall(SYS_ftruncate, file, size));
}

int fsync(int file) {
  return must_fail("fsync") ? -1 : static_cast<int>(::syscall(SYS_fsync, file));
}

/// Closes the file even where it reports an error, as Linux does.
int close(int file) {
  const bool fails = file_must_fail("close", file);
  const int error = errno;
  const int result = static_cast<int>(::syscall(SYS_close, file));
  if (!fails) return result;
  errno = error;
  return -1;
}

int rename(const char* from, const char* to) noexcept {
  return must_fail("rename") ? -1 : static_cast<int>(::syscall(SYS_rename, from, to));
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
  return must_fail("rename") ? -1 : static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, 0));
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
  return must_fail("rename") ? -1 : static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
}

/// Naming an anonymous file counts as a rename.
int linkat(int from_folder, const char* from, int to_folder, const char* to, int flags) noexcept {
  return must_fail("rename") ? -1 : static_cast<int>(::syscall(SYS_linkat, from_folder, from, to_folder, to, flags));
}

void* mmap(void* address, size_t bytes, int protection, int flags, int file, off_t at) noexcept {
  if ((flags & MAP_ANONYMOUS) == 0 && must_fail("mmap")) return MAP_FAILED;
  const long result = ::syscall(SYS_mmap, address, bytes, protection, flags, file, at);
  return reinterpret_cast<void*>(result);  // -1 is MAP_FAILED
}

void* mmap64(void* address, size_t bytes, int protection, int flags, int file, off_t at) noexcept {
  return mmap(address, bytes, protection, flags, file, at);
}

pid_t fork() noexcept {
  if (must_fail("fork")) return -1;
  static auto* const real = next<pid_t()>("fork");  // with its handlers
  return real();
}

}  // extern "C"

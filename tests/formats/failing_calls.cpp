#include "tests/formats/failing_calls.h"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>

namespace {

std::atomic<int> calls_left{0};  // 0: none fails
std::atomic<int> error_of_call{0};
std::atomic<const char*> failed_call{nullptr};

/// True for the call that must fail; sets errno.
bool must_fail(const char* name) {
  if (calls_left.load() <= 0 || calls_left.fetch_sub(1) != 1) return false;
  failed_call = name;
  errno = error_of_call;
  return true;
}

}  // namespace

extern "C" {

ssize_t pwrite(int file, const void* bytes, size_t count, off_t at) {
  return must_fail("pwrite") ? -1 : static_cast<ssize_t>(::syscall(SYS_pwrite64, file, bytes, count, at));
}

int fallocate(int file, int mode, off_t first, off_t count) {
  return must_fail("fallocate") ? -1 : static_cast<int>(::syscall(SYS_fallocate, file, mode, first, count));
}

int ftruncate(int file, off_t size) noexcept {
  return must_fail("ftruncate") ? -1 : static_cast<int>(::syscall(SYS_ftruncate, file, size));
}

int fsync(int file) {
  return must_fail("fsync") ? -1 : static_cast<int>(::syscall(SYS_fsync, file));
}

/// Closes the file even when it reports an error, like Linux.
int close(int file) {
  const bool fails = must_fail("close");
  const int error = errno;
  const int result = static_cast<int>(::syscall(SYS_close, file));
  if (!fails) return result;
  errno = error;
  return -1;
}

int fcntl(int file, int command, ...) {
  va_list arguments;
  va_start(arguments, command);
  const long argument = va_arg(arguments, long);
  va_end(arguments);
  return must_fail("fcntl") ? -1 : static_cast<int>(::syscall(SYS_fcntl, file, command, argument));
}

int linkat(int from_folder, const char* from, int to_folder, const char* to, int flags) noexcept {
  return must_fail("linkat") ? -1 : static_cast<int>(::syscall(SYS_linkat, from_folder, from, to_folder, to, flags));
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
  return must_fail("renameat") ? -1 : static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, 0));
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
  return must_fail("renameat2") ? -1
                                : static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
}

int fchmod(int file, mode_t mode) noexcept {
  return must_fail("fchmod") ? -1 : static_cast<int>(::syscall(SYS_fchmod, file, mode));
}

int fchown(int file, uid_t owner, gid_t group) noexcept {
  return must_fail("fchown") ? -1 : static_cast<int>(::syscall(SYS_fchown, file, owner, group));
}

}  // extern "C"

namespace rhoray::tests {

FailingCall::FailingCall(int position, int error) {
  error_of_call = error;
  failed_call = nullptr;
  calls_left = position;
}

FailingCall::~FailingCall() {
  calls_left = 0;
}

std::string FailingCall::failed() const {
  const char* const name = failed_call;
  return name == nullptr ? "" : name;
}

}  // namespace rhoray::tests

#pragma once

#include <string>
#include <vector>

namespace rhoray::tests {

/// While it lives, one system call for writing in this process fails: the N-th (from 1) of pwrite,
/// fallocate, ftruncate, fsync, close, fcntl, linkat, renameat, renameat2, fchmod and fchown,
/// counted together. failing_calls.cpp replaces these functions of the C library in this program.
class FailingCall {
 public:
  FailingCall(int position, int error);
  FailingCall(const FailingCall&) = delete;
  FailingCall& operator=(const FailingCall&) = delete;
  ~FailingCall();

  /// The name of the call that failed; empty if there were fewer calls.
  std::string failed() const;
};

}  // namespace rhoray::tests

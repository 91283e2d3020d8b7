#pragma once

#include <string>
#include <vector>

namespace rhoray::tests {

/// While it lives, one call of the system that this process makes for writing fails: the N-th (from
/// 1) of pwrite, fallocate, ftruncate, fsync, close, fcntl, linkat, renameat, renameat2, fchmod and
/// fchown, counted together. The functions stand in failing_calls.cpp, which takes the place of the
/// C library's in this program.
class FailingCall {
 public:
  FailingCall(int position, int error);
  FailingCall(const FailingCall&) = delete;
  FailingCall& operator=(const FailingCall&) = delete;
  ~FailingCall();

  /// The name of the call that failed; empty when there were fewer calls.
  std::string failed() const;
};

}  // namespace rhoray::tests

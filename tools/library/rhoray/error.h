#pragma once

#include <stdexcept>
#include <string>

#include "rhoray/export.h"

namespace rhoray::RHORAY_ABI {

/// Why a call failed. The numbers are the exit codes of the program `rhoray`.
enum class ErrorCode {
  internal = 1,      ///< a defect of this library; the RenderContext refuses further calls
  usage = 2,         ///< the call makes no sense: a number out of range, an unknown field
  unreadable = 3,    ///< a file is missing or cannot be read
  invalid = 4,       ///< a file was read and is wrong or damaged
  resource = 5,      ///< no memory, disk space or threads
  unsupported = 7,   ///< a file needs a newer version, a kind of data cannot answer a query,
                     ///< or this processor lacks an instruction set
  interrupted = 130  ///< the caller's stop request ended the call
};

/// The only exception that this library throws, besides std::bad_alloc and what callbacks throw.
class RHORAY_API Error : public std::runtime_error {
 public:
  /// @param fact  one line: where, what was found, what was expected
  /// @param hint  one line: what to do; may be empty
  Error(ErrorCode code, const std::string& fact, std::string hint = {});
  Error(const Error&);
  Error& operator=(const Error&);
  ~Error() override;

  ErrorCode code() const noexcept { return code_; }
  const std::string& hint() const noexcept { return hint_; }

 private:
  ErrorCode code_;
  std::string hint_;
};

}  // namespace rhoray::RHORAY_ABI

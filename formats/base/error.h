#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "formats/base/text.h"

namespace rhoray {

/// Why an operation failed; the number is the exit code of the program.
enum class ErrorCode {
  internal = 1,       ///< a defect in this project
  usage = 2,          ///< the request makes no sense (unknown field, isovalue that is not a number)
  unreadable = 3,     ///< an input is missing or cannot be read
  invalid = 4,        ///< an input was read and is wrong or damaged
  resource = 5,       ///< out of memory (cap), disk space or time
  outside_limit = 6,  ///< a comparison exceeded its limit
  unsupported = 7,    ///< needs a newer version or a missing feature
  interrupted = 130,
};

/// A failed operation. `what()` is one line: file, location, found, expected. `hint`, when not
/// empty, says in one line what to do. Libraries throw it and never print; `main` prints it and
/// returns the code.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& fact, std::string hint = {})
      : std::runtime_error(fact), code_(code), hint_(std::move(hint)) {}

  ErrorCode code() const { return code_; }
  const std::string& hint() const { return hint_; }

 private:
  ErrorCode code_;
  std::string hint_;
};

}  // namespace rhoray

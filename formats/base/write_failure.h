#pragma once

#include <cstdint>
#include <string>

#include "formats/base/error.h"

namespace rhoray {

/// The error for a call of the system that failed while a file was being written.
///
/// ErrorCode::usage when the name itself is wrong (no such folder, a folder of that name); else
/// ErrorCode::resource, also for a folder that may not be written to. A full disk adds the bytes
/// needed and free, a limit of the process (RLIMIT_FSIZE) the limit.
/// @param name          the file's name, as the user gave it
/// @param act           what was tried: "write 10 bytes at byte 0"
/// @param error         errno
/// @param descriptor    the file, or -1 where there is none yet
/// @param needed_bytes  how large the file must become at least; 0 = not known
Error write_failure(const std::string& name, const std::string& act, int error, int descriptor = -1,
                    std::uint64_t needed_bytes = 0);

}  // namespace rhoray

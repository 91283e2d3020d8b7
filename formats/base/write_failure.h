#pragma once

#include <cstdint>
#include <string>

#include "formats/base/error.h"

namespace rhoray {

/// The error for a system call that failed while writing a file.
///
/// ErrorCode::usage when the name itself is wrong (no such folder, a folder of that name).
/// Otherwise ErrorCode::resource, also for a folder without write permission. For a full disk, the
/// message adds the bytes needed and free; for a process limit (RLIMIT_FSIZE), the limit.
/// @param name          the file's name, as the user gave it
/// @param act           attempted operation: "write 10 bytes at byte 0"
/// @param error         errno
/// @param descriptor    the file, or -1 where there is none yet
/// @param needed_bytes  minimum size that the file must reach; 0 = not known
Error write_failure(const std::string& name, const std::string& act, int error, int descriptor = -1,
                    std::uint64_t needed_bytes = 0);

}  // namespace rhoray

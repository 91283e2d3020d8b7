#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "formats/base/error.h"

namespace rhoray::formats {

/// Refuses a packed file. All readers use this function. Example: `volume.rho, byte 4096: found 7;
/// expected at least 8`.
/// The text may come from a hostile file. So control characters are shown as \x0a, and long texts
/// are cut.
/// @param place  location inside the file: "byte 4096", "array 'points'", "header"
[[noreturn]] void refuse(std::string_view file, std::string_view place, std::string_view found,
                         std::string_view expected, ErrorCode error_code = ErrorCode::invalid);

}  // namespace rhoray::formats

#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "formats/base/error.h"

namespace rhoray::formats {

/// The one way a reader of packed files refuses: `volume.rho, byte 4096: found 7; expected at least
/// 8`.
/// Control characters in what is said are shown as \x0a, and long texts are cut: they may come from
/// a hostile file.
/// @param place  where in the file, in its own terms: "byte 4096", "array 'points'", "header"
[[noreturn]] void refuse(std::string_view file, std::string_view place, std::string_view found,
                         std::string_view expected, ErrorCode error_code = ErrorCode::invalid);

}  // namespace rhoray::formats

#pragma once

#include <string>
#include <string_view>

namespace rhoray {

/// Text from a file, safe for a message or a terminal: control characters become \x1b and so on. So
/// it is one line.
std::string printable(std::string_view text);

}  // namespace rhoray

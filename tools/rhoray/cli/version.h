#pragma once

#include <string>

namespace rhoray::tools {

std::string version();   ///< "0.1.0"
std::string commit();    ///< of the working tree at build time, "+" behind it where it had changes; may be "unknown"
std::string compiler();  ///< "gcc 12.2.0, Release"
std::string version_line();  ///< all of these, for --version

}  // namespace rhoray::tools

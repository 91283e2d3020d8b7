#pragma once

#include <string>

namespace rhoray::formats {

/// Source of a packed file, and the command that made it.
struct Provenance {
  std::string source_name;  ///< file name without folders
  /// XXH3-128 of the source's bytes, hexadecimal; empty: not computed
  std::string source_checksum;
  std::string command;  ///< the command line that made the file
};

}  // namespace rhoray::formats

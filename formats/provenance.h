#pragma once

#include <string>

namespace rhoray::formats {

/// Where a packed file came from and what packing did to it.
struct Provenance {
  std::string source_name;  ///< file name without folders
  /// XXH3-128 of the source's bytes, hexadecimal; empty when not taken
  std::string source_checksum;
  std::string command;  ///< the command line that made the file
};

}  // namespace rhoray::formats

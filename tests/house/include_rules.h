#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace rhoray::tests {

/// An #include that the layers do not allow, or that names no file of the tree.
struct Breach {
  std::string file;  ///< from the root
  int line = 0;
  std::string include;  ///< as written, with its brackets or quotes
  std::string rule;     ///< "rooms", "public headers", "layers", "third-party" or "names"
};

/// Reads the includes of every source file below `root` and checks five rules.
///
/// Rooms: a room includes rooms below it, never above or beside it. Public headers: a room sees
/// only the headers that stand directly in another room, and formats/base; tests see all. Layers:
/// inside a room each folder includes only the folders that it may see. Third-party: only named
/// folders include the headers of a library; an unknown header is refused. Names: an include in
/// quotes is written from the root and names a file.
std::vector<Breach> breaches(const std::filesystem::path& root);

/// Units that include each other in a circle. A unit is a header together with its source file.
/// Each circle is one line: the units in order of name, separated by spaces.
std::vector<std::string> circles(const std::filesystem::path& root);

}  // namespace rhoray::tests

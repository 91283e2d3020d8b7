#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace rhoray::tests {

/// An #include that the layers do not allow, or that does not name a file of the tree.
struct Breach {
  std::string file;  ///< path from the root
  int line = 0;
  std::string include;  ///< as written, with its brackets or quotes
  std::string rule;     ///< "rooms", "public headers", "layers", "third-party" or "names"
};

/// Reads the includes of every source file below `root` and checks five rules.
///
/// Rooms (top-level folders): a room includes rooms below it, never above or beside it. Public
/// headers: a room sees only headers directly in another room's folder, and formats/base; tests see
/// all. Layers: inside a room, each folder includes only the folders that it may see. Third-party:
/// only the named folders include the headers of a library; an unknown header is refused. Names: an
/// include in quotes is written from the root and names an existing file.
std::vector<Breach> breaches(const std::filesystem::path& root);

/// Finds units that include each other in a cycle. A unit is a header together with its source
/// file. Each cycle is one line: the units in order of name, separated by spaces.
std::vector<std::string> circles(const std::filesystem::path& root);

}  // namespace rhoray::tests

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace rhoray::tests {

/// An #include that the house does not allow, or that names no file of it.
struct Breach {
  std::string file;  ///< from the root
  int line = 0;
  std::string include;  ///< as written, with its brackets or quotes
  std::string rule;     ///< "floors", "porches", "rooms of render", "guests", "names"
};

/// Reads the includes of every source file under the rooms of `root` and checks floors, porches and guests.
///
/// Floors: includes go down, never up or sideways. Porches: what stands deeper in a room than its own folder is
/// invisible to other rooms (but formats/base, and for tests). Rooms of render: the same, one scale down. Guests:
/// third-party headers are received in named rooms; a header that is neither ours, nor a guest, nor the system's is
/// refused. Names: includes in quotes are written from the root and name a file there.
std::vector<Breach> breaches(const std::filesystem::path& root);

}  // namespace rhoray::tests

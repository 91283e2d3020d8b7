#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace rhoray {

/// The path of a worker program or of the module for pictures. In a build folder these files are
/// beside the program; `cmake --install` puts them into lib/rhoray of the same prefix. The prefix
/// may be moved.
class ComponentFile {
 public:
  /// @param name    "rhoray-import-worker"
  /// @param folder  the only folder that is searched, unless it is empty
  explicit ComponentFile(std::string_view name, const std::filesystem::path& folder = {});

  const std::filesystem::path& path() const { return path_; }  ///< empty if the file does not exist
  bool exists() const { return !path_.empty(); }
  /// "the program rhoray-import-worker, which is not in /opt/bin", for messages.
  std::string missing_text() const;
  std::string hint() const;  ///< which package contains the file, and how to build it

 private:
  std::string name_;
  std::filesystem::path path_;
  std::string searched_;  ///< folders, for messages
};

}  // namespace rhoray

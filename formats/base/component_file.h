#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace rhoray {

/// Where a worker program or a module of ours lies: beside the program that runs, as in a build
/// folder, or in the prefix in which that program is installed, wherever it was moved.
class ComponentFile {
 public:
  /// @param name    "rhoray-import-worker"
  /// @param folder  looked into instead; empty: none
  explicit ComponentFile(std::string_view name, const std::filesystem::path& folder = {});

  const std::filesystem::path& path() const { return path_; }
  bool exists() const { return exists_; }
  /// What to tell a user who misses it: "the program rhoray-import-worker, which is not in /opt/bin".
  std::string missing_text() const;
  /// The package that has it, and how to build it.
  std::string hint() const;

 private:
  std::string name_;
  std::filesystem::path path_;
  std::string folders_;  ///< that were looked into
  bool exists_ = false;
};

}  // namespace rhoray

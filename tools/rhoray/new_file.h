#pragma once

#include <filesystem>
#include <string_view>

namespace rhoray::tools {

/// A file that gets its name only when it is whole: until `commit` it has none and vanishes with the program, or, on a
/// file system without nameless files, a passing one that starts with a dot.
class NewFile {
 public:
  /// Refuses when no file can be made in the folder (Trouble::resource).
  explicit NewFile(std::filesystem::path path);
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile();

  /// A name under which a library can open the nameless file again for writing.
  std::filesystem::path open_name() const;

  void write(std::string_view bytes);

  /// Flushes, and names the file; replaces one of that name only when told to (Trouble::usage otherwise).
  void commit(bool replace_existing);

 private:
  std::filesystem::path passing_name() const;
  void link_as(const std::filesystem::path& name);

  std::filesystem::path path_;
  std::filesystem::path passing_;  ///< empty while there is none
  int descriptor_ = -1;
};

/// The whole act for a text.
void write_new_file(const std::filesystem::path& path, std::string_view text, bool replace_existing);

}  // namespace rhoray::tools

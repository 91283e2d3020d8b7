#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/source_file.h"

namespace rhoray::preprocess {

/// A foreign file, mapped for reading. Refuses a file that is missing, a folder, or an empty file.
class ForeignFile {
 public:
  explicit ForeignFile(const std::filesystem::path& path);
  /// The content of a file that was unpacked into memory. Refuses an empty one.
  ForeignFile(const std::filesystem::path& path, std::shared_ptr<const void> start, std::size_t size);

  const std::filesystem::path& path() const { return path_; }
  std::string_view text() const { return {static_cast<const char*>(start_.get()), size_}; }
  /// keeps text and bytes alive
  const std::shared_ptr<const void>& mapping() const { return start_; }
  std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(start_.get()), size_}; }

 private:
  std::filesystem::path path_;
  std::shared_ptr<const void> start_;
  std::size_t size_ = 0;
};

/// Notes that this file is about to be read, or that it was looked for. ForeignFile does so itself;
/// whoever lets a library open a file calls it first. Thread-safe.
void note_source(const std::filesystem::path& path);

/// Whether there is such a file or folder; notes that it was looked for.
bool is_there(const std::filesystem::path& path);

/// All files noted so far by this process, each once, as it stood when it was first noted.
std::vector<SourceFile> noted_sources();

/// Throws a message such as `bone.mhd, key DimSize: found 0; expected at least 1`.
[[noreturn]] void refuse_input(const std::filesystem::path& path, std::string_view place, std::string_view found,
                               std::string_view expected, ErrorCode error_code = ErrorCode::invalid);

/// The extension in lower case, with its dot. ".nii.gz" and other extensions before ".gz" count as
/// one with it.
std::string extension_of(const std::filesystem::path& path);

/// The file's name without folder and extension: the name of a field that has no name of its own.
std::string stem_of(const std::filesystem::path& path);

}  // namespace rhoray::preprocess

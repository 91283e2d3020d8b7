#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace rhoray::preprocess {

/// A file or a folder as it stood before it was read. It has changed since if any member differs.
struct SourceFile {
  std::filesystem::path path{};  ///< absolute, without symbolic links
  bool exists = false;           ///< false: it was looked for
  std::uint64_t device = 0, inode = 0, bytes = 0;
  std::int64_t changed_ns = 0;  ///< of its content or its properties (ctime), since 1970

  bool operator==(const SourceFile&) const = default;
};

/// Describes a file as it stands now.
SourceFile source_file(const std::filesystem::path& path);

/// Whether a file is one of those that were read.
bool was_read(const std::filesystem::path& path, const std::vector<SourceFile>& sources);

/// Refuses an output that is one of the files that were read (ErrorCode::usage).
void require_not_read(const std::filesystem::path& output, const std::vector<SourceFile>& sources);

}  // namespace rhoray::preprocess

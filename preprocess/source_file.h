#pragma once

#include <cstdint>
#include <filesystem>

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

}  // namespace rhoray::preprocess

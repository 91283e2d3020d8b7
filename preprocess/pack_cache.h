#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/packed_file.h"
#include "preprocess/pack.h"

namespace rhoray::preprocess {

/// Packed copies of foreign files in a folder of the user's own. A copy is used while no file that
/// packing read has changed (SourceFile). Several processes may use the folder at once: entries
/// appear in one step, and a removed file stays readable for those that have opened it.
class PackCache {
 public:
  /// The content of a packed copy follows from its key and its sources.
  struct Key {
    std::filesystem::path input;
    std::string options;  ///< all that differ from their defaults
    std::string program;  ///< version of the program, which may pack in another way
  };

  struct Copy {
    formats::PackedFile file;           ///< its name is that of the input
    std::filesystem::path path{};       ///< of the packed copy; empty: it was not kept
    std::string not_kept{};             ///< the reason
    std::vector<std::string> notes{};   ///< of reading and of packing
    std::vector<SourceFile> sources{};  ///< as PackReport::sources
  };

  struct Entry {
    std::filesystem::path input;
    std::string options;
    std::uint64_t bytes = 0;
    std::chrono::system_clock::time_point used{};  ///< for the last time
  };

  /// `rhoray` in XDG_CACHE_HOME, or in ~/.cache if that is not set to an absolute path. Empty when
  /// neither variable is set.
  static std::filesystem::path default_folder();

  /// Opens the folder, and makes it where it is missing. Only its owner can enter it (mode 0700).
  /// Refuses a folder of another user, and one that cannot be made or written
  /// (ErrorCode::resource).
  explicit PackCache(std::filesystem::path folder, std::uint64_t limit_bytes = default_limit_bytes);

  /// The copy that was made with this key of these very files; marks it as used. A damaged entry
  /// counts as none.
  std::optional<Copy> find(const Key& key) const;

  /// Calls `write`, which writes the packed copy, and keeps the copy. Then removes the least
  /// recently used entries until all fit the limit. The new copy can be used even if it is among
  /// them.
  ///
  /// If another process has kept a copy with this key meanwhile, that copy is returned, and the
  /// new one is removed. So the folder holds one copy for each key.
  ///
  /// A copy is not kept if one of its sources changed while packing, or less than 50 ms before.
  /// File systems have coarse clocks, so a second change could get the same time as the first.
  Copy add(const Key& key, const std::function<PackReport(const formats::Destination&)>& write) const;

  std::vector<Entry> entries() const;  ///< last used first
  std::vector<Entry> clear() const;    ///< removes all entries; returns those that it removed

  const std::filesystem::path& folder() const { return folder_; }
  std::uint64_t limit_bytes() const { return limit_bytes_; }

  static constexpr std::uint64_t default_limit_bytes = std::uint64_t{20} << 30;

 private:
  void shrink() const;

  std::filesystem::path folder_;
  std::uint64_t limit_bytes_;
};

}  // namespace rhoray::preprocess

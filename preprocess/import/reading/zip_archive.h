#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace rhoray::preprocess {

/// A file of a zip archive.
struct ZipEntry {
  std::string name;
  std::uint64_t size = 0;  ///< decompressed; no more than an archive this short can hold
  /// Fills these bytes with the next ones. Refuses damaged data. After the last byte it verifies
  /// the checksum.
  std::function<void(std::span<std::byte>)> read{};
  std::function<void()> finish{};  ///< reads what is left, for the checksum
};

/// Visits every file of a zip archive, one after the other, without folders. Files are decompressed
/// only as far as they are read. Refuses a damaged archive.
void visit_zip(const std::filesystem::path& path, const std::function<void(const ZipEntry& entry)>& visit);

/// Decompresses every file of a zip archive in memory, one after the other.
void read_zip(const std::filesystem::path& path,
              const std::function<void(const std::string& name, std::string_view bytes)>& take);

}  // namespace rhoray::preprocess

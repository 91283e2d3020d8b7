#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "preprocess/pack_cache.h"

namespace rhoray::preprocess {

struct OpenOptions {
  /// How a file that is not packed is packed. `fields` names the needed fields, and the first one
  /// is shown. The cap on memory, `command` and `replace_existing` have no effect.
  PackOptions pack{};
  bool use_cache = true;
  std::string program{};  ///< as PackCache::Key::program
  std::uint64_t cache_limit_bytes = PackCache::default_limit_bytes;
  Progress progress{};
};

struct OpenedData {
  formats::PackedFile file;           ///< its name is the path as given
  std::filesystem::path path{};       ///< of a packed file with this content; empty: it is in memory
  bool was_packed = false;            ///< just now
  std::string not_kept{};             ///< why the cache does not hold the copy; empty: it does, or was not asked
  std::vector<std::string> notes{};   ///< of packing
  std::vector<SourceFile> sources{};  ///< as PackReport::sources; none of a file that is not packed here
};

/// Opens any file that can be rendered: a packed file; an OpenVDB file; a volume, mesh or surface
/// that `pack` reads, or its packed copy (PackCache). Without a cache, or without room for a copy,
/// packs into memory.
///
/// Refuses what require_input and check_pack refuse, and options of packing for a file that is not
/// packed here (ErrorCode::usage).
OpenedData open_data(const std::filesystem::path& input, const OpenOptions& options = {});

/// Refuses options of packing, other than fields, for a packed file and for an OpenVDB file
/// (ErrorCode::usage).
void refuse_pack_options(const std::filesystem::path& input, PackOptions options);

}  // namespace rhoray::preprocess

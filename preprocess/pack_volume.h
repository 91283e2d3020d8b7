#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "formats/brick_grid.h"
#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

struct PackVolumeOptions {
  bool linear_layout = false;  ///< plain x-fastest order instead of bricks of bricks
  std::int64_t brick_edge = 4;
  std::int64_t macro_factor = 4;
  int macro_level_count = 3;
  std::optional<formats::ElementType> type{};  ///< store as this type; refused when a value would not survive unchanged
  std::string command{};                       ///< kept in the file
  std::string source_name{};                   ///< kept in the file
  bool replace_existing = false;
};

struct PackVolumeReport {
  formats::GridDescription description;
  std::uint64_t file_bytes = 0;
};

/// Sorts a volume into bricks, builds the macro levels and writes a packed grid. Parallel over oneTBB; the file does
/// not depend on the number of threads. Refuses volumes with fewer than two samples on an axis, and types that a packed
/// grid does not hold (64-bit integers that do not fit F64 exactly).
PackVolumeReport pack_volume(const NeutralVolume& volume, const std::filesystem::path& path,
                             const PackVolumeOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess

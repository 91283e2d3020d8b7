#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "formats/brick_grid.h"
#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

/// How samples lie in the file.
enum class SampleOrder {
  bricks,  ///< bricks of bricks
  linear,  ///< plain x-fastest order
  sparse   ///< only the bricks in which a field has data; for F32 and F64
};

struct PackVolumeOptions {
  SampleOrder order = SampleOrder::bricks;
  std::optional<std::int64_t> brick_edge{};  ///< 2 to 64; not given: 4, and 8 in the sparse order
  std::int64_t largest_superbrick = 8;       ///< bricks per axis of a superbrick at most, 1 to 64; 1: none
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

/// Sorts a volume into bricks, builds the macro levels and writes a packed grid. Runs on all threads; the file does
/// not depend on the number of threads. Refuses volumes with fewer than two samples on an axis, and types that a packed
/// grid does not hold (64-bit integers that do not fit F64 exactly).
///
/// Positions of samples (NeutralVolume::axes) are kept; an axis whose positions are exactly first + i * step becomes
/// part of world_from_grid instead.
PackVolumeReport pack_volume(const NeutralVolume& volume, const std::filesystem::path& path,
                             const PackVolumeOptions& options = {}, const Progress& progress = {});

/// As pack_volume, for several fields on one lattice: the first is shown by default. Refuses fields whose lattices
/// differ (ErrorCode::invalid), and two of the same name.
/// @param fields  at least one
PackVolumeReport pack_grid(std::span<const NeutralVolume> fields, const std::filesystem::path& path,
                           const PackVolumeOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess

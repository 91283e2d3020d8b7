#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "formats/brick_grid.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Order of the samples in the file.
enum class SampleOrder {
  bricks,  ///< bricks, grouped in superbricks
  linear,  ///< plain x-fastest order
  sparse   ///< only the bricks in which a field has data; for F32 and F64
};

struct PackVolumeOptions {
  SampleOrder order = SampleOrder::bricks;
  std::optional<std::int64_t> brick_edge{};  ///< 2 to 64; not given: 4, and 8 in the sparse order
  /// largest number of bricks per axis of a superbrick, 1 to 64; 1: none
  std::int64_t largest_superbrick = 8;
  std::int64_t macro_factor = 4;
  int macro_level_count = 3;
  /// store as this type; refused when it would change a value
  std::optional<formats::ElementType> type{};
  std::string command{};      ///< stored in the file
  std::string source_name{};  ///< stored in the file
  bool replace_existing = false;
  /// Writes no samples. PackedFile::from_descriptor then needs them, in the linear order and in
  /// their own type.
  bool leaves_out_samples = false;
};

struct PackVolumeReport {
  formats::GridDescription description;
  std::uint64_t file_bytes = 0;
  std::vector<formats::ArraySpec> left_out{};  ///< the samples of each field, if they were left out
};

/// Sorts a volume into bricks, builds the macro levels and writes a packed grid. Runs on all
/// threads; the file does not depend on the number of threads. Refuses volumes with fewer than two
/// samples on an axis. Refuses types that a packed grid does not hold (64-bit integers that do not
/// fit F64 exactly).
///
/// Positions of samples (NeutralVolume::axes) are kept. An axis whose positions are exactly first +
/// i * step becomes part of world_from_grid instead.
PackVolumeReport pack_volume(const NeutralVolume& volume, const formats::Destination& destination,
                             const PackVolumeOptions& options = {}, const Progress& progress = {});

/// As pack_volume, for several fields on one lattice; the first is shown by default. Refuses fields
/// whose lattices differ (ErrorCode::invalid), and two fields of the same name.
/// @param fields  at least one
PackVolumeReport pack_grid(std::span<const NeutralVolume> fields, const formats::Destination& destination,
                           const PackVolumeOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess

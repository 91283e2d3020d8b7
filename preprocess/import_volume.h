#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "formats/base/progress.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// How to read bytes without a header: `256x256x128:uint16:le`, x fastest.
struct RawVolume {
  Index3 sample_count;
  formats::ElementType type = formats::ElementType::U8;
  bool big_endian = false;
  std::uint64_t skipped_bytes = 0;
};

/// Parses `NXxNYxNZ:TYPE[:le|be][:SKIP]`. Refuses other text with ErrorCode::usage and names the
/// part that is wrong.
RawVolume parse_raw_volume(const std::string& text);

struct ImportVolumeOptions {
  std::optional<RawVolume> raw;  ///< read as headerless bytes
  /// the scalar to take, by the names of components.h; empty = the first array of scalars, else
  /// the magnitude of the first array
  std::string field;
  bool colors = false;  ///< read 8-bit colours of 3 or 4 components instead of values
  /// of a file with several time steps: "first", "last", "#3" (counted from 0) or a time, which
  /// selects the nearest step; empty = the first
  std::string time{};
  std::optional<Vec3> spacing;           ///< replaces the file's
  std::optional<Vec3> origin;            ///< replaces the file's
  std::uint64_t memory_limit_bytes = 0;  ///< of the reading process; 0 = none
  /// when not empty, the limit is a cap on anonymous memory (process/memory_cap.h)
  std::filesystem::path scratch_folder{};
  Progress progress{};  ///< phase "reading (bytes)", of formats that are read array by array
};

/// Reads a volume of any format of foreign_formats (input_file.h), or raw bytes. The reader runs in
/// a separate process; its crash becomes a refusal. Spacing, origin and direction become
/// world_from_grid; units are kept. Colours are read from image stacks, NRRD, MetaImage, NIfTI,
/// NumPy and VTK image data.
NeutralVolume import_volume(const std::filesystem::path& path, const ImportVolumeOptions& options = {});

}  // namespace rhoray::preprocess

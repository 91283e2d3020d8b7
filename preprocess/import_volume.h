#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

/// How to read bytes without a header: `256x256x128:uint16:le`, x fastest.
struct RawVolume {
  Index3 sample_count;
  formats::ElementType type = formats::ElementType::U8;
  bool big_endian = false;
  std::uint64_t skipped_bytes = 0;
};

/// Parses `NXxNYxNZ:TYPE[:le|be][:SKIP]`; refuses with ErrorCode::usage and the part that is wrong.
RawVolume parse_raw_volume(const std::string& text);

struct ImportVolumeOptions {
  std::optional<RawVolume> raw;            ///< read as headerless bytes
  std::string field;                       ///< name of the array to take; empty = the only or first scalar one
  bool colors = false;                     ///< 8-bit colours of 3 or 4 components are read instead of values
  bool length_of_vectors = false;          ///< where no array is scalar: the length of the first, instead of refusing
  std::optional<Vec3> spacing;             ///< replaces the file's
  std::optional<Vec3> origin;              ///< replaces the file's
  std::uint64_t memory_limit_bytes = 0;    ///< of the reading process; 0 = none
  std::filesystem::path scratch_folder{};  ///< when not empty, a cap on anonymous memory (memory_cap.h), not a limit
  Progress progress{};                     ///< phase "reading (bytes)", of formats that are read array by array
};

/// Reads NRRD (.nrrd, .nhdr), MetaImage (.mhd, .mha), NIfTI (.nii, .nii.gz), VTK image data (.vti, legacy .vtk), or raw
/// bytes. The reader runs in a process of its own; its crash becomes a refusal.
/// Spacing, origin and direction become world_from_grid, units are kept. Colours are read from stacks of pictures,
/// NRRD, MetaImage and VTK image data.
NeutralVolume import_volume(const std::filesystem::path& path, const ImportVolumeOptions& options = {});

}  // namespace rhoray::preprocess

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/affine.h"
#include "formats/field_summary.h"
#include "formats/packed_file.h"

namespace rhoray::preprocess {

/// True for the extension of OpenVDB files.
bool is_vdb(const std::filesystem::path& path);

/// Reads one scalar grid of an OpenVDB file, level set or fog volume, in a separate process.
/// Returns it in the form that is rendered without packing (formats/vdb_grid.h): NanoVDB in memory,
/// single precision.
/// @param field  a scalar by the names of components.h; empty = the first scalar grid by name, else
///               the magnitude of the first vector grid. An unknown name is refused with the
///               names that exist (ErrorCode::usage). A file without scalar or vector grids is
///               refused with what it holds.
/// @param memory_limit_bytes  of the reading process; 0 = none
formats::PackedFile open_vdb(const std::filesystem::path& path, const std::string& field,
                             std::uint64_t memory_limit_bytes = 0);

/// Properties of one grid of an OpenVDB file, of any kind.
struct VdbGridFacts {
  std::string name;
  std::string value_type;  ///< OpenVDB's name: "float", "vec3s", "ptdataidx32"
  std::string grid_class;  ///< "level set", "fog volume", "staggered", "unknown"
  std::string map_type;    ///< of its transform
  std::optional<Affine> world_from_index;
  std::uint64_t active_voxel_count = 0;
  /// of the box of active voxels; meaningless when there are none
  Index3 first_active, last_active;
  std::vector<std::pair<std::string, std::string>> metadata;  ///< as text
  std::optional<double> background;                           ///< of a scalar grid
  /// For a scalar grid: its type in the file, the range of active values and the background, and
  /// the histogram of active values.
  std::optional<formats::FieldSummary> field;
};

/// Describes every grid of an OpenVDB file, read in a separate process.
std::vector<VdbGridFacts> inspect_vdb(const std::filesystem::path& path, std::uint64_t memory_limit_bytes = 0);

}  // namespace rhoray::preprocess

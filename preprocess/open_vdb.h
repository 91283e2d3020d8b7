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

/// Reads one scalar grid of an OpenVDB file, level set or fog volume, in a process of its own, and gives it in the form
/// that is rendered without packing (formats/vdb_grid.h): NanoVDB in memory, single precision.
/// @param field  name of a grid, or NAME.x, NAME.y, NAME.z, NAME.mag of a vector grid; empty = the first scalar grid by
///               name. Refused with the names there are (ErrorCode::usage); a file without scalars with what it holds.
/// @param memory_limit_bytes  of the reading process; 0 = none
formats::PackedFile open_vdb(const std::filesystem::path& path, const std::string& field,
                             std::uint64_t memory_limit_bytes = 0);

/// What is known of one grid of an OpenVDB file, of whatever kind.
struct VdbGridFacts {
  std::string name;
  std::string value_type;  ///< as OpenVDB names it: "float", "vec3s", "ptdataidx32"
  std::string grid_class;  ///< "level set", "fog volume", "staggered", "unknown"
  std::string map_type;    ///< of its transform
  std::optional<Affine> world_from_index;
  std::uint64_t active_voxel_count = 0;
  Index3 first_active, last_active;  ///< of the box around active voxels; meaningless when there is none
  std::vector<std::pair<std::string, std::string>> metadata;  ///< as text
  std::optional<double> background;                           ///< of a scalar grid
  /// Of a scalar grid: its type in the file, range of active values and the background, histogram of active values.
  std::optional<formats::FieldSummary> field;
};

/// Every grid of an OpenVDB file, read in a process of its own.
std::vector<VdbGridFacts> inspect_vdb(const std::filesystem::path& path, std::uint64_t memory_limit_bytes = 0);

}  // namespace rhoray::preprocess

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/affine.h"
#include "formats/field_summary.h"
#include "formats/packed_file.h"

namespace rhoray::formats {

/// A scalar grid of an OpenVDB file, as the worker that read it passes it to the renderer: an
/// anonymous packed file of kind "vdb" that is never kept on disk. Voxel (i, j, k) is a sample at
/// world_from_index.point({i, j, k}). Between samples the field is trilinear. The cells between the
/// samples of a box are shown.
struct VdbGridDescription {
  /// range over the box, histogram over active voxels; type F32
  FieldSummary field;
  std::vector<std::string> field_names;  ///< of all scalar grids in the OpenVDB file
  Affine world_from_index;
  Index3 first_sample;     ///< of the box; at least -2^30 on every axis
  Index3 sample_count{2};  ///< of the box; at least 2 and at most 2^30 on every axis
  bool is_level_set = false;
  std::string length_unit;
  std::uint64_t active_voxel_count = 0;
  std::vector<std::string> notes;  ///< what reading changed or left out, one sentence each
};

/// The description, checked, and the NanoVDB buffer (array "nanovdb" U8), whose content is not
/// checked.
class VdbGrid {
 public:
  explicit VdbGrid(PackedFile file);

  const VdbGridDescription& description() const { return description_; }
  const PackedFile& file() const { return file_; }
  std::span<const std::byte> buffer() const { return file_.bytes(buffer_array); }

  static constexpr const char* kind = "vdb";
  static constexpr const char* buffer_array = "nanovdb";

 private:
  PackedFile file_;
  VdbGridDescription description_;
};

FileDescription describe(const VdbGridDescription& description);

}  // namespace rhoray::formats

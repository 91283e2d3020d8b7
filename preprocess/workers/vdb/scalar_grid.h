#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "formats/base/affine.h"
#include "formats/packed_file.h"

namespace rhoray::preprocess {

/// Metadata of our own: a grid that has `sample_count_key` is a box of samples from voxel (0, 0, 0)
/// on, in which voxels that are not active have no data.
inline constexpr const char* sample_count_key = "rhoray_sample_count";
inline constexpr const char* length_unit_key = "rhoray_length_unit";
inline constexpr const char* field_unit_key = "rhoray_field_unit";

/// One scalar grid of a file, each value held exactly: float grids as they are, all others in
/// double precision. Voxels without data are NaN, active or not.
struct ScalarGrid {
  std::string name;  ///< as --field takes it: "density", "velocity.x", "velocity.mag"
  std::variant<openvdb::FloatGrid::Ptr, openvdb::DoubleGrid::Ptr> grid;
  formats::ElementType source_type = formats::ElementType::F32;  ///< F32, F64, I32, I64 or U8
  bool inactive_is_no_data = false;
  openvdb::CoordBBox box;  ///< of samples: those that are active and one more at each side, or the samples' own box
  Affine world_from_index;
  std::string length_unit, field_unit;
  std::vector<std::string> field_names;  ///< of all scalars in the file
  std::vector<std::string> notes;

  const openvdb::GridBase& base() const {
    return std::visit([](const auto& g) -> const openvdb::GridBase& { return *g; }, grid);
  }
  bool is_level_set() const { return base().getGridClass() == openvdb::GRID_LEVEL_SET; }
  Index3 sample_count() const {
    const openvdb::Coord size = box.dim();
    return {size.x(), size.y(), size.z()};
  }
};

/// An OpenVDB file, opened; refuses what cannot be read as one.
class VdbFile {
 public:
  explicit VdbFile(const std::filesystem::path& path);
  ~VdbFile() { file_.close(); }
  VdbFile(const VdbFile&) = delete;
  VdbFile& operator=(const VdbFile&) = delete;

  /// Grids without their values; null for one of a type that OpenVDB does not know.
  struct Entry {
    std::string name;
    openvdb::GridBase::Ptr grid;
  };
  std::vector<Entry> entries();
  openvdb::GridBase::Ptr read(const std::string& name);

 private:
  std::filesystem::path path_;
  openvdb::io::File file_;
};

/// Names of the scalars in a grid: its own, or those of a vector grid (components.h); empty for
/// grids of other kinds.
std::vector<std::string> scalars_of(const VdbFile::Entry& entry);

/// "float", "vec3s", "ptdataidx32" and so on, as OpenVDB names the type of a grid's values.
std::string value_type_of(const VdbFile::Entry& entry);

/// Reads the scalar of this name; empty takes the first scalar grid by name, else the magnitude of
/// the first vector grid, with a note. Refuses points and other grids without a scalar, frustums,
/// and grids without an active voxel.
ScalarGrid read_scalar_grid(const std::filesystem::path& path, const std::string& field);

/// The map of a grid, if it is affine.
std::optional<Affine> affine_of(const openvdb::math::Transform& transform);

}  // namespace rhoray::preprocess

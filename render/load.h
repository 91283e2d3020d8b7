#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/vector.h"
#include "formats/field_summary.h"
#include "formats/packed_file.h"

namespace rhoray::render {

struct VolumeImplementation;

/// What rays cross: a packed grid, a packed mesh with one chosen field, a packed surface, which has none, or a grid of
/// an OpenVDB file. Copies share everything.
class Volume {
 public:
  /// Opens a packed file and checks what rendering relies on; block checksums are left to the caller
  /// (PackedFile::damaged_blocks), so that they can run beside the first frame.
  /// @param field  name; empty takes the first. An unknown name is refused with the names there are (Trouble::usage).
  static Volume load(const std::filesystem::path& path, const std::string& field = {});

  /// As above, for a file that is open already; also takes the kind "vdb" (formats/vdb_grid.h).
  static Volume load(const formats::PackedFile& file, const std::string& field = {});

  const formats::PackedFile& file() const;
  const formats::FieldSummary& field() const;  ///< of a surface: without a name and values
  std::vector<std::string> field_names() const;
  /// Of a field of the file, by name; nothing where there is none, or it is another grid of an OpenVDB file.
  std::optional<formats::FieldSummary> field(const std::string& name) const;
  const std::string& length_unit() const;
  bool is_mesh() const;       ///< of tetrahedra
  bool is_surface() const;    ///< triangles, shown as they are (Mode::triangles): no field
  bool is_level_set() const;  ///< its values are distances to the surface where they are 0

  const std::vector<std::string>& notes() const;  ///< what loading changed, one sentence each

  Box3 bounds() const;  ///< of all cells, world axes
  /// Of the isosurface, world axes: in a mesh its own; in a grid those of the macrocells of the lowest level that it
  /// can pass through. Empty when the isovalue is passed nowhere, and of a surface.
  Box3 isosurface_bounds(double isovalue) const;

  const VolumeImplementation& implementation() const { return *implementation_; }  ///< for the room's inside

 private:
  explicit Volume(std::shared_ptr<const VolumeImplementation> implementation);
  std::shared_ptr<const VolumeImplementation> implementation_;
};

}  // namespace rhoray::render

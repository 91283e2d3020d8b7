#pragma once

#include <cstdint>
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

/// What it took to prove that stored ranges hold (Volume::prove_ranges); all 0 where they had been proven before.
struct RangeProof {
  std::uint64_t bytes = 0;  ///< of the file that were compared
  double wall_s = 0;

  RangeProof& operator+=(const RangeProof& other) {
    bytes += other.bytes;
    wall_s += other.wall_s;
    return *this;
  }
};

/// What rays cross: a packed grid, a packed mesh with one chosen field, a packed surface, which has none, or a grid of
/// an OpenVDB file. Copies share everything.
class Volume {
 public:
  /// Opens a packed file and checks what rendering relies on; block checksums are left to the caller
  /// (PackedFile::damaged_blocks), so that they can run beside the first frame.
  /// @param field  name; empty takes the first. An unknown name is refused with the names there are (ErrorCode::usage).
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

  /// Proves that the value ranges, boxes and leaf lists by which rays pass cells hold what they stand for
  /// (formats/range_proof.h), once for this volume and all copies of it. Refuses data of which that is not true
  /// (ErrorCode::invalid), each time.
  ///
  /// Certified and exact answers are worth what these ranges are worth, so `render`, `refine` and RayCaster call
  /// this before they answer by a method that proves; other methods do not pay for it. Nothing is to be proven of an
  /// OpenVDB grid, of which the ranges are made from its voxels in loading it, and of a surface, which has none.
  /// Any thread may call; those that call meanwhile wait.
  /// @param threads  0 = all cores
  RangeProof prove_ranges(unsigned threads = 0) const;

  const VolumeImplementation& implementation() const { return *implementation_; }  ///< for the room's inside

 private:
  explicit Volume(std::shared_ptr<const VolumeImplementation> implementation);
  struct ProofState;
  std::shared_ptr<const VolumeImplementation> implementation_;
  std::shared_ptr<ProofState> proof_;  ///< kept with the loaded data, so that nothing loaded later is taken for it
};

}  // namespace rhoray::render

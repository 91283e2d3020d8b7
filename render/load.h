#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "formats/base/vector.h"
#include "formats/field_summary.h"
#include "formats/packed_file.h"
#include "formats/space.h"

namespace rhoray::render {

struct LoadedDataset;

/// The cost of proving the stored ranges (Dataset::prove_ranges); all 0 when they had been proven
/// before.
struct RangeProof {
  std::uint64_t bytes = 0;  ///< bytes of the file that were compared
  double wall_s = 0;

  RangeProof& operator+=(const RangeProof& other) {
    bytes += other.bytes;
    wall_s += other.wall_s;
    return *this;
  }
};

/// Edges at which a surface turns, for lines over a picture.
struct FeatureEdges {
  std::vector<std::array<Vec3, 2>> edges;  ///< their ends, world axes
  double mean_distance = 0;                ///< between lines: area of the surface over their length; 0: no line
};

/// A dataset that rays are traced through: a packed grid, a packed mesh with one chosen field, its
/// boundary, a packed surface (which has no field), or a grid of an OpenVDB file. Copies share
/// everything.
class Dataset {
 public:
  /// Opens a packed file and checks what rendering relies on. Block checksums are left to the
  /// caller (PackedFile::damaged_blocks), so that they can be checked while the first frame is
  /// rendered.
  /// @param field  name; empty takes the first. An unknown name is refused with a list of the names
  ///   that exist (ErrorCode::usage).
  /// @param world  the space that world coordinates are converted to where the file says which is
  ///   its own; unknown: they stay the file's
  static Dataset load(const std::filesystem::path& path, const std::string& field = {},
                      formats::Space world = formats::Space::unknown, const Watch& watch = {});

  /// As above, for a file that is already open; also accepts the kind "vdb" (formats/vdb_grid.h).
  static Dataset load(const formats::PackedFile& file, const std::string& field = {},
                      formats::Space world = formats::Space::unknown, const Watch& watch = {});

  /// Returns the boundary of a mesh: a surface of the triangles that belong to one cell only. A
  /// triangle has the fields of its cell. If the file does not store the boundary, this function
  /// computes it. While a boundary is in use, further calls return it again; any thread may call.
  /// Refuses a dataset of another kind (ErrorCode::usage). A stop request also ends the wait for
  /// another caller.
  Dataset boundary(const Watch& watch = {}) const;
  /// Returns the boundary of the cells of a mesh that have this label in a field of cells: a closed
  /// surface, unless a face belongs to three cells. A face between two labels is part of both
  /// surfaces. Refuses a dataset of another kind, an unknown field (ErrorCode::usage) and a label
  /// that no cell has (ErrorCode::invalid).
  /// @param without  labels; the faces to their cells are left out
  Dataset boundary(const std::string& cell_field, int label, std::span<const int> without = {},
                   const Watch& watch = {}) const;

  const formats::PackedFile& file() const;
  const formats::FieldSummary& field() const;    ///< of a surface: without a name and values
  std::vector<std::string> field_names() const;  ///< that a dataset can be loaded for
  /// Names of the fields that can colour hits: these, and fields of a mesh's cells.
  std::vector<std::string> color_names() const;
  /// Returns the summary of a field that can colour hits. Where a field of cells and a field of
  /// points have one name, the second was averaged from the first, and the summary is that of the
  /// first. Returns nothing if there is no such field, or if it is another grid of an OpenVDB file.
  std::optional<formats::FieldSummary> field(const std::string& name) const;
  /// The summaries that the file holds: of fields at samples or points, and of fields of cells.
  std::span<const formats::FieldSummary> point_fields() const;
  std::span<const formats::FieldSummary> cell_fields() const;
  const std::string& length_unit() const;
  formats::Space space() const;  ///< of world coordinates
  bool is_mesh() const;          ///< true for tetrahedra
  /// True for triangles, which are shown as they are (Mode::triangles): a packed surface, or the
  /// boundary of a mesh.
  bool is_surface() const;
  bool has_fields() const;    ///< false for a packed surface
  bool is_level_set() const;  ///< true when the values are distances to the surface at value 0
  /// True for a surface packed from a format in which +y is up by convention: .obj or .ply.
  bool is_y_up() const;

  const std::vector<std::string>& notes() const;  ///< changes made while loading, one sentence each

  Box3 bounds() const;  ///< of all cells, world axes
  /// Returns the bounds of the isosurface, world axes. In a mesh they are its own; in a grid they
  /// are those of the cells that it passes through. Empty when nothing crosses the isovalue, and
  /// for a surface.
  Box3 isosurface_bounds(double isovalue) const;
  /// Returns the corners of up to some ten thousand boxes, world axes; their convex hull contains
  /// the isosurface, or the triangles of a surface. Every box is as small as the points of the
  /// isosurface (of a grid: the cells that it passes through) in its part of the data allow.
  std::vector<std::array<Vec3, 8>> shown_boxes(double isovalue, const Watch& watch = {}) const;

  /// Returns the edges of a surface at which it turns by more than an angle: 0 where its triangles
  /// lie in one plane. An edge of one triangle, or of more than two, counts as 180 degrees, so that
  /// 180 returns none. Refuses a dataset of another kind (ErrorCode::usage).
  /// @param threads  0 = all cores
  FeatureEdges feature_edges(double angle_deg, unsigned threads = 0) const;

  /// Proves that the value ranges, boxes and leaf lists with which rays skip cells are correct
  /// (formats/range_proof.h). Does so once for this dataset and all its copies. Refuses data for
  /// which they are not (ErrorCode::invalid), at each call.
  ///
  /// Certified and exact results are only as reliable as these ranges. `render`, `refine` and
  /// RayCaster therefore call this before they use a method that proves its results; other methods
  /// do not pay for it. There is nothing to prove for an OpenVDB grid, whose ranges are computed
  /// from its voxels while loading, nor for a surface, which has none. Any thread may call;
  /// concurrent callers wait.
  ///
  /// A stop request ends the call (ErrorCode::interrupted), also while it waits for another caller.
  /// A proof that was stopped counts for nothing: the next call makes all of it. If the proof is
  /// already done, a stop request changes nothing.
  /// @param threads  0 = all cores
  RangeProof prove_ranges(unsigned threads = 0, const Watch& watch = {}) const;

  /// Returns the bytes of memory that hold what was prepared for tracing and is kept for the next
  /// picture: facets and occupied blocks of the last four isovalues, normals, gradients. The file
  /// does not count. Boundaries count their own. Any thread may call. Waits while something is
  /// being prepared.
  std::uint64_t prepared_bytes() const;
  /// Frees what was prepared, except what contexts and callers hold. Changes no picture: the next
  /// one prepares again. Any thread may call. Waits while something is being prepared.
  void drop_prepared() const;

  /// For use inside render only.
  const LoadedDataset& implementation() const { return *implementation_; }

 private:
  explicit Dataset(std::shared_ptr<const LoadedDataset> implementation);
  struct ProofState;
  std::shared_ptr<const LoadedDataset> implementation_;
  /// Kept with the loaded data, so that it never applies to data loaded later.
  std::shared_ptr<ProofState> proof_;
  struct Boundaries;
  std::shared_ptr<Boundaries> boundaries_;
};

}  // namespace rhoray::render

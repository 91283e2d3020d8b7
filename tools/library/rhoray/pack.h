#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rhoray/array_view.h"
#include "rhoray/dataset.h"
#include "rhoray/export.h"
#include "rhoray/progress.h"
#include "rhoray/types.h"

namespace rhoray::RHORAY_ABI {

/// The order of the axes of a grid's arrays. numpy's C order of volumes is mostly zyx: the last
/// index is x.
enum class AxisOrder {
  zyx,  ///< values[k][j][i]: the last index counts along x
  xyz   ///< values[i][j][k]: the first index counts along x
};

/// A field in the caller's memory. NaN and infinite values mean that there is no data; cells that
/// touch one are absent.
struct FieldArray {
  std::string name;
  ArrayView values;
  std::string unit{};
  std::map<int, std::string> label_names{};  ///< of integers that mark regions
};

/// Samples on a lattice. Sample (i, j, k) is at world_from_grid(i, j, k).
struct GridArrays {
  /// At least one. Names differ and are not empty; the first is shown by default. All have one
  /// shape of three axes with at least 2 samples each. U64 and I64 must fit a double exactly.
  std::vector<FieldArray> fields;
  /// Along x, y and z, whatever the axis order; finite, above 0. The volume of a cell and its inverse
  /// are within the range of doubles.
  Vec3 spacing{1, 1, 1};
  Vec3 origin{};  ///< position of sample (0, 0, 0)
  /// Replaces spacing and origin: rotated, sheared or mirrored lattices. Its axes must be linearly
  /// independent, with a volume as for `spacing`.
  std::optional<Affine> world_from_grid{};
  /// Replaces spacing and origin: positions of the samples along x, y and z, strictly rising, one
  /// for each sample of the axis. Give all three or none.
  std::array<std::vector<double>, 3> positions{};
  std::string length_unit{};
};

/// Tetrahedra with fields, whose names differ. Their box has a volume.
struct MeshArrays {
  ArrayView points;      ///< [points, 3], F32 or F64, up to 1e100, world axes
  ArrayView tetrahedra;  ///< [cells, 4], integers: indices of points, in VTK's order; others are turned
  std::vector<FieldArray> point_fields{};  ///< [points] each; linear in each cell
  /// [cells] each; they colour surfaces. Without point fields they are also averaged to the points.
  /// If no field of the mesh varies, the distance from the boundary and the coordinates are added,
  /// and come first; cells may be split for them. Dataset::notes says so.
  std::vector<FieldArray> cell_fields{};
  std::string length_unit{};
};

/// A surface of triangles.
struct SurfaceArrays {
  ArrayView points;     ///< [points, 3], F32 or F64, finite, world axes
  ArrayView triangles;  ///< [triangles, 3], integers: indices of points
  std::string length_unit{};
};

/// Whose memory holds the samples of a dataset.
enum class Memory {
  copy,  ///< the dataset's: the arrays may be freed after `pack`
  /// The caller's: rays read the arrays themselves. Only for grids whose samples are contiguous
  /// with x fastest, aligned, of any type but U64 and I64. Others are refused with the reason;
  /// nothing is copied instead. The ranges of macrocells take 3 % more memory.
  ///
  /// The arrays must live, and must not change, as long as the dataset or anything that holds it:
  /// the ranges would no longer hold, and neither would proven errors. Answers have the same bits
  /// as of a copy, but for the channel `cost`. Rays took 0 to 23 % more CPU time (medians of our
  /// measurements), because neighbours are further apart in memory than in bricks.
  wrap
};

/// Where `pack` writes, and how it is watched.
struct PackOptions {
  /// Where the packed file is written. Empty: it stays in memory.
  std::filesystem::path file{};
  bool replace_existing = false;  ///< false: an existing file is refused
  /// A stop request ends the call with ErrorCode::interrupted. No file is left behind, also if the
  /// progress function throws.
  Watch watch{};
  Memory memory = Memory::copy;
  /// With Memory::wrap: an object that keeps the arrays alive. It is released with the last handle
  /// of the dataset, on any thread. Empty: the caller keeps them alive.
  std::shared_ptr<const void> owner{};
};

/// Packs arrays into the format that rays are traced through, and opens the result. `rhoray pack`
/// writes the same bytes, apart from the stored command. The arrays may be freed afterwards, and
/// must not change meanwhile. Work runs on all cores. Samples that are contiguous with x fastest
/// are read while packing; other arrays are copied first.
///
/// With Memory::wrap nothing is copied (see there).
///
/// Throws ErrorCode::usage for arrays that break the rules above, with the name of the array, what
/// was found and what was expected; for arrays that cannot be wrapped; for Memory::wrap with a file
/// or with anything but a grid. Throws ErrorCode::resource for a full disk.
RHORAY_API Dataset pack(const GridArrays& grid, AxisOrder order, const PackOptions& options = {});
RHORAY_API Dataset pack(const MeshArrays& mesh, const PackOptions& options = {});
RHORAY_API Dataset pack(const SurfaceArrays& surface, const PackOptions& options = {});

}  // namespace rhoray::RHORAY_ABI

#pragma once

#include <cstdint>
#include <string>

#include "formats/base/progress.h"
#include "formats/packed_file.h"

namespace rhoray::tools {

/// The part of a field whose values are at least an isovalue, in world units. Cells without data
/// count as outside.
struct Enclosed {
  double volume = 0;
  double volume_error = 0;  ///< proven: the volume of the trilinear or linear field differs by no more
  double area = 0;          ///< of the isosurface: an estimate, by triangles of the crossed cells
  double whole_volume = 0;  ///< of all cells with data
  std::uint64_t crossed_cells = 0, cells_without_data = 0;
};

struct EnclosedOptions {
  std::string field{};  ///< empty: the first
  double isovalue = 0;
  /// Crossed cells are divided until at most this share of each is neither inside nor outside for
  /// sure, or 6 times.
  double undecided_share = 1e-3;
  unsigned threads = 0;
  Progress progress{};
};

/// Measures a packed grid or mesh. Refuses other kinds (ErrorCode::unsupported) and an unknown
/// field (ErrorCode::usage).
///
/// In a tetrahedron the field is linear, and the volume above an isovalue is a sum of products. A
/// cell of a grid is cut into six tetrahedra with a linear field each, which differs from the
/// trilinear one by at most R = (|c_xy| + |c_yz| + |c_xz|) / 4 + 0.385 |c_xyz|, from the field's
/// mixed coefficients. The volume lies between those of the linear fields above isovalue + R and
/// isovalue - R. Halving a cell divides R by about four.
Enclosed measure_enclosed(const formats::PackedFile& file, const EnclosedOptions& options);

}  // namespace rhoray::tools

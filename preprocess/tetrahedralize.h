#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Target edge length by the distance d to a surface: `near` + `growth` d, at most `far`.
struct SizeByDistance {
  NeutralSurface surface;
  double near = 0;
  double far = 0;
  double growth = 0;
};

/// Target edge lengths in space: the values of a volume, of the first point field of a mesh, or by
/// a distance. They are interpolated between samples. Where there is no value (outside, NaN) there
/// is no target. Values that are used must be above 0.
using SizeField = std::variant<NeutralVolume, NeutralMesh, SizeByDistance>;

inline constexpr double usual_quality = 1.4;
inline constexpr std::uint64_t most_cells_per_triangle = 20;

struct TetrahedralizeOptions {
  struct RegionVolume {
    double region = 0;  ///< its number in cell field "region"
    double max_volume = 0;
  };

  /// Largest allowed ratio of circumradius to shortest edge (TetGen -q); 0 = no new points for
  /// quality. TetGen continues until the ratio holds wherever the surface allows it. Around needles
  /// of a scanned surface this may take very long. Not given: usual_quality; but where no size is
  /// requested either, what terminates (tetrahedralize below).
  std::optional<double> quality{};
  /// Of a tetrahedron, in the surface's units cubed (TetGen -a); 0 = no limit. TetGen's smoothing
  /// at the end may leave a few cells above it.
  double max_volume = 0;
  std::vector<RegionVolume> region_volumes{};  ///< the same for single regions
  /// follow NeutralSurface::point_sizes where given (TetGen -m)
  bool use_point_sizes = true;
  std::shared_ptr<const SizeField> size_field{};
  bool regions = true;  ///< number the regions: cell field "region" (TetGen -A)
  /// of nested surfaces, the second, fourth, ... from outside bound nothing that is filled
  bool empty_cavities = false;
  /// accept edges with four, six, ... facets: solids that touch there
  bool solids_may_touch = false;
  std::string tetgen{};  ///< further TetGen switches, of Y O S T X M, with their numbers
  std::uint64_t memory_limit_bytes = std::uint64_t{8} << 30;  ///< of the worker
  double time_limit_s = 3600;                                 ///< CPU seconds of the worker
};

/// Joins several surfaces into one; facets and points are numbered on from one to the next.
NeutralSurface join(std::span<const NeutralSurface> surfaces);

/// Fills closed surfaces with tetrahedra (TetGen 1.5, in a worker process with limits on memory and
/// time). A surface that is open, not manifold, or self-intersecting is refused with counts and the
/// positions of the first faults (all of them: inspect_surface.h). A surface on which TetGen fails
/// or crashes is refused too.
///
/// Without a requested quality or size, the first attempt keeps the surface's triangles (TetGen -Y)
/// and adds points only inside. That mesh is the result, unless a tenth of its volume or half of
/// its cells miss usual_quality. Then the surface's triangles are split too, and the better mesh is
/// the result. No more points are added than make most_cells_per_triangle cells for each triangle
/// of the surface (a facet of n corners counts as n - 2). A note of the mesh says which one it is,
/// how much of it misses usual_quality, and whether the number of cells is the reason.
///
/// The mesh has cell field "region" when there is more than one region or the surface has seeds,
/// which then give the numbers. Otherwise regions are numbered from 1, from outside in: by how many
/// walls lie between a region and the outside, and among equals by their first point.
NeutralMesh tetrahedralize(const NeutralSurface& surface, const TetrahedralizeOptions& options = {});

}  // namespace rhoray::preprocess

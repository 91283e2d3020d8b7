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

/// Wanted edge length by the distance d to a surface: `near` + `growth` d, at most `far`.
struct SizeByDistance {
  NeutralSurface surface;  ///< triangles
  double near = 0;
  double far = 0;
  double growth = 0;
};

/// Wanted edge lengths in space: the values of a volume, of the first point field of a mesh, or by a distance. Between
/// samples they are interpolated; where there is no value (outside, NaN) none is wanted. Those met must be above 0.
using SizeField = std::variant<NeutralVolume, NeutralMesh, SizeByDistance>;

inline constexpr double usual_quality = 1.4;

struct TetrahedralizeOptions {
  struct RegionVolume {
    double region = 0;  ///< its number in cell field "region"
    double max_volume = 0;
  };

  /// Wanted largest ratio of circumradius to shortest edge (TetGen -q); 0 = no new points for quality. TetGen goes on
  /// until it holds wherever the surface allows it, which around needles of a scanned surface may take very long.
  /// Nothing: usual_quality, and where no size is wanted either, what comes to an end (tetrahedralize below).
  std::optional<double> quality{};
  double max_volume = 0;  ///< of a tetrahedron, in the surface's units cubed (TetGen -a); 0 = no limit.
                          ///< TetGen's smoothing at the end may leave a few cells above it
  std::vector<RegionVolume> region_volumes{};  ///< the same for single regions
  bool use_point_sizes = true;                 ///< follow NeutralSurface::point_sizes where given (TetGen -m)
  std::shared_ptr<const SizeField> size_field{};
  bool regions = true;            ///< number the regions: cell field "region" (TetGen -A)
  bool empty_cavities = false;    ///< of nested surfaces, the second, fourth, ... from outside bounds nothing filled
  bool solids_may_touch = false;  ///< accept edges with four, six, ... facets: solids that touch there
  std::string tetgen{};           ///< further switches of TetGen, of Y O S T X M, with their numbers
  std::uint64_t memory_limit_bytes = std::uint64_t{8} << 30;  ///< of the worker
  double time_limit_s = 3600;                                 ///< CPU seconds of the worker
};

/// Several surfaces as one; facets and points are numbered on from one to the next.
NeutralSurface join(std::span<const NeutralSurface> surfaces);

/// Fills closed surfaces with tetrahedra (TetGen 1.5, in a worker process with limits on memory and time).
/// A surface that is open, not manifold, or crosses itself is refused with counts and the places of the first faults
/// (all of them: inspect_surface.h); so is one on which TetGen fails or dies.
///
/// Without a wanted quality or size, the surface's triangles are kept as they are at first (TetGen -Y), with new points
/// inside alone. That is the mesh, unless a tenth of its volume or half of its cells miss usual_quality: then the
/// surface's triangles are split too, by at most 250 000 new points. When these do not suffice, or TetGen fails over
/// it, the first mesh stands. A note of the mesh says which it is and how much of it misses usual_quality.
///
/// The mesh has cell field "region" when there is more than one region or the surface has seeds, which then give the
/// numbers. Otherwise regions count from 1, from outside in: by how many walls lie between a region and the outside,
/// and among equals by their first point.
NeutralMesh tetrahedralize(const NeutralSurface& surface, const TetrahedralizeOptions& options = {});

}  // namespace rhoray::preprocess

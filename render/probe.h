#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "render/render.h"

/// Everything that the ray through a point of a picture meets, also behind opaque surfaces.
namespace rhoray::render {

/// A position in a picture, in pixels. The centre of pixel (i, j) is at (i, j).
struct PicturePoint {
  double x = 0, y = 0;
};

/// A point of a layer on the ray.
struct ProbeHit {
  static constexpr double not_proven = std::numeric_limits<double>::quiet_NaN();

  std::size_t layer = 0;  ///< index into Scene::layers
  double depth = 0;       ///< distance from the ray's start, world units
  Vec3 position{};        ///< world axes
  /// Bound on the distance from the exact position, world units (position_error); or not_proven.
  double error = not_proven;
  std::uint64_t cell = 0;
  /// The isovalue, the largest value, or the field's value on a slice or on coloured triangles.
  /// NaN: triangles without a field.
  double value = std::numeric_limits<double>::quiet_NaN();
  double value_error = not_proven;  ///< bound on the distance from the exact largest value
  std::string unit{};               ///< of the value
};

/// Finds everything that the ray through a point of a picture meets, nearest first; of equal depths
/// slices first, then the scene's order. An integer point has the ray that `render` sends through
/// the centre of that pixel.
///
/// - Isosurfaces: all crossings (all_crossings.h), also behind opaque surfaces. Exact arithmetic
///   decides, whatever the layer's method.
/// - Triangles: all hits at float64, also behind opaque surfaces.
/// - Slices: at most one point.
/// - Largest values: at most one point, up to the nearest opaque surface; in exact arithmetic.
///
/// Surfaces of zero opacity are left out, and so is what the clip region removes. Runs on the
/// calling thread.
///
/// Refuses a point outside the picture and what `render` refuses (ErrorCode::usage); data with an
/// isosurface or a projection whose stored ranges do not hold (ErrorCode::invalid).
/// @param options  size of the picture; threads that prove ranges; the machine. Nothing else is
///   read
/// @param most     number of points at most, nearest first
/// @param watch    watches the proof of ranges
std::vector<ProbeHit> probe(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options,
                            const PicturePoint& point, std::size_t most, const Watch& watch = {});

/// Bound on the distance of a position in the world from the exact position. It includes the error
/// of the depth, and the rounding of the arithmetic from a depth to a position.
/// @param bound  on the error of the depth
double position_error(double bound, double depth, const Vec3& eye, const Vec3& position);

}  // namespace rhoray::render

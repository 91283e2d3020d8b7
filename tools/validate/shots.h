#pragma once

#include <functional>
#include <limits>
#include <string_view>
#include <vector>

#include "tools/validate/rays.h"

namespace rhoray::tools::validate {

inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

/// Result of a comparison for one ray.
enum class Verdict {
  right,
  missed,     ///< false negative: the surface is there, but no hit was reported
  false_hit,  ///< false positive: a hit, but no surface
  elsewhere,  ///< a hit, but not at the ray's first crossing of the surface
  /// Correct for a ray moved by rounding: it passes very close to the surface's outline.
  grazes,
  undecided  ///< the reference is not exact enough to decide (grids)
};
std::string_view name_of(Verdict verdict);

/// Comparison of the renderer's hit with the reference for one ray. Distances are in cells and in
/// diagonals of the data's box; NaN where there is nothing to measure.
struct Finding {
  Verdict verdict = Verdict::right;
  bool was_redecided = false;
  bool is_hit = false;  ///< according to the reference
  double t_reference = not_measured;
  /// Along the ray, from the reference's crossing.
  double depth_cells = not_measured, depth_box = not_measured;
  /// The depth error's bound that the method reports.
  double bound_cells = not_measured, bound_box = not_measured;
  /// Upper bound from the hit to the surface.
  double distance_cells = not_measured, distance_box = not_measured;
  double mesh_cells = not_measured;  ///< from the hit to the mesh beside the reference (grids)
  double normal_deg = not_measured;
  double moved_box = not_measured;  ///< for a grazing ray: how far it was moved
  bool is_above = false;            ///< values at the hit are larger than on the surface
};

/// Rays with their hits and findings; all three have one entry per ray.
struct Shots {
  std::vector<AimedRay> rays;
  std::vector<render::Hit> hits;
  std::vector<Finding> findings;
};

/// All rays of a comparison: from around the data, from just in front of the surface, and of the
/// picture.
struct Rounds {
  Shots far, near, camera;
};

/// Rays to be traced, and the function that evaluates the hits.
struct RoundsToShoot {
  std::vector<AimedRay> far, near;
  std::vector<render::Ray> camera;
  /// Called from all threads.
  std::function<Finding(const render::Ray& ray, const render::Hit& hit)> find;
};

/// Traces the rays and evaluates every hit; progress goes from 300 to 1000.
Rounds shoot(const Tracer& tracer, RoundsToShoot rounds, const Thousandths& progress);

}  // namespace rhoray::tools::validate

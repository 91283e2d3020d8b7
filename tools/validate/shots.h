#pragma once

#include <functional>
#include <limits>
#include <string_view>
#include <vector>

#include "tools/validate/rays.h"

namespace rhoray::tools::validate {

inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

/// What a comparison says of one ray.
enum class Verdict {
  right,
  missed,     ///< the surface is there, and no hit was reported
  false_hit,  ///< a hit, and no surface
  elsewhere,  ///< a hit, but not where the ray first crosses the surface
  grazes,     ///< right for a ray moved by rounding: it passes the surface's outline so closely
  undecided   ///< the reference is not exact enough to tell (grids)
};
std::string_view name_of(Verdict verdict);

/// What was found about the renderer's answer for a ray. Distances come in cells and in diagonals of the data's box;
/// NaN where there is nothing to measure.
struct Finding {
  Verdict verdict = Verdict::right;
  bool was_redecided = false;
  bool is_hit = false;  ///< by the reference
  double t_reference = not_measured;
  double depth_cells = not_measured, depth_box = not_measured;        ///< along the ray, from the reference's crossing
  double bound_cells = not_measured, bound_box = not_measured;        ///< of the depth error, as the method states it
  double distance_cells = not_measured, distance_box = not_measured;  ///< from the hit to the surface, at most
  double mesh_cells = not_measured;  ///< from the hit to the mesh beside the reference (grids)
  double normal_deg = not_measured;
  double moved_box = not_measured;  ///< of a ray that grazes, how far it was moved
  bool is_above = false;            ///< the hit lies where values are larger than on the surface
};

/// Rays with their answers, and what was found of each; all three have one entry per ray.
struct Shots {
  std::vector<AimedRay> rays;
  std::vector<render::Hit> hits;
  std::vector<Finding> findings;
};

/// All rays of a comparison: from around the data, from just before the surface, and of the picture.
struct Rounds {
  Shots far, near, camera;
};

/// What is sent, and by what the answers are judged.
struct RoundsToShoot {
  std::vector<AimedRay> far, near;
  std::vector<render::Ray> camera;
  std::function<Finding(const render::Ray& ray, const render::Hit& hit)> find;  ///< called from all threads
};

/// Sends the rays through the tracer and judges every answer; progress goes from 300 to 1000.
Rounds shoot(const Tracer& tracer, RoundsToShoot rounds, const Thousandths& progress);

}  // namespace rhoray::tools::validate

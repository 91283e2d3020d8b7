#pragma once

#include <random>
#include <string_view>
#include <vector>

#include "formats/base/affine.h"
#include "tools/validate/geometry.h"

namespace rhoray::tools::validate {

/// Target of a ray.
enum class Aim {
  anything,  ///< from a sphere around the data to a point of the data's box or of the surface's box
  vertex,    ///< from the sphere to a corner of the reference surface
  edge,      ///< to a point on a triangle's edge
  center,    ///< to a triangle's centre
  near,      ///< from just in front of the surface to a point on it
  camera     ///< through a pixel of the picture
};
std::string_view name_of(Aim aim);
inline constexpr std::size_t aim_count = 6;

struct AimedRay {
  render::Ray ray;
  Aim aim = Aim::anything;
};

/// Makes rays whose directions have unit length in the world. The same seed gives the same rays.
class RayMaker {
 public:
  /// @param data_frame  box of all cells
  RayMaker(const Affine& world_from_frame, const Box3& data_frame, std::uint64_t seed);

  double random() { return unit_(generator_); }
  Vec3 point_in(const Box3& box);
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(generator_() % count); }

  struct SurfacePoint {
    Vec3 p;
    std::size_t triangle = 0;
  };
  /// On a random triangle: a corner (Aim::vertex), a point on an edge, or the centre. Needs at
  /// least one triangle.
  SurfacePoint point_of(const Triangles& surface, Aim aim);

  /// From a random point of the sphere, whose radius is the box's diagonal, to a point in the
  /// frame.
  render::Ray toward(const Vec3& target_frame);

 private:
  Affine world_from_frame_, frame_from_world_;
  Vec3 center_world_;
  double radius_world_;
  std::mt19937_64 generator_;
  std::uniform_real_distribution<double> unit_{0, 1};
};

/// Makes `count` rays: two fifths at anything, one fifth each at corners, edges and centres of the
/// surface. Without triangles all are aimed at anything.
std::vector<AimedRay> make_rays(RayMaker& maker, const Box3& data_frame, const Triangles& surface, std::size_t count);

}  // namespace rhoray::tools::validate

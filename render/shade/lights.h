#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "formats/base/affine.h"
#include "render/scene.h"
#include "render/shade/lanes.h"

namespace rhoray::render {

/// The lights of a scene as needed for the hits of one layer.
struct LayerLights {
  struct One {
    Light::Kind kind;
    bool casts_shadows;
    /// Directional: the unit vector towards it, world axes; point: its position, data frame.
    Vec3 place;
    Imath::V3f color;
    /// Half the size of a light that casts shadows. Directional: 1 - the cosine of half its angle;
    /// point: its radius, world units.
    double extent = 0;
    int rays = 1;  ///< per hit, if it casts shadows; spread over the light if it has an extent
  };

  std::vector<One> lights;
  Affine world_from_data;
};

/// Returns the lights in the scene's order, without those of zero intensity.
LayerLights lights_of(const Scene& scene, const Affine& world_from_data);

/// True if the only light is one white light at the eye.
bool is_lit_from_the_eye_alone(const Scene& scene);

/// Direction from a point of the data frame towards a light: a unit vector, world axes.
struct WayToLight {
  Vec3 direction;
  double distance;  ///< world units; infinity for lights without a position
};

/// For a directional light or a point light.
inline WayToLight way_to_light(const LayerLights::One& light, const Affine& world_from_data, const Vec3& place) {
  if (light.kind == Light::Kind::directional) return {light.place, std::numeric_limits<double>::infinity()};
  const Vec3 way = world_from_data.vector(light.place - place);
  const double distance = way.length();
  return {way / distance, distance};
}

/// Height of the cap of the unit sphere that a light with an extent covers, seen from a distance.
/// From inside the light it covers half of the sphere.
inline double cap_height_of(const LayerLights::One& light, double distance) {
  if (light.kind == Light::Kind::directional) return light.extent;
  if (!(light.extent < distance)) return 1;
  const double sine = light.extent / distance;
  return sine * sine / (1 + std::sqrt(1 - sine * sine));
}

/// Finds the directions to the eye from the hits of the rays from `first` on.
RHORAY_INLINE void find_directions_to_eye(const Affine& world_from_data, const RayBatch& rays, std::size_t first,
                                          Directions& to_eye) {
  const Affine world_from = world_from_data;
  const double *dx = rays.direction[0].data() + first, *dy = rays.direction[1].data() + first,
               *dz = rays.direction[2].data() + first;
  for (std::size_t i = 0; i < to_eye.x.size(); ++i) {
    const Vec3 direction = world_from.vector({dx[i], dy[i], dz[i]});
    to_eye.x[i] = static_cast<float>(-direction.x);
    to_eye.y[i] = static_cast<float>(-direction.y);
    to_eye.z[i] = static_cast<float>(-direction.z);
  }
}

/// Finds the directions to a point light; NaN from the light's own position.
RHORAY_INLINE void find_directions_to_point(const Vec3& point, const Affine& world_from_data, const RayBatch& rays,
                                            const HitBatch& hits, std::size_t first, Directions& to_point) {
  const Affine world_from = world_from_data;
  const double* t = hits.t.data() + first;
  double way[3][RayBatch::group_size];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double *origin = rays.origin[axis].data() + first, *direction = rays.direction[axis].data() + first;
    const double to = point[static_cast<int>(axis)];
    for (std::size_t i = 0; i < to_point.x.size(); ++i) way[axis][i] = to - (origin[i] + t[i] * direction[i]);
  }
  for (std::size_t i = 0; i < to_point.x.size(); ++i) {
    const Vec3 world = world_from.vector({way[0][i], way[1][i], way[2][i]});
    const double length = std::sqrt(world.dot(world));
    to_point.x[i] = static_cast<float>(world.x / length);
    to_point.y[i] = static_cast<float>(world.y / length);
    to_point.z[i] = static_cast<float>(world.z / length);
  }
}

RHORAY_INLINE void find_directions_to_light(const LayerLights::One& light, const Affine& world_from_data,
                                            const RayBatch& rays, const HitBatch& hits, std::size_t first,
                                            const Directions& to_eye, Directions& to_light) {
  if (light.kind == Light::Kind::head) {
    to_light = to_eye;
  } else if (light.kind == Light::Kind::point) {
    find_directions_to_point(light.place, world_from_data, rays, hits, first, to_light);
  } else {
    const Imath::V3f direction(light.place);
    to_light.x.fill(direction.x), to_light.y.fill(direction.y), to_light.z.fill(direction.z);
  }
}

}  // namespace rhoray::render

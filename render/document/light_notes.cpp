#include "render/document/light_notes.h"

#include <algorithm>
#include <memory>

#include "formats/base/text.h"
#include "render/ray_caster.h"

namespace rhoray::render {

namespace {

/// The opaque surfaces of a scene, asked by single rays of the world.
class OpaqueSurfaces {
 public:
  OpaqueSurfaces(const Scene& scene, std::span<const Dataset> datasets) {
    for (const Layer& layer : scene.layers) {
      if (layer.mode == Mode::mip || layer.material.opacity < 1) continue;
      const Dataset& dataset = datasets[layer.dataset];
      surfaces_.push_back(
          {world_from_ray_frame(dataset).inverse(), std::make_unique<RayCaster>(dataset, layer.isovalue, Method{})});
    }
  }

  /// Whether one of them is met up to a distance, in lengths of the direction.
  bool meets(const Vec3& from, const Vec3& direction, double distance) const {
    return std::any_of(surfaces_.begin(), surfaces_.end(), [&](const Surface& surface) {
      return !surface.queries
                  ->first_crossing({.origin = surface.frame_from_world.point(from),
                                    .direction = surface.frame_from_world.vector(direction),
                                    .t_max = distance})
                  .is_miss();
    });
  }

 private:
  struct Surface {
    Affine frame_from_world;
    std::unique_ptr<RayCaster> queries;
  };
  std::vector<Surface> surfaces_;
};

Vec3 towards_eye(const Camera& camera, const Vec3& place) {
  return (camera.orthographic ? camera.position - camera.target : camera.position - place);
}

bool is_inside(const Light& light, const Camera& camera, const OpaqueSurfaces& surfaces) {
  constexpr double everywhere = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 27; ++i) {
    const Vec3 direction(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (direction != Vec3(0, 0, 0) && !surfaces.meets(light.place, direction, everywhere)) return false;
  }
  return surfaces.meets(light.place, towards_eye(camera, light.place), camera.orthographic ? everywhere : 1);
}

/// Opposite to the camera, as seen from its target, within 10 degrees.
bool is_behind(const Light& light, const Camera& camera) {
  constexpr double cosine_of_10_degrees = 0.984807753012208;
  const Vec3 to_eye = (camera.position - camera.target).normalized();
  const Vec3 to_light = light.kind == Light::Kind::directional ? light.place : light.place - camera.target;
  return to_light.normalized().dot(to_eye) < -cosine_of_10_degrees;
}

/// The note about a light that shines; empty if there is none.
std::string note_of(const Light& light, const Scene& scene, std::span<const Dataset> datasets) {
  const Camera& camera = scene.camera;
  if (light.kind == Light::Kind::head) return {};
  if (light.size > 0 && !light.casts_shadows) return "has a size but casts no shadows; its size has no effect";
  if (light.kind == Light::Kind::point && is_inside(light, camera, OpaqueSurfaces(scene, datasets)))
    return concat("is inside an opaque surface, at (", light.place.x, ", ", light.place.y, ", ", light.place.z,
                  "); it lights nothing outside");
  if (is_behind(light, camera)) return "is behind the objects; it lights only their rims";
  return {};
}

bool is_lit_by_nothing(const Scene& scene) {
  return std::all_of(scene.lights.begin(), scene.lights.end(),
                     [](const Light& l) { return l.color == Vec3(0, 0, 0); }) &&
         std::any_of(scene.layers.begin(), scene.layers.end(),
                     [](const Layer& layer) { return layer.mode != Mode::mip && layer.material.ambient == 0; });
}

}  // namespace

std::vector<std::string> light_notes(const Scene& scene, std::span<const Dataset> datasets) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const Light& light = scene.lights[i];
    const std::string note =
        light.color == Vec3(0, 0, 0) ? "has no intensity; it is not traced" : note_of(light, scene, datasets);
    if (!note.empty()) notes.push_back(concat("light ", i, " ", note));
  }
  if (is_lit_by_nothing(scene)) notes.push_back("no light has intensity; surfaces without ambient light are black");
  return notes;
}

}  // namespace rhoray::render

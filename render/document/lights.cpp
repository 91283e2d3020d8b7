#include "render/document/lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "formats/base/box_corners.h"
#include "formats/base/error.h"
#include "formats/base/text.h"
#include "render/document/styles.h"
#include "render/ray_caster.h"

namespace rhoray::render {

namespace {

using Type = Light::Kind;

/// The axes of a camera, of length 1.
struct CameraAxes {
  Vec3 right, up, to_eye;

  explicit CameraAxes(const Camera& camera) : to_eye((camera.position - camera.target).normalized()) {
    right = camera.up.cross(to_eye).normalized();
    up = to_eye.cross(right);
  }
};

/// Towards where a camera of these angles would stand, or in the axes of the camera that there is.
/// Multiples of 90 degrees give exact axes.
Vec3 direction_of(const LightSpec& spec, const Camera& camera, const ViewAxes& world) {
  constexpr double radians_per_degree = std::numbers::pi / 180;
  const auto cosine = [](double deg) {
    return std::fmod(std::abs(deg), 180) == 90 ? 0.0 : std::cos(deg * radians_per_degree);
  };
  const auto sine = [&](double deg) { return cosine(deg - 90); };
  const double azimuth = spec.azimuth_deg.value_or(0), elevation = spec.elevation_deg.value_or(0);
  const double right = cosine(elevation) * sine(azimuth), front = cosine(elevation) * cosine(azimuth),
               up = sine(elevation);
  if (spec.from != "camera") return right * world.right + (0 - front) * world.ahead + up * world.up;
  const CameraAxes axes(camera);
  return right * axes.right + up * axes.up + front * axes.to_eye;
}

Vec3 place_of(const LightSpec& spec, const Camera& camera, const ViewAxes& axes, const Place& place) {
  if (spec.type == Type::head) return {0, 0, 0};
  if (spec.type == Type::point) return spec.position.value();  // a document's light must have it
  const bool has_angles = spec.azimuth_deg || spec.elevation_deg;
  if (!spec.direction && !has_angles)
    throw Error(ErrorCode::invalid,
                concat(place.text(), ": has no direction; expected \"direction\", or \"azimuth\" and \"elevation\""));
  if (spec.direction && (has_angles || !spec.from.empty()))
    throw Error(ErrorCode::invalid, concat(place.at("direction").text(), ": \"",
                                           spec.azimuth_deg     ? "azimuth"
                                           : spec.elevation_deg ? "elevation"
                                                                : "from",
                                           "\" is also given; expected only one of the two"));
  if (spec.direction && *spec.direction == Vec3(0, 0, 0))
    throw Error(ErrorCode::invalid, concat(place.at("direction").text(), ": found [0,0,0]; expected a direction"));
  return spec.direction ? *spec.direction : direction_of(spec, camera, axes);
}

/// How far from where rays start a box begins and ends; not below 0.
Interval<double> distances(const Box3& box, const Camera& camera) {
  Interval<double> range;
  const Vec3 forward = (camera.target - camera.position).normalized();
  for (const Vec3& corner : corners_of(box)) {
    const Vec3 way = corner - camera.position;
    range.include(std::max(camera.orthographic ? way.dot(forward) : way.length(), 0.0));
  }
  if (!camera.orthographic) {
    Vec3 nearest;
    for (int axis = 0; axis < 3; ++axis)
      nearest[axis] = std::clamp(camera.position[axis], box.min[axis], box.max[axis]);
    range.include((nearest - camera.position).length());
  }
  return range;
}

/// Colours of a specification are at most 1. Brighter lights use an intensity that is a power of
/// two, so that no digit is lost.
LightSpec spec_of_light(const Light& light) {
  LightSpec spec{.type = light.kind};
  const double brightest = std::max({light.color.x, light.color.y, light.color.z});
  const double intensity = brightest > 1 ? std::exp2(std::ceil(std::log2(brightest))) : 1;
  spec.color = Color{light.color / intensity};
  spec.intensity = intensity;
  if (light.kind == Type::directional) spec.direction = light.place;
  if (light.kind == Type::point) spec.position = light.place;
  if (light.kind != Type::head) spec.shadows = light.casts_shadows;
  if (light.size > 0) {
    (light.kind == Type::point ? spec.radius : spec.angular_diameter_deg) = light.size;
    spec.samples = light.samples;
  }
  return spec;
}

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

std::vector<Light> choose_lights(const SceneSpec& scene_spec, const Camera& camera, const ViewAxes& axes) {
  const Place place = Place{scene_spec.document, {}}.at("lights");
  std::vector<Light> lights;
  for (const LightSpec& spec : scene_spec.lights ? *scene_spec.lights : style_named(scene_spec.style).lights) {
    Light light{.kind = spec.type};
    light.place = place_of(spec, camera, axes, place.at(lights.size()));
    light.color = (spec.color ? spec.color->linear : Vec3(1, 1, 1)) * spec.intensity.value_or(1);
    light.casts_shadows = spec.shadows.value_or(false);
    light.size = (spec.type == Type::point ? spec.radius : spec.angular_diameter_deg).value_or(0);
    light.samples = spec.samples.value_or(light.samples);
    lights.push_back(light);
  }
  return lights;
}

Occlusion choose_occlusion(const SceneSpec& scene_spec, const ShownBox& shown) {
  Occlusion occlusion;
  const std::optional<OcclusionSpec>& own = scene_spec.effects.occlusion;
  const std::optional<OcclusionSpec>& spec = own ? own : style_named(scene_spec.style).occlusion;
  if (!spec) return occlusion;
  constexpr double share = 0.1;
  occlusion.samples = spec->samples.value_or(occlusion.samples);
  occlusion.radius = spec->radius ? *spec->radius : share * shown().size().length();
  return occlusion;
}

std::optional<Fog> choose_fog(const std::optional<FogSpec>& spec, const Camera& camera, const Vec3& background,
                              const ShownBox& shown) {
  if (!spec) return std::nullopt;
  Fog fog{.color = spec->color ? spec->color->linear : background};
  if (spec->range) {
    fog.range = *spec->range;
    return fog;
  }
  const Interval<double> reach = distances(shown(), camera);
  if (!(reach.lo < reach.hi)) return std::nullopt;
  fog.range = {reach.lo, reach.hi + (reach.hi - reach.lo)};
  return fog;
}

bool has_light_of(const Scene& scene, const std::string& style) {
  const std::vector<Light> lights = choose_lights({.style = style}, scene.camera, {});
  const bool has_occlusion = style_named(style).occlusion.has_value();
  return lights == scene.lights && (!has_occlusion || scene.occlusion.radius > 0);
}

std::vector<LightSpec> light_specs(const std::vector<Light>& lights) {
  std::vector<LightSpec> specs;
  for (const Light& light : lights) specs.push_back(spec_of_light(light));
  return specs;
}

EffectsSpec effects_spec(const Scene& scene) {
  EffectsSpec effects;
  if (scene.occlusion.radius > 0)
    effects.occlusion = OcclusionSpec{.samples = scene.occlusion.samples, .radius = scene.occlusion.radius};
  if (scene.fog) effects.fog = FogSpec{.color = Color{scene.fog->color}, .range = scene.fog->range};
  return effects;
}

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

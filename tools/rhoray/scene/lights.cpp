#include "tools/rhoray/scene/lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "formats/base/trouble.h"

namespace rhoray::tools {

namespace {

using Type = render::Light::Kind;

/// The axes of a camera, of length 1.
struct CameraAxes {
  Vec3 right, up, to_eye;

  explicit CameraAxes(const render::Camera& camera) : to_eye((camera.position - camera.target).normalized()) {
    right = camera.up.cross(to_eye).normalized();
    up = to_eye.cross(right);
  }
};

/// Towards where a camera of these angles would stand, or in the axes of the camera that there is. Multiples of 90
/// degrees give exact axes.
Vec3 direction_of(const LightWish& wish, const render::Camera& camera) {
  constexpr double radians_per_degree = std::numbers::pi / 180;
  const auto cosine = [](double deg) {
    return std::fmod(std::abs(deg), 180) == 90 ? 0.0 : std::cos(deg * radians_per_degree);
  };
  const auto sine = [&](double deg) { return cosine(deg - 90); };
  const double azimuth = wish.azimuth_deg.value_or(0), elevation = wish.elevation_deg.value_or(0);
  const double right = cosine(elevation) * sine(azimuth), front = cosine(elevation) * cosine(azimuth),
               up = sine(elevation);
  if (wish.from != "camera") return Vec3(right, 0 - front, up);
  const CameraAxes axes(camera);
  return right * axes.right + up * axes.up + front * axes.to_eye;
}

Vec3 place_of(const LightWish& wish, const render::Camera& camera, const Place& place) {
  if (wish.type == Type::head) return {0, 0, 0};
  if (wish.type == Type::point) return wish.position.value();  // a document's light must have it
  const bool has_angles = wish.azimuth_deg || wish.elevation_deg;
  if (!wish.direction && !has_angles)
    throw Error(Trouble::invalid,
                concat(place.text(), ": has no direction; expected \"direction\", or \"azimuth\" and \"elevation\""));
  if (wish.direction && (has_angles || !wish.from.empty()))
    throw Error(Trouble::invalid, concat(place.at("direction").text(), ": \"",
                                         wish.azimuth_deg     ? "azimuth"
                                         : wish.elevation_deg ? "elevation"
                                                              : "from",
                                         "\" is there too; expected one of the two"));
  if (wish.direction && *wish.direction == Vec3(0, 0, 0))
    throw Error(Trouble::invalid, concat(place.at("direction").text(), ": found [0,0,0]; expected a direction"));
  return wish.direction ? *wish.direction : direction_of(wish, camera);
}

std::array<Vec3, 8> corners(const Box3& box) {
  std::array<Vec3, 8> all;
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = {(i & 1) != 0 ? box.max.x : box.min.x, (i & 2) != 0 ? box.max.y : box.min.y,
              (i & 4) != 0 ? box.max.z : box.min.z};
  return all;
}

/// How far from where rays start a box begins and ends; not below 0.
Interval<double> distances(const Box3& box, const render::Camera& camera) {
  Interval<double> range;
  const Vec3 forward = (camera.target - camera.position).normalized();
  for (const Vec3& corner : corners(box)) {
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

/// Colours of a wish are at most 1: more is said by an intensity, a power of two, so that no digit is lost.
LightWish wish_of(const render::Light& light) {
  LightWish wish{.type = light.kind};
  const double brightest = std::max({light.color.x, light.color.y, light.color.z});
  const double intensity = brightest > 1 ? std::exp2(std::ceil(std::log2(brightest))) : 1;
  wish.color = Color{light.color / intensity};
  wish.intensity = intensity;
  if (light.kind == Type::directional) wish.direction = light.place;
  if (light.kind == Type::point) wish.position = light.place;
  if (light.kind != Type::head) wish.shadows = light.casts_shadows;
  if (light.size > 0) {
    (light.kind == Type::point ? wish.radius : wish.angular_diameter_deg) = light.size;
    wish.samples = light.samples;
  }
  return wish;
}

bool is_white_head(const render::Light& light) {
  return light.kind == Type::head && light.color == Vec3(1, 1, 1);
}

}  // namespace

std::vector<LightWish> key_and_fill(const std::optional<Angles>& towards, bool shadows,
                                    const std::optional<double>& angular_diameter_deg) {
  LightWish key{.type = Type::directional, .intensity = 0.8, .shadows = shadows};
  key.angular_diameter_deg = angular_diameter_deg;
  key.azimuth_deg = towards ? towards->azimuth_deg : -40;
  key.elevation_deg = towards ? towards->elevation_deg : 40;
  if (!towards) key.from = "camera";
  return {key, {.type = Type::head, .intensity = 0.35}};
}

std::vector<render::Light> choose_lights(const SceneWishes& wishes, const render::Camera& camera) {
  if (!wishes.lights) return render::Scene{}.lights;
  const Place place = Place{wishes.document, {}}.at("lights");
  std::vector<render::Light> lights;
  for (const LightWish& wish : *wishes.lights) {
    render::Light light{.kind = wish.type};
    light.place = place_of(wish, camera, place.at(lights.size()));
    light.color = (wish.color ? wish.color->linear : Vec3(1, 1, 1)) * wish.intensity.value_or(1);
    light.casts_shadows = wish.shadows.value_or(false);
    light.size = (wish.type == Type::point ? wish.radius : wish.angular_diameter_deg).value_or(0);
    light.samples = wish.samples.value_or(light.samples);
    lights.push_back(light);
  }
  return lights;
}

render::Occlusion choose_occlusion(const std::optional<OcclusionWish>& wish, const ShownBox& shown) {
  render::Occlusion occlusion;
  if (!wish) return occlusion;
  constexpr double share = 0.1;
  occlusion.samples = wish->samples.value_or(occlusion.samples);
  occlusion.radius = wish->radius ? *wish->radius : share * shown().size().length();
  return occlusion;
}

std::optional<render::Fog> choose_fog(const std::optional<FogWish>& wish, const render::Camera& camera,
                                      const Vec3& background, const ShownBox& shown) {
  if (!wish) return std::nullopt;
  render::Fog fog{.color = wish->color ? wish->color->linear : background};
  if (wish->range) {
    fog.range = *wish->range;
    return fog;
  }
  const Interval<double> reach = distances(shown(), camera);
  if (!(reach.lo < reach.hi)) return std::nullopt;
  fog.range = {reach.lo, reach.hi + (reach.hi - reach.lo)};
  return fog;
}

std::optional<std::vector<LightWish>> light_wishes(const std::vector<render::Light>& lights) {
  if (lights.size() == 1 && is_white_head(lights[0])) return std::nullopt;
  std::vector<LightWish> wishes;
  for (const render::Light& light : lights) wishes.push_back(wish_of(light));
  return wishes;
}

EffectsWish effect_wishes(const render::Scene& scene) {
  EffectsWish effects;
  if (scene.occlusion.radius > 0)
    effects.occlusion = OcclusionWish{.samples = scene.occlusion.samples, .radius = scene.occlusion.radius};
  if (scene.fog) effects.fog = FogWish{.color = Color{scene.fog->color}, .range = scene.fog->range};
  return effects;
}

}  // namespace rhoray::tools

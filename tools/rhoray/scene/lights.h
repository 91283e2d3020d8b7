#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "formats/base/vector.h"
#include "render/scene.h"
#include "tools/rhoray/scene/place.h"
#include "tools/rhoray/scene/scene_spec.h"

namespace rhoray::tools {

// Lights, fog and ambient occlusion, resolved when the camera is known.

/// Position of a camera by angles, in degrees.
struct Angles {
  double azimuth_deg = 0, elevation_deg = 0;
};

/// The lights of the options --shadows, --light and --light-size: a key light, and a weaker one at
/// the camera that fills its shadows.
/// @param towards  the key light, in the world; nothing: from the upper left of the camera
std::vector<LightSpec> key_and_fill(const std::optional<Angles>& towards, bool shadows,
                                    const std::optional<double>& angular_diameter_deg);

/// One white light at the camera by default. Refuses a directional light without a direction or
/// with two (ErrorCode::invalid).
std::vector<render::Light> choose_lights(const SceneSpec& scene_spec, const render::Camera& camera);

/// The box around what is shown; computed only if a choice depends on it.
using ShownBox = std::function<Box3()>;

/// No occlusion if none is requested, or if the shown data have no extent.
render::Occlusion choose_occlusion(const std::optional<OcclusionSpec>& spec, const ShownBox& shown);

std::optional<render::Fog> choose_fog(const std::optional<FogSpec>& spec, const render::Camera& camera,
                                      const Vec3& background, const ShownBox& shown);

/// The specifications of lights and effects; nothing if they are the defaults.
std::optional<std::vector<LightSpec>> light_specs(const std::vector<render::Light>& lights);
EffectsSpec effects_spec(const render::Scene& scene);

}  // namespace rhoray::tools

#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/vector.h"
#include "render/document/values.h"
#include "render/load.h"
#include "render/scene.h"
#include "render/scene_spec.h"

namespace rhoray::render {

// Lights, fog and ambient occlusion, resolved when the camera is known.

/// The style's lights by default. Refuses a directional light without a direction or with two
/// (ErrorCode::invalid).
/// @param axes  from which angles of lights count that do not move with the camera
std::vector<Light> choose_lights(const SceneSpec& scene_spec, const Camera& camera, const ViewAxes& axes);

/// The box around what is shown; computed only if a choice depends on it.
using ShownBox = std::function<Box3()>;

/// The style's occlusion by default. None if none is requested, or if the shown data have no
/// extent.
Occlusion choose_occlusion(const SceneSpec& scene_spec, const ShownBox& shown);

std::optional<Fog> choose_fog(const std::optional<FogSpec>& spec, const Camera& camera, const Vec3& background,
                              const ShownBox& shown);

/// Whether a style has the lights of a scene, and no ambient occlusion that the scene has not.
bool has_light_of(const Scene& scene, const std::string& style);
/// The specifications of lights and effects.
std::vector<LightSpec> light_specs(const std::vector<Light>& lights);
EffectsSpec effects_spec(const Scene& scene);

/// Notes about lights that are probably a mistake, one sentence each: lights without intensity,
/// inside opaque surfaces or behind everything visible, lights with a size that cast no shadows,
/// and surfaces without any light.
///
/// A light counts as inside if each of 26 rays from it hits an opaque surface, and the ray to the
/// camera too. This holds for any field, whichever side is solid, and for triangles. At the end of
/// the data, or where a surface has a gap, a light inside may not be noticed.
std::vector<std::string> light_notes(const Scene& scene, std::span<const Dataset> datasets);

}  // namespace rhoray::render

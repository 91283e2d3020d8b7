#pragma once

#include <cstddef>
#include <optional>

#include "render/document.h"
#include "render/document/values.h"

namespace rhoray::render {

/// Returns the name that a refusal uses: the option for a scene of the command line, the quoted key
/// for a document.
std::string given_as(const SceneSpec& scene_spec, std::string_view option, std::string_view key);

/// The place of a layer in the document.
Place layer_place(const SceneSpec& scene_spec, std::size_t layer);

/// The data that a layer names. Refuses a name that is not there (ErrorCode::invalid).
const DataSpec& data_of(const SceneSpec& scene_spec, std::size_t layer);

/// Returns the index in the plan of the dataset that a layer names. Opens the dataset if the plan
/// does not hold it yet, and adds its notes to the plan.
std::size_t dataset_of(const SceneSpec& scene_spec, std::size_t layer, const OpenData& open, ResolvedScene& plan);

/// Returns the texture of a layer, if it names one. Opens the texture if the plan does not hold it
/// yet.
std::optional<Texture> texture_of(const SceneSpec& scene_spec, std::size_t layer, const OpenColors& open_colors,
                                  ResolvedScene& plan);

/// Notes textures that do not overlap the surface they should cover.
void note_textures_elsewhere(ResolvedScene& plan);

/// Notes files that do not say in which space they lie, if other files do.
void note_unknown_spaces(ResolvedScene& plan);

}  // namespace rhoray::render

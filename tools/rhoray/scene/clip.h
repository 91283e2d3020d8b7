#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/rhoray/option_values.h"
#include "tools/rhoray/scene/resolved_scene.h"
#include "tools/rhoray/scene/scene_spec.h"
#include "tools/rhoray/scene/values.h"

namespace rhoray::tools {

// The clip region: what may be said about it in documents and on the command line, and what it means.

const std::vector<Row<ClipSpec>>& clip_rows();
const std::vector<Row<render::HalfSpace>>& half_space_rows();

/// A vector that is not 0.
ValueKind<Vec3> direction_value();
/// px,py,pz,nx,ny,nz; refuses others (ErrorCode::usage).
render::HalfSpace read_half_space(const std::string& text);

/// The rows of the options that say the same.
std::vector<Option> clip_options(std::optional<ClipSpec>& spec);

/// The region that is wished for. Refuses one that has neither a box nor planes.
/// @param place  of the wish in its document; of a command line without a document
std::optional<render::Clip> choose_clip(const std::optional<ClipSpec>& spec, const Place& place);
/// A wish that says the same.
std::optional<ClipSpec> clip_spec(const std::optional<render::Clip>& clip);
/// The options that say the same.
std::vector<std::string> clip_words(const ClipSpec& spec);

/// Around what a layer may show before anything is clipped away; empty for a slice that passes its data by.
Box3 bounds_of(const render::Layer& layer, const ResolvedScene& plan);

/// Of each slice that passes its data by, and of each layer of which the region leaves nothing, a line.
/// @param place  of the region in its document; of a command line without a document
std::vector<std::string> clip_notes(const ResolvedScene& plan, const Place& place);

}  // namespace rhoray::tools

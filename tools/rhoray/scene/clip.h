#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/rhoray/option_values.h"
#include "tools/rhoray/scene/resolved_scene.h"
#include "tools/rhoray/scene/scene_spec.h"
#include "tools/rhoray/scene/values.h"

namespace rhoray::tools {

// The clip region: its keys in documents, its options, and the region they define.

const std::vector<Row<ClipSpec>>& clip_rows();
const std::vector<Row<render::HalfSpace>>& half_space_rows();

/// A vector that is not 0.
ValueKind<Vec3> direction_value();
/// px,py,pz,nx,ny,nz; refuses others (ErrorCode::usage).
render::HalfSpace read_half_space(const std::string& text);

/// The options that set the same.
std::vector<Option> clip_options(std::optional<ClipSpec>& spec);

/// The requested region. Refuses one that has neither a box nor planes.
/// @param place  of the wish in its document; of a command line without a document
std::optional<render::Clip> choose_clip(const std::optional<ClipSpec>& spec, const Place& place);
/// The specification of a region.
std::optional<ClipSpec> clip_spec(const std::optional<render::Clip>& clip);
/// The command-line options of a region.
std::vector<std::string> clip_words(const ClipSpec& spec);

/// The box around what a layer may show without clipping; empty for a slice outside the data.
Box3 bounds_of(const render::Layer& layer, const ResolvedScene& plan);

/// One note for each slice outside its data and for each layer that is clipped away completely.
/// @param place  of the region in its document; of a command line without a document
std::vector<std::string> clip_notes(const ResolvedScene& plan, const Place& place);

}  // namespace rhoray::tools

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/document/values.h"
#include "render/resolved_scene.h"
#include "render/scene_spec.h"

namespace rhoray::render {

// The clip region: its keys in documents and the region they define.

const std::vector<Row<ClipSpec>>& clip_rows();
const std::vector<Row<HalfSpace>>& half_space_rows();

/// The requested region. Refuses one that has neither a box nor planes.
/// @param place  of the region in its document; of a command line without a document
std::optional<Clip> choose_clip(const std::optional<ClipSpec>& spec, const Place& place);
/// The specification of a region.
std::optional<ClipSpec> clip_spec(const std::optional<Clip>& clip);
/// The box around what a layer may show without clipping; empty for a slice outside the data.
Box3 bounds_of(const Layer& layer, const ResolvedScene& plan);

/// One note for each slice outside its data and for each layer that is clipped away completely.
/// @param place  of the region in its document; of a command line without a document
std::vector<std::string> clip_notes(const ResolvedScene& plan, const Place& place);

}  // namespace rhoray::render

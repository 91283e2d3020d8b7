#pragma once

#include <string>
#include <vector>

#include "render/load.h"
#include "tools/rhoray/option_values.h"
#include "tools/rhoray/scene/place.h"
#include "tools/rhoray/scene/scene_spec.h"
#include "tools/rhoray/scene/values.h"

namespace rhoray::tools {

// Slices, planes that show a field: their keys in documents, their option, and how they are
// resolved.

/// The keys of a slice, in addition to those of every layer.
std::vector<Row<LayerSpec>> slice_rows();

/// The row of the option that adds slices.
Option slice_option(std::vector<LayerSpec>& slices);

/// Plane, colours and opacity of a slice through this volume. Refuses one that has no plane or two,
/// and a field without a finite value: of a document with the place (ErrorCode::invalid).
/// @param place  of the wish; of a command line without a document
void choose_slice(const LayerSpec& spec, const render::Volume& volume, const Place& place, render::Layer& layer);

/// Writes the slice of a layer into a specification.
void say_slice(const render::Layer& layer, LayerSpec& spec);

}  // namespace rhoray::tools

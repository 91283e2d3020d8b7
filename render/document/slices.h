#pragma once

#include <string>
#include <vector>

#include "render/document/values.h"
#include "render/load.h"
#include "render/scene_spec.h"

namespace rhoray::render {

// Slices, planes that show a field: their keys in documents and how they are resolved.

/// The keys of the scale of a layer's colours.
std::vector<Row<LayerSpec>> scale_rows();

/// The keys of a slice, in addition to those of every layer.
std::vector<Row<LayerSpec>> slice_rows();

/// Plane, colours and opacity of a slice through this dataset. Refuses one that has no plane or
/// two, and a field without a finite value: of a document with the place (ErrorCode::invalid).
/// @param place  of the slice in its document; of a command line without a document
void choose_slice(const LayerSpec& spec, const Dataset& dataset, const Place& place, Layer& layer);

/// Writes the slice of a layer into a specification.
void say_slice(const Layer& layer, LayerSpec& spec);

/// "z = 40", or "through (1, 2, 3) with normal (0, 1, 1)".
std::string text_of_slice(const HalfSpace& plane);

/// "the slice z = 999 lies outside the data (0 to 74)"; without the range for other normals.
std::string text_of_slice_outside(const HalfSpace& plane, const Box3& bounds);

}  // namespace rhoray::render

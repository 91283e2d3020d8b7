#pragma once

#include <string>
#include <vector>

#include "render/document/styles.h"
#include "render/document/values.h"
#include "render/load.h"
#include "render/scene.h"
#include "render/scene_spec.h"

namespace rhoray::render {

/// The scale of a layer's colours.
ColorScale color_scale(const LayerSpec& spec);
/// Writes a scale into a specification.
void say_scale(const ColorScale& scale, LayerSpec& spec);

/// The range of a layer's colours: the one that it names, or `otherwise`. A logarithmic scale needs
/// a range above 0: it refuses another one, and replaces an end of `otherwise` at 0 or below.
/// @param layer  as for choose_material
Interval<double> color_range(const LayerSpec& spec, const formats::FieldSummary& field,
                             const Interval<double>& otherwise, const Place& layer);

/// Colours of a field by a layer's map, range and scale. Where they are not given: viridis over the
/// field's range, or for floating-point fields of both signs coolwarm with 0 in its middle.
/// @param layer  as for choose_material
FieldColors field_colors(const LayerSpec& spec, const formats::FieldSummary& field, const Place& layer);

/// Colours, light, normals and opacity of an isosurface of this dataset, or of its triangles.
/// Refuses normals that the dataset has not, colours by a field that is not there, and a range or
/// colour map or scale without such a field: of a document with the place (ErrorCode::invalid), of
/// a command line with the option (ErrorCode::usage).
/// @param layer  its place in its document; of a command line without a document
Material choose_material(const LayerSpec& spec, const Style& style, const Dataset& dataset, const Place& layer);

/// The same for the boundary of a mesh. Without a colour, a texture or a field of its own it is
/// coloured by the dataset's field, if that varies. A field that packing made from the mesh's shape
/// colours nothing.
Material choose_boundary_material(LayerSpec spec, const Style& style, const Dataset& boundary, const Place& layer);

}  // namespace rhoray::render

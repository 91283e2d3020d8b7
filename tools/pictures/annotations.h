#pragma once

#include "render/resolved_scene.h"
#include "tools/pictures/annotate.h"

namespace rhoray::tools {

/// The annotations drawn over the picture.
/// @param heat  of a heat map: the numbers of its first and its last colour
Annotations annotations_of(const render::ResolvedScene& plan, const Interval<double>& heat);

/// The space of all layers; unknown if a file does not name its own.
formats::Space space_of(const render::ResolvedScene& plan);

/// True for a scene with annotations that contain text. They need a font and the module for
/// pictures (tools/pictures/pictures.h).
bool has_texts(const render::ResolvedScene& plan);

/// The channels of the picture that draw_annotations reads.
render::ChannelSet channels_of_annotations(const render::ResolvedScene& plan);

/// Draws the annotations over a finished picture; nothing for a scene without annotations.
void draw_annotations(const render::ResolvedScene& plan, const Interval<double>& heat, render::Framebuffer& picture);

}  // namespace rhoray::tools

#pragma once

#include "render/resolved_scene.h"
#include "tools/pictures/annotate.h"

namespace rhoray::tools {

/// The annotations drawn over the picture.
/// @param heat  of a heat map: the numbers of its first and its last colour
Annotations annotations_of(const render::ResolvedScene& plan, const Interval<double>& heat);

}  // namespace rhoray::tools

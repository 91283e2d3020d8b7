#pragma once

#include "tools/pictures/annotate.h"
#include "tools/rhoray/scene/resolved_scene.h"

namespace rhoray::tools {

/// Whether colours of the picture represent values: of a field, a projection or a heat map.
bool shows_values(const ResolvedScene& plan);

/// The annotations drawn over the picture.
/// @param heat  of a heat map: the numbers of its first and its last colour
Annotations annotations_of(const ResolvedScene& plan, const Interval<double>& heat);

}  // namespace rhoray::tools

#pragma once

#include "preprocess/repair_surface.h"

namespace rhoray::preprocess::repair {

/// What repair_surface promises, in this process: CGAL may end it.
RepairedSurface mend(const NeutralSurface& surface, const RepairOptions& options);

}  // namespace rhoray::preprocess::repair

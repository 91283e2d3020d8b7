#pragma once

#include <optional>

#include "preprocess/workers/repair/mesh.h"

namespace rhoray::preprocess::repair {

/// Runs a step in a copy of this process, so that a crash in it ends only the copy. CGAL 5.5's
/// experimental functions crash on some facets that touch each other in a point or overlap. The
/// CPU time of the copy counts against the limit of this process, which ends when the limit is
/// reached. Throws std::bad_alloc when the copy runs out of memory.
/// @return  the result of the step; nothing when it gave up or crashed
std::optional<TriangleMesh> run_apart(const TriangleMesh& mesh, std::optional<TriangleMesh> (*step)(TriangleMesh));

}  // namespace rhoray::preprocess::repair

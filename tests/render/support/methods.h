#pragma once

#include "render/method.h"

namespace rhoray::tests {

/// The paper's rule for the largest value: only on the faces of cells.
inline constexpr render::Method face_rule{.algorithm = render::Method::Algorithm::paper};

}  // namespace rhoray::tests

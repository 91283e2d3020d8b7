#pragma once

#include "render/method.h"

namespace rhoray::tests {

/// The paper's rule for the largest value: on the faces of cells.
inline constexpr render::Method face_rule{.way = render::Method::Way::paper};

}  // namespace rhoray::tests

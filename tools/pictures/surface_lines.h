#pragma once

#include <array>
#include <vector>

#include "formats/base/vector.h"
#include "tools/pictures/canvas.h"
#include "tools/pictures/visibility.h"

namespace rhoray::tools {

/// Lines that lie in surfaces.
struct SurfaceLines {
  std::vector<std::array<Vec3, 2>> lines;  ///< their ends, world axes
  Vec3 color;                              ///< linear
};

/// Draws lines where nothing hides them.
/// @param width  pixels
void draw_surface_lines(const SurfaceLines& lines, const Projection& projection, const Visibility& visibility,
                        double width, Canvas& canvas);

}  // namespace rhoray::tools

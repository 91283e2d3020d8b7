#pragma once

#include "render/framebuffer.h"
#include "tools/pictures/projection.h"

namespace rhoray::tools {

/// Decides by a picture's depths where a line of the world is hidden by what is nearer.
class Visibility {
 public:
  /// @param picture  has depths
  Visibility(const Projection& projection, const render::Framebuffer& picture)
      : projection_(projection), picture_(picture) {}

  /// For a position on a line between two others, at a pixel that the line covers. A line in a
  /// surface is visible.
  /// @param share  of the way in the picture
  bool is_before_surfaces(int x, int y, const Seen& from, const Seen& to, double share) const;

 private:
  const Projection& projection_;
  const render::Framebuffer& picture_;
};

}  // namespace rhoray::tools

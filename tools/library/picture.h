#pragma once

#include "render/framebuffer.h"
#include "rhoray/picture.h"

namespace rhoray::v0_1 {

class Picture::Implementation {
 public:
  Size size{0, 0};
  Rect window{};
  render::Framebuffer pixels;  ///< of the window
};

}  // namespace rhoray::v0_1

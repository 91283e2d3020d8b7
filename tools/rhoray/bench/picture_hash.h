#pragma once

#include <string>

#include "render/framebuffer.h"

namespace rhoray::tools {

/// Of the colours, as the framebuffer holds them; 16 hexadecimal digits (XXH3).
std::string picture_hash(const render::Framebuffer& picture);

}  // namespace rhoray::tools

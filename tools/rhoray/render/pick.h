#pragma once

#include <string>
#include <vector>

#include "render/framebuffer.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

/// A pixel, counted from the upper left corner.
struct PixelPlace {
  int x = 0, y = 0;
};

/// Reads X,Y or several of them, X,Y:X,Y (ErrorCode::usage).
void read_value(const std::string& text, std::vector<PixelPlace>& out);

/// What a pixel shows, as kept by the channels depth, cell and value. Refuses a pixel outside the
/// picture.
Json picked(const render::Framebuffer& framebuffer, const PixelPlace& pixel);
std::string picked_text(const Json& pick, const std::string& length_unit);

}  // namespace rhoray::tools

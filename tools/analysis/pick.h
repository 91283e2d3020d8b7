#pragma once

#include <string>
#include <vector>

#include "formats/base/json.h"
#include "render/document.h"
#include "render/framebuffer.h"

namespace rhoray::tools {

/// A pixel, counted from the upper left corner.
struct PixelPlace {
  int x = 0, y = 0;
};

/// Reads X,Y or several of them, X,Y:X,Y, and adds them (ErrorCode::usage).
void read_value(const std::string& text, std::vector<PixelPlace>& out);

/// The channels that tell what a pixel shows: depth, cell, value, and where all methods prove it,
/// the error.
render::ChannelSet channels_of_picks(const render::Scene& scene);

/// Reads the hit of a pixel from these channels, and adds its position in the world. Refuses a
/// pixel outside the picture.
///
/// "error" is the proven bound of the depth, and thus of the position; "value_error" is the proven
/// bound of a projection's value. Each is there only if the methods of all layers prove it.
Json picked(const render::ResolvedScene& plan, const render::Framebuffer& framebuffer, const PixelPlace& pixel);
std::string picked_text(const Json& pick);

/// The straight line between two picked positions. "distance" is null where one shows nothing, and
/// "error" where one has no proven error.
Json picked_distance(const Json& from, const Json& to);
std::string picked_distance_text(const Json& from, const Json& to);

}  // namespace rhoray::tools

#pragma once

#include "formats/base/interval.h"
#include "render/framebuffer.h"

namespace rhoray::render {

/// Channels about the rendering itself that a picture can show instead of colours.
enum class DebugChannel { error, roots, iterations, cost };

/// Returns the channel that a page is drawn from.
ChannelSet channel_of(DebugChannel page);

/// Replaces the picture's colours by a heat map of one of its channels: dark violet for the
/// smallest number in the picture, yellow for the largest (five colours of viridis). The scale is
/// linear; errors use a logarithmic scale. Pixels without a number, and those with an error of
/// zero, are grey.
/// @param picture  has that channel
/// @return  the smallest and the largest number shown; empty when there is none
Interval<double> draw_heat_map(DebugChannel page, Framebuffer& picture);

}  // namespace rhoray::render

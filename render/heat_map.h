#pragma once

#include "formats/base/interval.h"
#include "render/framebuffer.h"

namespace rhoray::render {

/// What a picture may show of its own making instead of colours.
enum class DebugChannel { error, roots, iterations, cost };

/// The channel that a page is drawn from.
ChannelSet channel_of(DebugChannel page);

/// Replaces the picture's colours by a heat map of a channel that it holds: from dark violet for the smallest number in
/// the picture to yellow for the largest (five colours of viridis), evenly, errors by their logarithm. Pixels without a
/// number, and an error of zero, are grey.
/// @return  the smallest and the largest number shown; empty when there is none
Interval<double> draw_heat_map(DebugChannel page, Framebuffer& picture);

}  // namespace rhoray::render

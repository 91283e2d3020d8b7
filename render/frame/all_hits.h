#pragma once

#include "render/frame/frame.h"

/// Composites transparent surfaces in one pass: one walk along a ray finds its crossings with all
/// of them. They are then shown in their order.
namespace rhoray::render {

/// Puts the transparent layers into groups whose crossings one kernel finds, if every one of them
/// has such a kernel. Call it after their datasets are prepared.
void choose_all_hits(const FrameOptions& options, Frame& frame);

/// Finds the crossings of the tile's rays with the surfaces of all groups. The first ones become
/// the layers' hits.
void find_all_hits(const Frame& frame, Worker& worker);

/// Shows the same surfaces in the same order as peel_clear_layers. Colours are added exactly, so
/// they do not depend on the order of layers. They may differ from those of peel_clear_layers in
/// the last bits. Positions of crossings may differ in the last bits, too: a later crossing in the
/// same block of cells is computed from where the ray entered the block.
void composite_all_hits(const Frame& frame, Worker& worker);

}  // namespace rhoray::render

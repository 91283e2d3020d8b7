#pragma once

#include "render/frame/frame.h"

/// Clear surfaces in one pass: the crossings of a ray with all of them are found by one walk along it, then shown in
/// their order.
namespace rhoray::render {

/// Puts the clear layers into groups of which a kernel finds all crossings, if that can be said of every one of them.
/// To be asked when their volumes are prepared.
void choose_all_hits(const FrameOptions& options, Frame& frame);

/// Finds the crossings of the tile's rays with the surfaces of all groups; layers' own hits are their first ones.
void find_all_hits(const Frame& frame, Worker& worker);

/// As peel_clear_layers: the same surfaces in the same order. Colours are added up exactly, so that they do not depend
/// on the order of layers, and may differ from those in the last bits. So may a crossing's place: one behind another in
/// the same block of cells is found from where the ray entered the block.
void composite_all_hits(const Frame& frame, Worker& worker);

}  // namespace rhoray::render

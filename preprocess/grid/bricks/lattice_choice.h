#pragma once

#include <optional>
#include <string>

#include "formats/base/affine.h"
#include "formats/brick_layout.h"

namespace rhoray::preprocess {

/// The layout of bricks with this many samples per axis, 2 to 64, in superbricks of at most this
/// many bricks per axis, 1 to 64. Refuses other numbers (ErrorCode::usage).
formats::BrickLayout bricked_layout(const Index3& sample_count, std::int64_t brick_edge,
                                    std::int64_t largest_superbrick);

/// Refuses a map that has no inverse.
void check_frame(const Affine& world_from_grid, const std::string& source_name);

}  // namespace rhoray::preprocess

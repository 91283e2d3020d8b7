#pragma once

#include "formats/base/affine.h"
#include "formats/brick_layout.h"
#include "formats/details/details.h"
#include "formats/space.h"

/// Shared by grids of values and of colours: reading and writing their details.
namespace rhoray::formats::details {

/// Reads samples and bricks of a layout that is dense, or may still become sparse. Refuses a layout
/// whose size does not fit in 64 bits.
/// @param least_count  minimum number of samples per axis
BrickLayout read_layout(const Reader& reader, std::int64_t least_count);

/// Reads `world_from_grid`; refuses a map without an inverse.
Affine read_affine(const Reader& reader);

Json affine_json(const Affine& affine);

/// Reads `space`; unknown where the key is missing.
Space read_space(const Reader& reader);

}  // namespace rhoray::formats::details

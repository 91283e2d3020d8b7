#pragma once

#include "formats/base/affine.h"
#include "formats/brick_layout.h"
#include "formats/details/details.h"

/// What bricked grids of values and of colours share in writing and reading their details.
namespace rhoray::formats::details {

/// Samples and bricks of a layout that is dense, or may still become sparse. Refuses one whose size
/// does not fit 64 bits.
/// @param least_count  samples that every axis has at least
BrickLayout read_layout(const Reader& reader, std::int64_t least_count);

/// `world_from_grid`; refuses one that has no inverse.
Affine read_affine(const Reader& reader);

Json affine_json(const Affine& affine);

}  // namespace rhoray::formats::details

#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// The colour of the torso's tissues at a point, linear RGB, as in photographs of frozen sections:
/// skin, lobules of fat, muscles with fibres and sheets, vessels, heart, lungs, bone and marrow,
/// surrounded by blue gel.
/// @param reach  how far each tissue extends beyond its surface, mm, so that a view of a surface
///               shows what lies under it
Vec3 tissue_light(const Vec3& p, double reach);

/// The same as 8-bit sRGB.
std::array<std::uint8_t, 3> tissue_color(const Vec3& p, double reach);

/// Writes a volume of photographs in the frame of the torso's CT (torso_ct.h): RGB, 8 bits,
/// millimetres. Memory does not depend on the number of slices; the file does not depend on the
/// number of threads.
void write_torso_photo(const std::filesystem::path& path, const Index3& texel_count, bool replace_existing);

}  // namespace rhoray::recipes

#pragma once

#include <cstdint>
#include <filesystem>

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// Where the samples of a CT of the torso's frame lie: in the middles of equal cells that fill it.
struct CtLattice {
  Index3 sample_count;
  Vec3 spacing;
  Vec3 first_sample;
};
CtLattice ct_lattice(const Index3& sample_count);

/// Hounsfield units that a scanner with voxels of this size sees at a point: each tissue's surface
/// is blurred over two voxels, and half-way between its two sides exactly on it. Without noise.
double ct_value(const Vec3& p, const Vec3& spacing);

/// Noise of a scanner, 12 HU standard deviation, at most 42 HU: depends on the sample's position in
/// the volume alone.
double ct_noise(std::uint64_t sample);

/// Writes a synthetic CT of the torso, Hounsfield units as int16, in millimetres. Memory does not
/// depend on the number of slices; the file does not depend on the number of threads.
void write_torso_ct(const std::filesystem::path& path, const Index3& sample_count, bool replace_existing);

}  // namespace rhoray::recipes

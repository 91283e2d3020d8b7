#pragma once

#include <cstdint>
#include <filesystem>

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// Positions of the samples of a CT of the torso's frame: the centres of equal cells that fill it.
struct CtLattice {
  Index3 sample_count;
  Vec3 spacing;
  Vec3 first_sample;
};
CtLattice ct_lattice(const Index3& sample_count);

/// Hounsfield units that a scanner with voxels of this size measures at a point, without noise.
/// Each tissue's surface is blurred over two voxels; exactly on the surface the value is half-way
/// between its two sides.
double ct_value(const Vec3& p, const Vec3& spacing);

/// Scanner noise with 12 HU standard deviation, at most 42 HU. Depends only on the sample's index
/// in the volume.
double ct_noise(std::uint64_t sample);

/// Writes a synthetic CT of the torso, Hounsfield units as int16, in millimetres. Memory does not
/// depend on the number of slices; the file does not depend on the number of threads.
void write_torso_ct(const std::filesystem::path& path, const Index3& sample_count, bool replace_existing);

}  // namespace rhoray::recipes

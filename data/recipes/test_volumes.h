#pragma once

#include <cstdint>
#include <filesystem>

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// Volumes for speed measurements.
enum class TestVolume {
  /// A smooth body that contains a gyroid, with a little noise. Isovalue 600.5 is its skin, 2200.5
  /// the gyroid. The skin is smooth and closed. From 32 samples per axis on, at least two samples
  /// lie between it and the volume's border.
  smooth,
  /// Many sheets, down to a size of 16 samples in 512. Isovalue 2048.5 is their middle, 2900.5
  /// gives fewer.
  turbulent
};

struct TestVolumeOptions {
  TestVolume which = TestVolume::smooth;
  std::int64_t size = 512;  ///< samples per axis, 2 to 4096; the shape does not depend on it
  bool replace_existing = false;
};

/// 16-bit samples with spacing 1, the first sample at the origin. The file does not depend on the
/// number of threads.
void write_test_volume(const std::filesystem::path& path, const TestVolumeOptions& options);

}  // namespace rhoray::recipes

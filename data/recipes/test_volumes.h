#pragma once

#include <cstdint>
#include <filesystem>

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// Volumes on which speed is measured.
enum class TestVolume {
  /// A smooth body with a gyroid in it, and a little noise: 600.5 is its skin, 2200.5 the gyroid.
  /// The skin is smooth and closed, with two samples or more between it and the volume's border
  /// from 32 samples on.
  smooth,
  /// Sheets upon sheets, down to the size of 16 samples in 512: 2048.5 is their middle, 2900.5
  /// leaves fewer.
  turbulent
};

struct TestVolumeOptions {
  TestVolume which = TestVolume::smooth;
  std::int64_t size = 512;  ///< samples on each axis, 2 to 4096; the shape does not depend on it
  bool replace_existing = false;
};

/// 16-bit samples, the spacing 1, the first sample at the origin. The file does not depend on the
/// number of threads.
void write_test_volume(const std::filesystem::path& path, const TestVolumeOptions& options);

}  // namespace rhoray::recipes

#pragma once

#include <cstdint>
#include <filesystem>

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// The test signal of Marschner and Lobb 1994, "An Evaluation of Reconstruction Filters for Volume
/// Rendering", with their alpha = 1/4 and f_M = 6; between 0 and 1 on the cube [-1, 1]^3.
double marschner_lobb(const Vec3& p);

struct MarschnerLobbOptions {
  std::int64_t size = 41;  ///< samples on each axis, the first at -1 and the last at 1; at least 2
  bool as_bytes = false;   ///< 0..255 instead of 32-bit floats 0..1
  bool replace_existing = false;
};

void write_marschner_lobb(const std::filesystem::path& path, const MarschnerLobbOptions& options);

}  // namespace rhoray::recipes

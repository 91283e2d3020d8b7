#pragma once

#include <filesystem>
#include <string>

#include "formats/base/progress.h"
#include "formats/color_grid.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct PackColorsOptions {
  bool is_linear = false;               ///< x fastest instead of bricks
  std::int64_t brick_edge = 8;          ///< 2 to 64
  std::int64_t largest_superbrick = 8;  ///< as in PackVolumeOptions
  std::string command{};                ///< stored in the file
  std::string source_name{};            ///< stored in the file
  bool replace_existing = false;
};

struct PackColorsReport {
  formats::ColorGridDescription description;
  std::uint64_t file_bytes = 0;
};

/// Sorts colours into bricks and writes them as a packed file for textures. Runs on all threads;
/// the file does not depend on the number of threads. Refuses anything but colours of 3 or 4
/// components of 8 bits on a uniform lattice.
PackColorsReport pack_colors(const NeutralVolume& colors, const formats::Destination& destination,
                             const PackColorsOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess

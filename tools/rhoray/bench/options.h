#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "render/scene_spec.h"
#include "tools/rhoray/cli/option_values.h"

namespace rhoray::tools {

struct BenchOptions {
  std::filesystem::path input;
  std::vector<std::string> isovalues{"auto"};
  std::string field;
  std::string accuracy;  ///< as in render
  std::string view = "iso";
  std::string normals, color_by;       ///< as in render
  render::PictureSize size{512, 512};  ///< the paper's
  int repeat = 5;
  unsigned threads = 0;
  bool mip = false;               ///< also rows of maximum intensity projection
  std::filesystem::path scratch;  ///< folder for files that are written to be timed
  std::uint64_t memory_limit_bytes = 0;
};

}  // namespace rhoray::tools

#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "render/accuracy.h"
#include "tools/analysis/pick.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/render/picture_options.h"

namespace rhoray::tools {

/// What was asked of `rhoray render`.
struct RenderCommand {
  CommonOptions common;
  std::vector<std::filesystem::path> inputs;  ///< the first may be a scene, or a picture that holds one
  PictureOptions picture;
  std::vector<PixelPlace> picks;
  bool statistics = false;
  bool no_verify = false;
  bool explain = false;
  bool print_scene = false;
  render::Goal goal;
  render::SelfCheckOptions self_check;
  std::optional<int> frame;  ///< the only one to be drawn
  std::optional<int> sheet;  ///< how many frames stand in a row of one picture of all
};

}  // namespace rhoray::tools

#pragma once

#include <functional>
#include <string>

#include "render/document.h"
#include "tools/view/wish.h"

namespace rhoray::tools {

/// The scene that a server shows, and what only the program that opened it can say.
struct ViewedScene {
  std::string title;             ///< for the page
  std::string program;           ///< "rhoray 0.1.0"
  render::SceneSpec scene_spec;  ///< what was asked for
  render::ResolvedScene plan{};  ///< resolved from it, with a camera
  /// The command that draws a scene; nothing where it takes a document.
  std::function<std::string(const render::ResolvedScene&)> command_of{};
};

/// The scene with a wish's camera, isovalues and size; lights follow the camera. While moving there
/// are no annotations and no antialiasing.
render::ResolvedScene with_wish(const ViewedScene& viewed, const Wish& wish);

/// The first message to a client, as JSON: title, camera, bounds, and of every isosurface its layer,
/// isovalue, colour, field, unit, range and histogram.
std::string hello_text(const ViewedScene& viewed);

}  // namespace rhoray::tools

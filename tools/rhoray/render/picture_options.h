#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/document.h"
#include "tools/rhoray/cli/options.h"

namespace rhoray::tools {

/// Position of a camera by angles, in degrees.
struct Angles {
  double azimuth_deg = 0, elevation_deg = 0;
};

/// Options of a picture: a scene of one file and one layer.
struct PictureOptions {
  render::SceneSpec scene_spec{.data = std::vector<render::DataSpec>(1), .layers = std::vector<render::LayerSpec>(1)};
  std::string mode;  ///< empty: by the kind of data
  std::vector<render::LayerSpec> slices{};
  std::filesystem::path texture;          ///< empty = none
  std::vector<std::string> landmarks;     ///< files of triangles, landmarks beside the file
  bool shadows = false;                   ///< the key light casts them
  std::optional<Angles> key_light;        ///< where it stands
  std::optional<double> key_light_size;   ///< degrees; its shadows are soft
  std::vector<std::string> of_the_layer;  ///< options given that say what is shown and how it looks
};

// The rows of these options, for `render`. They write into `options`, which stays where it is.

/// What is shown, and how; by group.
std::vector<Option> picture_options(PictureOptions& options);
/// The images that are written: size, samples, channels, frames.
std::vector<Option> image_options(PictureOptions& options);

/// The scene for one or more files; the options of the layer are those of the first. Refuses
/// mutually exclusive options (ErrorCode::usage).
render::SceneSpec spec_of(const PictureOptions& options, const std::vector<std::filesystem::path>& files);

/// A document's scene with these options: size, background, channels, accuracy, camera, lights,
/// effects and annotations are replaced. Refuses options about a layer, which do not name the layer
/// (ErrorCode::usage).
render::SceneSpec with_options(render::SceneSpec document, const PictureOptions& options);

}  // namespace rhoray::tools

#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/framebuffer.h"
#include "render/truth.h"
#include "tools/analysis/flip.h"

namespace rhoray::tools {

/// Errors of a picture against the true one.
struct PictureErrors {
  double rmse = 0;                ///< over pixels and red, green, blue of 8-bit sRGB; at most 255
  double flip = 0;                ///< mean over pixels, 0 to 1 (flip.h)
  std::vector<float> flip_map{};  ///< for each pixel
  /// Angle between normals where both pictures show something.
  std::optional<render::Quantiles> normal_deg;
};

/// The picture that others are compared with, and data derived from it.
class TruePicture {
 public:
  /// @param picture  with the channel `normal`; without it no angles are measured
  explicit TruePicture(render::Framebuffer picture);

  /// For a picture of the same size.
  PictureErrors against(const render::Framebuffer& picture) const;

  const render::Framebuffer& picture() const { return picture_; }

 private:
  render::Framebuffer picture_;
  Flip flip_;
};

/// Enlarges the colours of a smaller picture, with linear interpolation between the centres of its
/// pixels.
render::Framebuffer enlarged(const render::Framebuffer& picture, int width, int height);

}  // namespace rhoray::tools

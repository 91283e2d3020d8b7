#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/framebuffer.h"
#include "tools/analysis/errors.h"
#include "tools/analysis/flip.h"

namespace rhoray::tools {

/// How a picture differs from the true one.
struct PictureErrors {
  double rmse = 0;                      ///< over pixels and red, green, blue of 8-bit sRGB; 255 is the most there is
  double flip = 0;                      ///< mean over pixels, 0 to 1 (flip.h)
  std::vector<float> flip_map{};        ///< of each pixel
  std::optional<Quantiles> normal_deg;  ///< angle between normals where both pictures show something
};

/// The picture that others are compared with; keeps what it needs of it.
class TruePicture {
 public:
  /// @param picture  with the channel `normal`, or without: then no angles are measured
  explicit TruePicture(render::Framebuffer picture);

  /// Of a picture of the same size.
  PictureErrors against(const render::Framebuffer& picture) const;

  const render::Framebuffer& picture() const { return picture_; }

 private:
  render::Framebuffer picture_;
  Flip flip_;
};

/// The colours of a smaller picture drawn large, linear between the middles of its pixels.
render::Framebuffer enlarged(const render::Framebuffer& picture, int width, int height);

}  // namespace rhoray::tools

#pragma once

namespace rhoray::render {

/// Evenly spaced pixels: all pixels of a picture, or those of one refinement step.
struct PixelLattice {
  int x_first = 0, y_first = 0;
  int spacing = 1;
  int extent = 1;             ///< edge length, in pixels, of the square that one pixel fills
  int width = 0, height = 0;  ///< of the picture

  int columns() const { return (width - x_first + spacing - 1) / spacing; }
  int rows() const { return (height - y_first + spacing - 1) / spacing; }
};

}  // namespace rhoray::render

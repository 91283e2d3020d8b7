#pragma once

namespace rhoray::render {

/// Pixels at equal distances: all of a picture, or those of one step of its refinement.
struct PixelLattice {
  int x_first = 0, y_first = 0;
  int spacing = 1;
  int extent = 1;             ///< pixels that one stands for, across and down
  int width = 0, height = 0;  ///< of the picture

  int columns() const { return (width - x_first + spacing - 1) / spacing; }
  int rows() const { return (height - y_first + spacing - 1) / spacing; }
};

}  // namespace rhoray::render

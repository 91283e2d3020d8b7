#pragma once

#include <memory>
#include <span>
#include <vector>

namespace rhoray::tools {

/// Perceived difference of two pictures when alternating between them: the measure FLIP for
/// pictures of 8-bit range (Andersson et al., "FLIP: A Difference Evaluator for Alternating
/// Images", HPG 2020). It assumes 67 pixels per degree: a 4K screen 0.7 m wide, seen from 0.7 m. 0
/// means equal, 1 is the largest difference.
///
/// The data derived from the reference are computed once.
class Flip {
 public:
  /// @param rgb  linear, 3 numbers per pixel; clamped to [0, 1]
  Flip(int width, int height, std::span<const float> rgb);
  ~Flip();

  /// For each pixel, rows from the top.
  std::vector<float> against(std::span<const float> rgb) const;

 private:
  struct Seen;
  int width_, height_;
  std::unique_ptr<Seen> reference_;
};

double mean_of(std::span<const float> numbers);

}  // namespace rhoray::tools

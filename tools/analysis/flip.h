#pragma once

#include <memory>
#include <span>
#include <vector>

namespace rhoray::tools {

/// How different two pictures look to someone who flips between them: the measure FLIP for pictures of 8-bit range
/// (Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", HPG 2020), for 67 pixels per degree: a
/// 4K screen 0.7 m wide, seen from 0.7 m. 0 is the same, 1 as different as can be.
///
/// What is kept of the reference is computed once.
class Flip {
 public:
  /// @param rgb  linear, 3 numbers a pixel; below 0 and above 1 is taken as 0 and 1
  Flip(int width, int height, std::span<const float> rgb);
  ~Flip();

  /// Of each pixel, rows from the top.
  std::vector<float> against(std::span<const float> rgb) const;

 private:
  struct Seen;
  int width_, height_;
  std::unique_ptr<Seen> reference_;
};

double mean_of(std::span<const float> numbers);

}  // namespace rhoray::tools

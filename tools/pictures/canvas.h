#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "render/framebuffer.h"

namespace rhoray::tools {

/// A position in a picture, or a difference of two: pixels from its upper left corner. So pixel (0,
/// 0) has its centre at (0.5, 0.5).
struct Spot {
  double x = 0, y = 0;

  friend Spot operator+(const Spot& a, const Spot& b) { return {a.x + b.x, a.y + b.y}; }
  friend Spot operator-(const Spot& a, const Spot& b) { return {a.x - b.x, a.y - b.y}; }
  friend Spot operator*(double factor, const Spot& a) { return {factor * a.x, factor * a.y}; }
  double dot(const Spot& other) const { return x * other.x + y * other.y; }
  double length() const;
};

/// A rectangle in a picture.
struct Area {
  Spot low, high;  ///< upper left and lower right corner

  double width() const { return high.x - low.x; }
  double height() const { return high.y - low.y; }
  bool overlaps(const Area& other) const;
  Area grown(double by) const;
};

/// Of a linear colour, as in sRGB: 0 is black, 1 white.
inline double luminance(const Vec3& color) {
  return 0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z;
}

/// Share of each pixel that a line of text covers.
struct TextImage {
  /// Of its first column and row, relative to the start of the line's baseline.
  int left = 0, top = 0;
  int width = 0, height = 0;
  std::vector<float> coverage;  ///< rows from the top, 0 to 1
};

/// Draws anti-aliased shapes over the colours of a picture, in linear light. Alpha grows where
/// something is drawn. Every shape has a rim of another colour around it, which is invisible where
/// the picture already has that colour.
class Canvas {
 public:
  /// @param rim        colour of rims, linear
  /// @param rim_width  pixels
  Canvas(render::Framebuffer& picture, const Vec3& rim, double rim_width)
      : picture_(picture), rim_(rim), rim_width_(rim_width) {}

  /// Decides where a line is visible; called for pixels that it covers, with the share of the way
  /// from a to b.
  using IsSeen = std::function<bool(int x, int y, double share)>;

  /// A line with round ends.
  void line(const Spot& a, const Spot& b, double width, const Vec3& color, const IsSeen& is_seen = nullptr);
  /// Lines without rims. Where several meet or overlap, the one that covers most of a pixel counts,
  /// so that a curve of short lines is as thin as one line.
  /// @param is_seen  called as above, with the index of the line first
  void lines(std::span<const std::array<Spot, 2>> ends, double width, const Vec3& color,
             const std::function<bool(std::size_t line, int x, int y, double share)>& is_seen);
  void triangle(const Spot& a, const Spot& b, const Spot& c, const Vec3& color);
  /// Exactly these pixels, without a rim.
  void fill(int x_begin, int x_end, int y_begin, int y_end, const Vec3& color);
  /// @param at  start of the baseline, rounded to whole pixels
  void text(const TextImage& text, const Spot& at, const Vec3& color);

 private:
  template <class Columns, class Distance>
  void shape(const Area& around, const Columns& columns, const Distance& distance, const Vec3& color);
  template <class Columns, class Take>
  void for_pixels(const Area& around, double rim, const Columns& columns, const Take& take) const;
  void blend(int x, int y, double share, const Vec3& color);

  render::Framebuffer& picture_;
  Vec3 rim_;
  double rim_width_;
};

}  // namespace rhoray::tools

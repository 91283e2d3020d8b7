#include "tools/pictures/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rhoray::tools {

namespace {

constexpr double rim_share = 0.75;  // opacity of a rim

/// Distance of a position from the segment between two others, and the share of the segment at its
/// nearest point.
struct FromLine {
  double distance, share;
};
FromLine from_line(const Spot& p, const Spot& a, const Spot& b) {
  const Spot way = b - a;
  const double square = way.dot(way);
  const double share = square > 0 ? std::clamp((p - a).dot(way) / square, 0.0, 1.0) : 0;
  return {(p - (a + share * way)).length(), share};
}

/// Partial coverage for pixels whose centres are nearer to a shape's edge than half a pixel.
double coverage(double distance) {
  return std::clamp(0.5 - distance, 0.0, 1.0);
}

Area around(std::initializer_list<Spot> spots) {
  Area area{*spots.begin(), *spots.begin()};
  for (const Spot& spot : spots) {
    area.low = {std::min(area.low.x, spot.x), std::min(area.low.y, spot.y)};
    area.high = {std::max(area.high.x, spot.x), std::max(area.high.y, spot.y)};
  }
  return area;
}

/// The columns of a row that a line covers or nearly covers.
struct ColumnsOfLine {
  Spot a, b;
  double width;

  Interval<double> operator()(double y, double rim) const {
    const Spot way = b - a;
    if (std::abs(way.y) < 1) return {std::min(a.x, b.x) - width / 2, std::max(a.x, b.x) + width / 2};
    const double reach = width / 2 + rim;
    const double first = std::clamp((y - reach - a.y) / way.y, 0.0, 1.0),
                 last = std::clamp((y + reach - a.y) / way.y, 0.0, 1.0);
    const double from = a.x + first * way.x, to = a.x + last * way.x;
    return {std::min(from, to) - width / 2, std::max(from, to) + width / 2};
  }
};

int clamped(double pixel, int size) {
  return static_cast<int>(std::clamp(pixel, 0.0, static_cast<double>(size)));
}

}  // namespace

double Spot::length() const {
  return std::hypot(x, y);
}

bool Area::overlaps(const Area& other) const {
  return low.x < other.high.x && other.low.x < high.x && low.y < other.high.y && other.low.y < high.y;
}

Area Area::grown(double by) const {
  return {{low.x - by, low.y - by}, {high.x + by, high.y + by}};
}

void Canvas::blend(int x, int y, double share, const Vec3& color) {
  if (!(share > 0) || x < 0 || y < 0 || x >= picture_.width || y >= picture_.height) return;
  float* pixel = picture_.color.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) +
                                              static_cast<std::size_t>(x));
  for (int c = 0; c < 3; ++c)
    pixel[c] = static_cast<float>((1 - share) * static_cast<double>(pixel[c]) + share * color[c]);
  pixel[3] = static_cast<float>((1 - share) * static_cast<double>(pixel[3]) + share);
}

/// Calls take(x, y) for the pixels around a shape.
/// @param columns  range of columns of a row, without rims
template <class Columns, class Take>
void Canvas::for_pixels(const Area& area, double rim, const Columns& columns, const Take& take) const {
  const Area all = area.grown(rim);
  const int y_end = clamped(std::ceil(all.high.y), picture_.height);
  for (int y = clamped(std::floor(all.low.y), picture_.height); y < y_end; ++y) {
    const Interval<double> row = columns(y + 0.5, rim);
    const int x_end = clamped(std::ceil(row.hi + rim), picture_.width);
    for (int x = clamped(std::floor(row.lo - rim), picture_.width); x < x_end; ++x) take(x, y);
  }
}

/// @param columns   as for for_pixels
/// @param distance  from a pixel's centre to the shape's edge, below 0 inside; infinite where
///                  nothing is drawn
template <class Columns, class Distance>
void Canvas::shape(const Area& area, const Columns& columns, const Distance& distance, const Vec3& color) {
  for_pixels(area, rim_width_ + 1, columns, [&](int x, int y) {
    const double to_edge = distance(x, y), own = coverage(to_edge);
    if (rim_width_ > 0) blend(x, y, (1 - own) * rim_share * coverage(to_edge - rim_width_), rim_);
    blend(x, y, own, color);
  });
}

void Canvas::line(const Spot& a, const Spot& b, double width, const Vec3& color, const IsSeen& is_seen) {
  shape(
      around({a, b}).grown(width / 2), ColumnsOfLine{a, b, width},
      [&](int x, int y) {
        const FromLine from = from_line({x + 0.5, y + 0.5}, a, b);
        const double distance = from.distance - width / 2;
        const bool is_near = distance < rim_width_ + 0.5;
        return is_near && (!is_seen || is_seen(x, y, from.share)) ? distance : HUGE_VAL;
      },
      color);
}

void Canvas::lines(std::span<const std::array<Spot, 2>> ends, double width, const Vec3& color,
                   const std::function<bool(std::size_t line, int x, int y, double share)>& is_seen) {
  const auto columns = static_cast<std::size_t>(picture_.width);
  std::vector<float> covered(columns * static_cast<std::size_t>(picture_.height));
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Spot &a = ends[i][0], &b = ends[i][1];
    for_pixels(around({a, b}).grown(width / 2), 1, ColumnsOfLine{a, b, width}, [&](int x, int y) {
      const FromLine from = from_line({x + 0.5, y + 0.5}, a, b);
      const auto share = static_cast<float>(coverage(from.distance - width / 2));
      float& largest = covered[static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(x)];
      if (share > largest && is_seen(i, x, y, from.share)) largest = share;
    });
  }
  for (int y = 0; y < picture_.height; ++y)
    for (int x = 0; x < picture_.width; ++x)
      blend(x, y, static_cast<double>(covered[static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(x)]),
            color);
}

void Canvas::triangle(const Spot& a, const Spot& b, const Spot& c, const Vec3& color) {
  const double turn = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  const std::array<std::pair<Spot, Spot>, 3> sides{{{a, b}, {b, c}, {c, a}}};
  const Area area = around({a, b, c});
  shape(
      area,
      [&](double, double) -> Interval<double> {
        return {area.low.x, area.high.x};
      },
      [&](int x, int y) {
        const Spot p{x + 0.5, y + 0.5};
        bool is_inside = turn != 0;
        double nearest = HUGE_VAL;
        for (const auto& [from, to] : sides) {
          const double side = (to.x - from.x) * (p.y - from.y) - (to.y - from.y) * (p.x - from.x);
          is_inside = is_inside && (turn > 0 ? side >= 0 : side <= 0);
          nearest = std::min(nearest, from_line(p, from, to).distance);
        }
        return is_inside ? -nearest : nearest;
      },
      color);
}

void Canvas::fill(int x_begin, int x_end, int y_begin, int y_end, const Vec3& color) {
  for (int y = y_begin; y < y_end; ++y)
    for (int x = x_begin; x < x_end; ++x) blend(x, y, 1, color);
}

void Canvas::text(const TextImage& text, const Spot& at, const Vec3& color) {
  const int x_first = static_cast<int>(std::lround(at.x)) + text.left,
            y_first = static_cast<int>(std::lround(at.y)) + text.top;
  const auto covered = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= text.width || y >= text.height) return 0.0;
    return static_cast<double>(text.coverage[static_cast<std::size_t>(y * text.width + x)]);
  };
  // The rim is the text itself, drawn at all offsets around it.
  const int reach = static_cast<int>(std::ceil(rim_width_));
  for (int y = -reach; y < text.height + reach; ++y)
    for (int x = -reach; x < text.width + reach; ++x) {
      double rim = 0;
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx)
          rim = std::max(rim, covered(x + dx, y + dy) * coverage(std::hypot(dx, dy) - rim_width_ - 0.5));
      blend(x_first + x, y_first + y, rim_share * rim, rim_);
    }
  for (int y = 0; y < text.height; ++y)
    for (int x = 0; x < text.width; ++x) blend(x_first + x, y_first + y, covered(x, y), color);
}

}  // namespace rhoray::tools

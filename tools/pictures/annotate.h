#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render/camera.h"
#include "render/color_map.h"
#include "tools/pictures/canvas.h"
#include "tools/pictures/ticks.h"

namespace rhoray::tools {

/// What a colour bar says: which values have which colours.
struct ColorBar {
  std::string title;
  render::ColorMap map;
  Interval<double> range;

  friend bool operator==(const ColorBar&, const ColorBar&) = default;
};

enum class Side { left, right };

/// What is drawn over a finished picture. Sizes follow the picture's height. Rays know nothing of it.
struct Annotations {
  render::Camera camera{};
  bool axes = false;            ///< arrows along the world's axes, as the camera sees their directions, in a corner
  Side axes_side = Side::left;  ///< in which lower corner
  std::optional<Box3> box{};    ///< its edges, hidden behind what is nearer, with ticks and numbers along three of them
  std::string length_unit{};    ///< of the numbers along the box
  bool hides_box = true;        ///< the picture has depths, and surfaces hide the box's edges
  std::vector<ColorBar> bars{};  ///< one above the other
  Side bars_side = Side::right;
  std::string caption{};  ///< in the middle below, in lines where it is too long for one

  bool any() const { return axes || box || !bars.empty() || !caption.empty(); }
};

/// A line of text as it is drawn: letters of so many pixels, from a font's baseline.
using MakeText = std::function<TextImage(const std::string& text, int pixels)>;

/// What was drawn where.
struct Drawing {
  struct Bar {
    int x_begin, x_end, y_begin, y_end;
    std::vector<double> tick_rows;  ///< of the bar's ticks, in pixels
  };
  std::vector<Bar> bars;
  Spot axes_origin{};
  std::array<Spot, 3> axes_tips{};  ///< of x, y and z
  std::vector<Area> texts;          ///< around each line
};

/// Draws them over the picture's colours; its channels stay.
Drawing annotate(const Annotations& annotations, const MakeText& make_text, render::Framebuffer& picture);

/// Where a point is seen.
struct Seen {
  Spot at;
  double distance;  ///< before the eye's plane; not above 0 behind it
};

/// The way from points to where they are seen in a picture.
class Projection {
 public:
  Projection(const render::Camera& camera, int width, int height);

  Seen of(const Vec3& point) const;
  /// A direction as it lies in the picture: right, down, and away from the eye.
  Vec3 of_direction(const Vec3& direction) const;
  /// Whether the eye is on this side of a plane.
  bool sees_side(const Vec3& point, const Vec3& normal) const;
  /// How long the ray through a place is for each unit of distance.
  double ray_length(const Spot& at) const;
  bool is_orthographic() const { return camera_.orthographic; }

 private:
  render::Camera camera_;
  Vec3 forward_, right_, down_;
  double pixels_per_unit_;  ///< at distance 1
  Spot middle_;
};

}  // namespace rhoray::tools

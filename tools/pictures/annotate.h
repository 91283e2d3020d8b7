#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/space.h"
#include "render/camera.h"
#include "render/color_map.h"
#include "tools/pictures/canvas.h"
#include "tools/pictures/surface_lines.h"
#include "tools/pictures/ticks.h"

namespace rhoray::tools {

/// A colour bar: the map from values to colours that it shows.
struct ColorBar {
  std::string title;
  render::ColorMap map;
  Interval<double> range;
  render::ColorScale scale{};

  friend bool operator==(const ColorBar&, const ColorBar&) = default;
};

/// Colours of isosurfaces of one field, and what they stand for.
struct Legend {
  struct Entry {
    Vec3 color;  ///< linear
    std::string text;
  };
  std::string title;
  std::vector<Entry> entries;
};

enum class Side { left, right };

/// The letters of the anatomical directions in which x, y and z decrease and increase; empty if the
/// space is unknown.
struct DirectionLetters {
  std::string_view low, high;
};
DirectionLetters letters_of(formats::Space space);

/// Annotations drawn over a finished picture, independent of ray tracing. Sizes follow the
/// picture's height.
struct Annotations {
  render::Camera camera{};
  /// Space of the world. If it is RAS or LPS, the arrows and the ends of the box's edges carry the
  /// letters of their directions: R and L, A and P, S and I.
  formats::Space space = formats::Space::unknown;
  /// Arrows in a corner along the world's axes, as the camera sees them.
  bool axes = false;
  Side axes_side = Side::left;  ///< left or right lower corner
  /// Drawn edges with ticks and numbers along three of them. Beside surfaces, edges are hidden by
  /// what is nearer, and edges between two sides that face the eye are left out.
  std::optional<Box3> box{};
  std::string length_unit{};     ///< of the numbers along the box
  bool hides_box = true;         ///< the picture has depths, and surfaces hide the box's edges
  std::vector<ColorBar> bars{};  ///< one above the other
  Side bars_side = Side::right;
  std::vector<Legend> legends{};              ///< one above the other, in the upper corner opposite to the bars
  std::vector<SurfaceLines> surface_lines{};  ///< the picture has depths, and nearer surfaces hide them
  /// Centred at the bottom; wrapped if too long for one line. If the lines do not fit, the last one
  /// ends in "...".
  std::string caption{};
};

/// Renders a line of text at a font size in pixels, relative to the start of its baseline.
using MakeText = std::function<TextImage(const std::string& text, int pixels)>;

/// Positions of what was drawn.
struct Drawing {
  struct Bar {
    int x_begin, x_end, y_begin, y_end;
    std::vector<double> tick_rows;  ///< rows of the bar's ticks, in pixels
  };
  std::vector<Bar> bars;
  std::vector<Area> swatches;  ///< colours of legends
  Spot axes_origin{};
  std::array<Spot, 3> axes_tips{};  ///< for x, y and z
  struct Letter {
    char letter;
    Spot middle;
  };
  std::vector<Letter> letters;  ///< of directions in a body: of arrows, and at ends of the box's edges
  std::vector<Area> texts;      ///< bounding box of each line
};

/// Draws the annotations over the picture's colours; other channels are unchanged.
Drawing annotate(const Annotations& annotations, const MakeText& make_text, render::Framebuffer& picture);

}  // namespace rhoray::tools

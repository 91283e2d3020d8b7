#include "tools/pictures/annotate.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "formats/base/text.h"
#include "tools/pictures/projection.h"

namespace rhoray::tools {

namespace {

/// Colours of the x, y and z axes, linear, on light and on dark backgrounds. The axes' letters
/// distinguish them for any colour vision.
constexpr std::array<Vec3, 3> on_light{Vec3(0.60, 0.03, 0.03), Vec3(0.02, 0.27, 0.05), Vec3(0.03, 0.12, 0.62)};
constexpr std::array<Vec3, 3> on_dark{Vec3(1, 0.16, 0.13), Vec3(0.15, 0.72, 0.18), Vec3(0.16, 0.42, 1)};

/// The colour behind the picture: white paper where it has no background.
Vec3 page_of(const render::Framebuffer& picture) {
  if (picture.is_transparent) return {1, 1, 1};
  return {picture.background[0], picture.background[1], picture.background[2]};
}

/// A text at its position in a picture.
struct Placed {
  TextImage image;
  Spot baseline;

  Area area() const {
    const Spot low = baseline + Spot{static_cast<double>(image.left), static_cast<double>(image.top)};
    return {low, low + Spot{static_cast<double>(image.width), static_cast<double>(image.height)}};
  }
};

/// Wraps words into as few lines as a width allows; line breaks in the text are kept. If there
/// would be more than `most` lines, the last one ends in "...".
std::vector<std::string> lines_of(const std::string& text, std::size_t most,
                                  const std::function<bool(const std::string&)>& fits) {
  std::vector<std::string> lines(1);
  std::string word;
  const auto end_word = [&] {
    if (word.empty()) return;
    std::string& line = lines.back();
    const std::string longer = line.empty() ? word : concat(line, " ", word);
    if (line.empty() || fits(longer))
      line = longer;
    else
      lines.push_back(word);
    word.clear();
  };
  for (std::size_t at = 0; at <= text.size() && lines.size() <= most; ++at) {
    const char letter = at < text.size() ? text[at] : ' ';
    if (letter != ' ' && letter != '\n')
      word += letter;
    else
      end_word();
    if (letter == '\n') lines.emplace_back();
  }
  if (lines.size() > most) {
    lines.resize(most);
    std::string& last = lines.back();
    for (std::size_t space; !fits(last + "...") && (space = last.rfind(' ')) != std::string::npos;) last.erase(space);
    last += "...";
  }
  return lines;
}

std::vector<Tick> ticks_beside(const ColorBar& bar, int most) {
  if (!(bar.range.lo < bar.range.hi)) return ticks_of(bar.range, most);
  const int levels = bar.scale.levels;
  if (levels == 0) return bar.scale.is_logarithmic ? log_ticks_of(bar.range, most) : ticks_of(bar.range, most);
  std::vector<double> borders;
  for (int i = 0; i <= levels; ++i) borders.push_back(value_at(bar.scale, bar.range, static_cast<double>(i) / levels));
  return border_ticks(borders, !bar.scale.is_logarithmic, most);
}

class Annotator {
 public:
  Annotator(const Annotations& annotations, const MakeText& make_text, render::Framebuffer& picture)
      : annotations_(annotations),
        make_text_(make_text),
        picture_(picture),
        projection_(annotations.camera, picture.width, picture.height),
        visibility_(projection_, picture),
        directions_(letters_of(annotations.space)),
        is_dark_(luminance(page_of(picture)) < 0.18),
        ink_(is_dark_ ? Vec3(1, 1, 1) : Vec3(0, 0, 0)),
        canvas_(picture, page_of(picture), std::clamp(share(0.0025), 1.0, 8.0)) {}

  Drawing draw() {
    for (const SurfaceLines& lines : annotations_.surface_lines)
      draw_surface_lines(lines, projection_, visibility_, thin(), canvas_);
    if (annotations_.box) draw_box_edges();
    if (annotations_.axes) draw_axes();
    if (!annotations_.bars.empty()) draw_bars();
    draw_legends();
    if (!annotations_.caption.empty()) draw_caption();
    if (annotations_.box) draw_box_ticks();
    return std::move(drawing_);
  }

 private:
  /// A share of the picture's height, or of its width where that is smaller.
  double share(double of) const { return of * std::min<double>(picture_.height, 1.2 * picture_.width); }
  int letters() const { return std::max(8, static_cast<int>(std::lround(share(0.024)))); }
  double margin() const { return share(0.03); }
  double thin() const { return std::max(1.0, share(0.0016)); }

  Placed placed(const std::string& text, int pixels) const { return {make_text_(text, pixels), {}}; }

  /// Centres a text at a position.
  static void center(Placed& text, const Spot& at) {
    const Area area = text.area();
    text.baseline = text.baseline + (at - 0.5 * (area.low + area.high));
  }

  void put(const Placed& text, const Vec3& color) {
    canvas_.text(text.image, text.baseline, color);
    drawing_.texts.push_back(text.area());
  }

  /// False where another text is already placed, or where the text would be cut off.
  bool is_free(const Area& area) const {
    const Area all{{0, 0}, {static_cast<double>(picture_.width), static_cast<double>(picture_.height)}};
    if (area.low.x < 0 || area.low.y < 0 || area.high.x > all.high.x || area.high.y > all.high.y) return false;
    const auto overlaps = [gap = 0.25 * letters(), &area](const Area& other) {
      return area.grown(gap).overlaps(other);
    };
    return std::none_of(drawing_.texts.begin(), drawing_.texts.end(), overlaps) &&
           std::none_of(taken_.begin(), taken_.end(), overlaps);
  }

  void draw_axes() {
    const double length = share(0.075), space = 1.45 * length;
    const Spot origin{annotations_.axes_side == Side::left ? margin() + space : picture_.width - margin() - space,
                      picture_.height - margin() - space};
    std::array<Vec3, 3> directions;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 unit(0, 0, 0);
      unit[axis] = 1;
      directions[static_cast<std::size_t>(axis)] = projection_.of_direction(unit);
    }
    std::array<std::size_t, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return directions[a].z > directions[b].z; });
    drawing_.axes_origin = origin;
    for (const std::size_t axis : order) {
      const Spot way{directions[axis].x, directions[axis].y};
      drawing_.axes_tips[axis] = origin + length * way;
      draw_arrow(origin, way, length, is_dark_ ? on_dark[axis] : on_light[axis],
                 directions_.high.empty() ? "XYZ"[axis] : directions_.high[axis]);
    }
    taken_.push_back({origin - Spot{space, space}, origin + Spot{space, space}});
  }

  /// @param way  length of at most 1
  void draw_arrow(const Spot& origin, const Spot& way, double length, const Vec3& color, char letter) {
    const double head = 0.3 * length, width = 0.055 * length, seen = way.length();
    const Spot tip = origin + length * way;
    // An arrow that points straight to or from the eye is a dot.
    const Spot along = seen > 1e-9 ? (1 / seen) * way : Spot{0, 1};
    const double head_seen = std::min(head, length * seen);
    const Spot neck = tip - head_seen * along, across = 0.42 * head * Spot{-along.y, along.x};
    canvas_.line(origin, neck, width, color);
    if (head_seen > width)
      canvas_.triangle(tip, neck + across, neck - across, color);
    else
      canvas_.line(origin, origin, 3 * width, color);
    Placed text = placed(std::string(1, letter), static_cast<int>(std::lround(0.28 * length)));
    const Spot middle = origin + (length * seen + 0.24 * length) * along;
    center(text, middle);
    put(text, color);
    if (!directions_.high.empty()) drawing_.letters.push_back({letter, middle});
  }

  /// A column of bars, one below the other, each with title, colours, ticks and numbers.
  void draw_bars() {
    const int pixels = letters();
    const double all = 0.66 * picture_.height, gap = 1.2 * pixels;
    const double each =
        (all - gap * static_cast<double>(annotations_.bars.size() - 1)) / static_cast<double>(annotations_.bars.size());
    double top = 0.5 * (picture_.height - all);
    if (annotations_.bars.size() == 1 && annotations_.axes && annotations_.axes_side == annotations_.bars_side)
      top -= 0.07 * picture_.height;
    for (const ColorBar& bar : annotations_.bars) {
      draw_bar(bar, top, top + each);
      top += each + gap;
    }
  }

  void draw_bar(const ColorBar& bar, double top, double bottom) {
    const int pixels = letters();
    const double bar_width = std::round(share(0.026)), tick = 0.35 * pixels, to_number = 0.3 * pixels;
    Placed title = title_of(bar.title);
    const int y_begin = static_cast<int>(std::lround(top + 1.9 * pixels)),
              y_end = static_cast<int>(std::lround(bottom));
    if (y_end - y_begin < 2 || bar_width < 1) return;
    const int most = std::clamp(static_cast<int>((y_end - y_begin) / (2.2 * pixels)), 2, 9);
    std::vector<Placed> numbers;
    double widest = 0;
    const std::vector<Tick> ticks = ticks_beside(bar, most);
    for (const Tick& each : ticks) {
      numbers.push_back(placed(each.text, pixels));
      widest = std::max(widest, numbers.back().area().width());
    }
    const bool is_right = annotations_.bars_side == Side::right;
    const double taken = bar_width + tick + to_number + widest;
    const int x_begin = static_cast<int>(std::lround(is_right ? picture_.width - margin() - taken : margin()));
    const int x_end = x_begin + static_cast<int>(bar_width);

    // The title is above the bar. It extends inwards from the bar's outer edge where it is wider
    // than bar and numbers.
    const double title_width = title.area().width();
    const double left = is_right ? std::min<double>(x_begin, picture_.width - margin() - title_width) : x_begin;
    title.baseline = {left - title.image.left, y_begin - 0.75 * pixels};
    put(title, ink_);

    draw_frame({{static_cast<double>(x_begin), static_cast<double>(y_begin)},
                {static_cast<double>(x_end), static_cast<double>(y_end)}});
    Drawing::Bar drawn{x_begin, x_end, y_begin, y_end, {}};
    const double width = bar.range.hi - bar.range.lo;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      const double at = width > 0 ? position_of(bar.scale, bar.range, ticks[i].value) : 0.5;
      const double row = y_end - at * (y_end - y_begin);
      const bool has_number = !ticks[i].text.empty();
      canvas_.line({x_end + 0.5, row}, {x_end + (has_number ? 1 : 0.6) * tick, row}, thin(), ink_);
      drawn.tick_rows.push_back(row);
      if (!has_number) continue;
      center(numbers[i], {0, row});
      numbers[i].baseline.x = x_end + tick + to_number - numbers[i].image.left;
      put(numbers[i], ink_);
    }
    for (int y = y_begin; y < y_end; ++y)
      canvas_.fill(x_begin, x_end, y, y + 1,
                   color_of(bar.map, position_in_map(bar.scale, 1 - (y + 0.5 - y_begin) / (y_end - y_begin))));
    taken_.push_back({{x_begin - 1.0, top}, {x_begin + taken, static_cast<double>(y_end)}});
    drawing_.bars.push_back(std::move(drawn));
  }

  /// Uses smaller letters where the title would be wider than 2/5 of the picture.
  Placed title_of(const std::string& text) const {
    int pixels = letters();
    Placed title = placed(text, pixels);
    for (; title.area().width() > 0.4 * picture_.width && pixels > 8; --pixels) title = placed(text, pixels - 1);
    return title;
  }

  /// Cuts a text that would be wider than 2/5 of the picture, before a letter of UTF-8.
  Placed shortened(std::string text) const {
    Placed whole = placed(text, letters());
    while (whole.area().width() > 0.4 * picture_.width && !text.empty()) {
      while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80) text.pop_back();
      if (!text.empty()) text.pop_back();
      whole = placed(text + "...", letters());
    }
    return whole;
  }

  /// Lines of titles, and of colours with their values.
  void draw_legends() {
    const double line = 1.7 * letters(), lowest = picture_.height - margin();
    double top = margin();
    for (const Legend& legend : annotations_.legends) {
      if (top + 2 * line > lowest) return;
      draw_legend_line(title_of(legend.title), nullptr, top);
      top += line;
      for (std::size_t i = 0; i < legend.entries.size(); ++i, top += line) {
        const std::size_t left = legend.entries.size() - i;
        if (left > 1 && top + 2 * line > lowest)
          return draw_legend_line(placed(concat(left, " more"), letters()), nullptr, top);
        draw_legend_line(shortened(legend.entries[i].text), &legend.entries[i].color, top);
      }
      top += 0.6 * line;
    }
  }

  /// @param color  null: a line without one
  void draw_legend_line(Placed text, const Vec3* color, double top) {
    const bool is_left = annotations_.bars.empty() || annotations_.bars_side == Side::right;
    const int height = letters(), width = color != nullptr ? static_cast<int>(std::lround(1.5 * height)) : 0;
    const double gap = color != nullptr ? 0.6 * height : 0, text_width = text.area().width();
    const double left = is_left ? margin() : picture_.width - margin() - width - gap - text_width;
    const int x = static_cast<int>(std::lround(left)), y = static_cast<int>(std::lround(top));
    text.baseline = {x + width + gap - text.image.left, y + 0.86 * height};
    put(text, ink_);
    if (color == nullptr) return;
    const Area swatch{{static_cast<double>(x), static_cast<double>(y)},
                      {static_cast<double>(x + width), static_cast<double>(y + height)}};
    draw_frame(swatch);
    canvas_.fill(x, x + width, y, y + height, *color);
    taken_.push_back(swatch);
    drawing_.swatches.push_back(swatch);
  }

  /// Lines around a rectangle of whole pixels.
  void draw_frame(const Area& area) {
    const Spot low = area.low - Spot{0.5, 0.5}, high = area.high + Spot{0.5, 0.5};
    canvas_.line(low, {low.x, high.y}, thin(), ink_);
    canvas_.line({high.x, low.y}, high, thin(), ink_);
    canvas_.line(low, {high.x, low.y}, thin(), ink_);
    canvas_.line({low.x, high.y}, high, thin(), ink_);
  }

  void draw_caption() {
    const int pixels = static_cast<int>(std::lround(1.15 * letters()));
    const double aside = annotations_.axes ? 2 * (margin() + 2.9 * share(0.075)) : 2 * margin();
    const double width = std::max(picture_.width - aside, 0.4 * picture_.width);
    const double spacing = 1.4 * pixels, room = picture_.height - 2 * margin() - pixels;
    const auto most = static_cast<std::size_t>(1 + std::max(room / spacing, 0.0));
    const std::vector<std::string> lines = lines_of(annotations_.caption, most, [&](const std::string& line) {
      return placed(line, pixels).area().width() <= width;
    });
    double baseline = picture_.height - margin() - spacing * static_cast<double>(lines.size() - 1);
    for (const std::string& line : lines) {
      Placed text = placed(line, pixels);
      const double x = (picture_.width - text.area().width()) / 2 - text.image.left;
      text.baseline = {x, std::round(baseline)};
      put(text, ink_);
      baseline += spacing;
    }
  }

  Vec3 corner(int index) const {
    const Box3& box = *annotations_.box;
    return {(index & 1) != 0 ? box.max.x : box.min.x, (index & 2) != 0 ? box.max.y : box.min.y,
            (index & 4) != 0 ? box.max.z : box.min.z};
  }

  /// One of the box's twelve edges: along an axis, starting at the corner that is low on it.
  struct Edge {
    int axis;
    int from, to;  ///< corners
  };
  static std::vector<Edge> edges() {
    std::vector<Edge> all;
    for (int axis = 0; axis < 3; ++axis)
      for (int from = 0; from < 8; ++from)
        if ((from >> axis & 1) == 0) all.push_back({axis, from, from | 1 << axis});
    return all;
  }

  /// True if both ends are in front of the eye.
  bool is_before_the_eye(const Edge& edge) const {
    return projection_.is_orthographic() ||
           (projection_.of(corner(edge.from)).distance > 0 && projection_.of(corner(edge.to)).distance > 0);
  }

  /// Draws the box's edges. If surfaces hide edges, leaves out those between two sides that face
  /// the eye: these would run across what is shown.
  void draw_box_edges() {
    for (const Edge& edge : edges()) {
      if (!is_before_the_eye(edge) || (annotations_.hides_box && seen_sides(edge) == 2)) continue;
      const Seen from = projection_.of(corner(edge.from)), to = projection_.of(corner(edge.to));
      canvas_.line(from.at, to.at, thin(), ink_, [&](int x, int y, double share_along) {
        return !annotations_.hides_box || visibility_.is_before_surfaces(x, y, from, to, share_along);
      });
    }
  }

  /// How many of the two sides that meet in an edge are visible.
  int seen_sides(const Edge& edge) const {
    int count = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (axis == edge.axis) continue;
      Vec3 normal(0, 0, 0);
      normal[axis] = (edge.from >> axis & 1) != 0 ? 1 : -1;
      count += projection_.sees_side(corner(edge.from), normal) ? 1 : 0;
    }
    return count;
  }

  /// Draws ticks along one edge of the box's outline for each axis: the lowest edge, or the
  /// leftmost if the edges are steep.
  void draw_box_ticks() {
    std::vector<Edge> shown;
    for (int axis = 0; axis < 3; ++axis) {
      std::optional<Edge> best;
      double best_place = 0;
      const bool lies = !stands(axis);
      for (const Edge& edge : edges()) {
        if (edge.axis != axis || !is_before_the_eye(edge) || seen_sides(edge) != 1) continue;
        const Spot a = projection_.of(corner(edge.from)).at, b = projection_.of(corner(edge.to)).at;
        const double place = lies ? a.y + b.y : -(a.x + b.x);
        if (!best || place > best_place) best = edge, best_place = place;
      }
      if (best) shown.push_back(*best);
    }
    if (!directions_.low.empty())
      for (const Edge& edge : shown) draw_end_letters(edge);
    for (const Edge& edge : shown) draw_ticks(edge);
  }

  /// Draws the letters of an edge's directions beyond its ends.
  void draw_end_letters(const Edge& edge) {
    const int pixels = letters();
    const Spot from = projection_.of(corner(edge.from)).at, to = projection_.of(corner(edge.to)).at;
    const double length = (to - from).length();
    if (length < 3 * pixels) return;
    const Spot beyond = (1.1 * pixels / length) * (to - from);
    const auto axis = static_cast<std::size_t>(edge.axis);
    for (const auto& [letter, middle] :
         {std::pair(directions_.low[axis], from - beyond), {directions_.high[axis], to + beyond}}) {
      Placed text = placed(std::string(1, letter), pixels);
      center(text, middle);
      if (!is_free(text.area())) continue;
      put(text, is_dark_ ? on_dark[axis] : on_light[axis]);
      drawing_.letters.push_back({letter, middle});
    }
  }

  /// True if the box's centre line along an axis is steep in the picture.
  bool stands(int axis) const {
    const Vec3 middle = annotations_.box->center();
    Vec3 low = middle, high = middle;
    low[axis] = annotations_.box->min[axis], high[axis] = annotations_.box->max[axis];
    const Spot way = projection_.of(high).at - projection_.of(low).at;
    return std::abs(way.y) > 2 * std::abs(way.x);
  }

  void draw_ticks(const Edge& edge) {
    const int pixels = letters();
    const Vec3 low = corner(edge.from), high = corner(edge.to);
    const Seen from = projection_.of(low), to = projection_.of(high);
    const Spot way = to.at - from.at;
    const double length = way.length();
    if (length < 3 * pixels) return;
    const Spot box_middle = projection_.of(annotations_.box->center()).at;
    Spot outward = (1 / length) * Spot{-way.y, way.x};
    if (outward.dot(box_middle - from.at) > 0) outward = -1 * outward;
    // Half the extent of a text beside a line, across the line.
    const auto reach = [&](const Placed& text) {
      const Area area = text.area();
      return 0.5 * (std::abs(outward.x) * area.width() + std::abs(outward.y) * area.height());
    };
    const double tick = 0.4 * pixels, gap = 0.45 * pixels;
    double beyond = 0;
    const Interval<double> range{low[edge.axis], high[edge.axis]};
    const double per_number = (std::abs(way.x) * 3.4 + std::abs(way.y) * 2.6) / length * pixels;
    std::vector<std::pair<Spot, Placed>> numbers;
    for (const Tick& each : ticks_of(range, std::clamp(static_cast<int>(length / per_number), 1, 10))) {
      Vec3 point = low;
      point[edge.axis] = each.value;
      const Spot at = projection_.of(point).at;
      Placed number = placed(each.text, pixels);
      center(number, at + (tick + gap + reach(number)) * outward);
      beyond = std::max(beyond, tick + gap + 2 * reach(number));
      numbers.emplace_back(at, std::move(number));
    }
    Placed title = placed(
        concat("xyz"[edge.axis], annotations_.length_unit.empty() ? "" : concat(" (", annotations_.length_unit, ")")),
        pixels);
    center(title, from.at + 0.5 * way + (beyond + gap + reach(title)) * outward);
    if (is_free(title.area())) put(title, ink_);
    for (const auto& [at, number] : numbers) {
      canvas_.line(at, at + tick * outward, thin(), ink_);
      if (is_free(number.area())) put(number, ink_);
    }
  }

  const Annotations& annotations_;
  const MakeText& make_text_;
  render::Framebuffer& picture_;
  Projection projection_;
  Visibility visibility_;
  DirectionLetters directions_;
  bool is_dark_;
  Vec3 ink_;
  Canvas canvas_;
  std::vector<Area> taken_;  ///< areas where no text of the box is placed
  Drawing drawing_;
};

}  // namespace

DirectionLetters letters_of(formats::Space space) {
  switch (space) {
    case formats::Space::ras:
      return {"LPI", "RAS"};
    case formats::Space::lps:
      return {"RAI", "LPS"};
    case formats::Space::unknown:
      break;
  }
  return {};
}

Drawing annotate(const Annotations& annotations, const MakeText& make_text, render::Framebuffer& picture) {
  return Annotator(annotations, make_text, picture).draw();
}

}  // namespace rhoray::tools

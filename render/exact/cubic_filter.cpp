#include "render/exact/cubic_filter.h"

#include "render/cell/cubic.h"

namespace rhoray::render {

namespace {

Cubic middles(const BallCubic& cubic) {
  return {{cubic.b[0].middle, cubic.b[1].middle, cubic.b[2].middle, cubic.b[3].middle}};
}

double lower(const Ball& ball) {
  return ball.enclosure().lo;
}
double upper(const Ball& ball) {
  return ball.enclosure().hi;
}

class RootSearch {
 public:
  explicit RootSearch(const BallCubic& whole) : whole_(whole) {}

  /// Counts the roots between l and r, where the cubic has certain signs; false when the count is
  /// in doubt.
  bool search(double l, double r, const BallCubic& piece, int halvings) {
    const int start = piece.b[0].sign(), middle1 = piece.b[1].sign(), middle2 = piece.b[2].sign(),
              end = piece.b[3].sign();
    if (start == end) {
      if (middle1 == start && middle2 == start) return true;
    } else if (middle1 == start || middle2 == end) {
      // One sign variation, whatever the sign that may be in doubt: exactly one root, by Descartes'
      // rule.
      if (found_.count++ == 0) found_.first = {l, r};
      return true;
    }
    if (halvings == 0) return false;
    const double at = 0.5 * (l + r);
    return search_both(l, at, r, halvings - 1);
  }

  /// Splits at the critical points first: between them one test decides, if nothing is close to
  /// zero.
  bool search_all() {
    const Cubic::CriticalPoints critical = middles(whole_).critical_points();
    double l = 0;
    for (int c = 0; c < critical.count; ++c) {
      const double at = critical.s[static_cast<std::size_t>(c)];
      if (!(at > l)) continue;
      if (!search_piece(l, at, most_halvings)) return false;
      l = at;
    }
    return search_piece(l, 1, most_halvings);
  }

  CertainRoots& found() { return found_; }

 private:
  static constexpr int most_halvings = 5;

  bool search_both(double l, double at, double r, int halvings) {
    return search_piece(l, at, halvings) && search_piece(at, r, halvings);
  }

  bool search_piece(double l, double r, int halvings) {
    const BallCubic piece = l == 0 && r == 1 ? whole_ : whole_.on(l, r);
    if (piece.b[0].sign() == 0 || piece.b[3].sign() == 0) return false;
    return search(l, r, piece, halvings);
  }

  const BallCubic& whole_;
  CertainRoots found_;
};

/// Shrinks a bracket around its root as far as signs are certain.
/// @param sign_lo  the certain sign at the bracket's lower end
Enclosure narrowed(const BallCubic& cubic, Enclosure bracket, int sign_lo, double width) {
  const Cubic guess_cubic = middles(cubic);
  if (is_inside(guess_cubic.at(bracket.lo).value) == is_inside(guess_cubic.at(bracket.hi).value)) return bracket;
  const double guess = bracketed_root(guess_cubic, bracket.lo, bracket.hi, 0.5 * (bracket.lo + bracket.hi)).s;
  const double reach = 0.375 * width;
  if (const double s = guess - reach; s > bracket.lo && cubic.at(s).sign() == sign_lo) bracket.lo = s;
  if (const double s = guess + reach; s < bracket.hi && cubic.at(s).sign() == -sign_lo) bracket.hi = s;
  return bracket;
}

/// The largest coefficient bounds the curve from above.
double upper_bound(const BallCubic& piece) {
  return std::max({upper(piece.b[0]), upper(piece.b[1]), upper(piece.b[2]), upper(piece.b[3])});
}

/// Returns the Bernstein coefficients of the derivative / 3.
std::array<Ball, 3> slope_of(const BallCubic& piece) {
  return {piece.b[1] - piece.b[0], piece.b[2] - piece.b[1], piece.b[3] - piece.b[2]};
}

}  // namespace

std::optional<CertainRoots> certain_roots(const BallCubic& cubic, double width) {
  const int sign = cubic.b[0].sign();
  if (sign == 0 || cubic.b[3].sign() == 0) return std::nullopt;
  RootSearch search(cubic);
  if (cubic.b[1].sign() != sign || cubic.b[2].sign() != sign || cubic.b[3].sign() != sign) {
    if (!search.search_all()) return std::nullopt;
    if (search.found().count > 0) search.found().first = narrowed(cubic, search.found().first, sign, width);
  }
  search.found().sign_at_0 = sign;
  return search.found();
}

Enclosure largest_value_enclosure(const BallCubic& cubic) {
  double lo = std::max(lower(cubic.b[0]), lower(cubic.b[3]));
  const Cubic::CriticalPoints critical = middles(cubic).critical_points();
  double hi = critical.count == 0 ? upper_bound(cubic) : -std::numeric_limits<double>::infinity();
  double l = 0;
  for (int c = 0; c < critical.count; ++c) {
    const double at = critical.s[static_cast<std::size_t>(c)];
    lo = std::max(lo, lower(cubic.at(at)));
    hi = std::max(hi, upper_bound(cubic.on(l, at)));
    l = at;
  }
  if (critical.count > 0) hi = std::max(hi, upper_bound(cubic.on(l, 1)));
  if (!(lo <= hi)) return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  return {lo, hi};
}

std::optional<CertainMaximum> certain_maximum(const BallCubic& cubic, double width) {
  const auto& b = cubic.b;
  const auto is_below = [](const Ball& x, double y) { return upper(x) < y; };
  if (is_below(b[1], lower(b[0])) && is_below(b[2], lower(b[0])) && is_below(b[3], lower(b[0])))
    return CertainMaximum{b[0].enclosure(), {0, 0}};
  if (is_below(b[0], lower(b[3])) && is_below(b[1], lower(b[3])) && is_below(b[2], lower(b[3])))
    return CertainMaximum{b[3].enclosure(), {1, 1}};

  // Inside: where the slope falls through zero, which happens at most once for a cubic.
  const std::array<Ball, 3> slope = slope_of(cubic);
  const auto slope_at = [&](double s) {
    const Ball w{s, 0};
    return between(between(slope[0], slope[1], w), between(slope[1], slope[2], w), w);
  };
  const Cubic::CriticalPoints critical = middles(cubic).critical_points();
  for (int c = 0; c < critical.count; ++c) {
    const double s = critical.s[static_cast<std::size_t>(c)];
    const Enclosure around{std::max(0.0, s - 0.375 * width), std::min(1.0, s + 0.375 * width)};
    if (slope_at(around.lo).sign() <= 0 || slope_at(around.hi).sign() >= 0) continue;
    const double value = lower(cubic.at(s));
    if (!(value > upper(b[0]) && value > upper(b[3]))) return std::nullopt;
    return CertainMaximum{{value, upper_bound(cubic.on(around.lo, around.hi))}, around};
  }
  return std::nullopt;
}

}  // namespace rhoray::render

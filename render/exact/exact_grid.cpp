#include "render/exact/exact_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "render/exact/cubic_filter.h"
#include "render/exact/maximum.h"
#include "render/exact/ray_clock.h"

namespace rhoray::render {

namespace {

using exact::Rational;
using exact::RayClock;
using exact::Time;

/// A cell and the ray's part in it, with a length above zero.
struct Visit {
  Index3 cell;
  Time in, out;
  std::array<double, 8> corner;

  bool has_data() const {
    return std::all_of(corner.begin(), corner.end(), [](double f) { return std::isfinite(f); });
  }
  double smallest() const { return *std::min_element(corner.begin(), corner.end()); }
  double largest() const { return *std::max_element(corner.begin(), corner.end()); }
};

struct TimeSpan {
  Time in, out;
};

std::optional<TimeSpan> part_in_box(const ExactGridSource& grid, const RayClock& clock, const Ray& ray) {
  constexpr double largest = std::numeric_limits<double>::max();
  if (std::isnan(ray.t_min) || std::isnan(ray.t_max)) return std::nullopt;
  TimeSpan part{clock.at_double(std::max(ray.t_min, -largest)), clock.at_double(std::min(ray.t_max, largest))};
  if (clock.step(0) == 0 && clock.step(1) == 0 && clock.step(2) == 0) return std::nullopt;
  const Index3 cell_count = grid.cell_count();
  for (int axis = 0; axis < 3; ++axis) {
    const double start = ray.origin[axis];
    if (!std::isfinite(start) || !std::isfinite(ray.direction[axis])) return std::nullopt;
    if (clock.step(axis) == 0) {
      if (!(start >= grid.plane(axis, 0) && start <= grid.plane(axis, cell_count[axis]))) return std::nullopt;
      continue;
    }
    const bool forward = clock.step(axis) > 0;
    const Time in = clock.at_plane(axis, forward ? 0 : cell_count[axis]);
    const Time out = clock.at_plane(axis, forward ? cell_count[axis] : 0);
    if (clock.compare(in, part.in) > 0) part.in = in;
    if (clock.compare(out, part.out) < 0) part.out = out;
  }
  if (clock.compare(part.in, part.out) >= 0) return std::nullopt;
  return part;
}

/// Calls look(const Visit&) for the cells through which the ray passes, front to back, until it
/// returns false. Skips regions for which skips(const CellRegion&) is true.
template <class Skips, class Look>
void walk(const ExactGridSource& grid, const RayClock& clock, const TimeSpan& part, ExactEffort& effort, Skips&& skips,
          Look&& look) {
  Time now = part.in;
  Index3 cell;
  const auto locate = [&] {
    for (int axis = 0; axis < 3; ++axis) cell[axis] = clock.cell_at(axis, now);
  };
  /// Returns the time at which the ray leaves a box of cells, or the end of the ray if that comes
  /// first.
  const auto leave = [&](const Index3& first, const Index3& end) {
    Time out = part.out;
    for (int axis = 0; axis < 3; ++axis) {
      if (clock.step(axis) == 0) continue;
      const Time exit = clock.at_plane(axis, clock.step(axis) > 0 ? end[axis] : first[axis]);
      if (clock.compare(exit, out) < 0) out = exit;
    }
    return out;
  };
  const auto skip_region = [&] {
    for (int level = grid.level_count(); level > 0; --level) {
      const CellRegion region = grid.region(level, cell);
      if (!skips(region)) continue;
      ++effort.regions_skipped;
      now = leave(region.first, region.end);
      return true;
    }
    return false;
  };

  locate();
  while (clock.compare(now, part.out) < 0) {
    if (skip_region()) {
      locate();
      continue;
    }
    ++effort.cells_visited;
    const Time out = leave(cell, cell + Index3(1, 1, 1));
    if (!look(Visit{cell, now, out, grid.corners(cell)})) return;
    // Planes that are passed at the same time are passed together: the part between them has length
    // zero.
    for (int axis = 0; axis < 3; ++axis)
      if (clock.step(axis) != 0 && clock.compare(clock.exit(axis, cell[axis]), out) == 0)
        cell[axis] += clock.step(axis);
    now = out;
  }
}

BallCubic ball_cubic(const RayClock& clock, const Visit& visit, double offset) {
  std::array<Ball, 3> p0, p1;
  for (int axis = 0; axis < 3; ++axis) {
    p0[static_cast<std::size_t>(axis)] = clock.place(axis, visit.cell[axis], visit.in);
    p1[static_cast<std::size_t>(axis)] = clock.place(axis, visit.cell[axis], visit.out);
  }
  return along(visit.corner, offset, p0, p1);
}

exact::ScaledPolynomial polynomial(const RayClock& clock, const Visit& visit, double offset) {
  return exact::along(visit.corner, offset,
                      {clock.chord(0, visit.cell.x), clock.chord(1, visit.cell.y), clock.chord(2, visit.cell.z)});
}

/// The side that all present values of a region are on; nothing when they are on both. Regions
/// without values are outside.
std::optional<bool> common_side(const CellRegion& region, double isovalue) {
  if (region.smallest >= isovalue && !region.is_empty()) return true;
  if (region.largest < isovalue || region.is_empty()) return false;
  return std::nullopt;
}

std::optional<bool> common_side(const Visit& visit, double isovalue) {
  if (visit.smallest() >= isovalue) return true;
  if (visit.largest() < isovalue) return false;
  return std::nullopt;
}

/// The roots in a cell, where double precision proves that all are simple and none is at its ends.
struct CertainChord {
  bool starts_inside = false;
  int root_count = 0;
  Enclosure first{};  ///< of t at the first root
};

/// Returns nothing when a number or a position is in doubt, or when the ray comes from the other
/// side.
std::optional<CertainChord> certain_chord(const RayClock& clock, const Visit& visit, double isovalue, double width,
                                          const std::optional<bool>& inside) {
  const double length = visit.out.at.middle - visit.in.at.middle;
  const auto roots = certain_roots(ball_cubic(clock, visit, isovalue), 0.5 * width / length);
  if (!roots) return std::nullopt;
  CertainChord chord{.starts_inside = roots->sign_at_0 > 0, .root_count = roots->count};
  if (inside.value_or(chord.starts_inside) != chord.starts_inside) return std::nullopt;
  if (chord.root_count == 0) return chord;
  chord.first = {between(visit.in.at, visit.out.at, Ball{roots->first.lo}).enclosure().lo,
                 between(visit.in.at, visit.out.at, Ball{roots->first.hi}).enclosure().hi};
  if (!(chord.first.width() <= width)) return std::nullopt;
  return chord;
}

exact::SignChart sign_chart(const RayClock& clock, const Visit& visit, double isovalue) {
  return {polynomial(clock, visit, isovalue).polynomial, clock.exact(visit.in), clock.exact(visit.out)};
}

class CrossingSearch {
 public:
  CrossingSearch(const RayClock& clock, double isovalue, double width)
      : clock_(clock), isovalue_(isovalue), width_(width) {}

  /// True when all present values are on one side: the surface is not in the region. The ray's side
  /// is determined again behind it. It is the same side if there are data all the way, because
  /// faces are shared.
  bool skips(const CellRegion& region) {
    if (!common_side(region, isovalue_) || ends_at_face_) return false;
    inside_.reset();
    return true;
  }

  /// False when the verdict is final.
  bool look(const Visit& visit) {
    if (ends_at_face_) {
      verdict.touches = !(visit.has_data() && is_inside_behind_entry(visit));
      ends_at_face_ = false;
      return false;
    }
    if (!visit.has_data()) {
      inside_.reset();
      return true;
    }
    if (const auto side = common_side(visit, isovalue_); side && inside_.value_or(*side) == *side) {
      inside_ = side;
      return true;
    }
    if (const auto chord = certain_chord(clock_, visit, isovalue_, width_, inside_)) {
      ++verdict.effort.filtered;
      inside_ = chord->starts_inside;
      if (chord->root_count > 0) report(visit, chord->first, chord->root_count);
      return !verdict.is_hit;
    }
    ++verdict.effort.exact;
    return look_exactly(visit);
  }

  GridRayVerdict verdict;

 private:
  bool look_exactly(const Visit& visit) {
    const exact::SignChart chart = sign_chart(clock_, visit, isovalue_);
    if (!inside_) inside_ = chart.sign_at_a() >= 0;
    const auto change = exact::first_change(chart, *inside_);
    if (!change) return true;
    report(visit, chart.enclosing_root(change->root, width_),
           chart.is_zero_throughout() ? -1 : static_cast<int>(chart.roots().size()));
    verdict.touches = change->touches;
    // The cell behind the face tells whether the ray continues inside.
    ends_at_face_ =
        change->touches && chart.roots()[static_cast<std::size_t>(change->root)].lo == clock_.exact(visit.out);
    return ends_at_face_;
  }

  bool is_inside_behind_entry(const Visit& visit) const {
    return sign_chart(clock_, visit, isovalue_).pieces().front().sign >= 0;
  }

  void report(const Visit& visit, const Enclosure& t, int root_count) {
    verdict.is_hit = true;
    verdict.t = t;
    verdict.cell = visit.cell;
    verdict.root_count = root_count;
  }

  const RayClock& clock_;
  double isovalue_, width_;
  std::optional<bool> inside_;
  bool ends_at_face_ = false;
};

/// The search for all changes of side. It is always at one place of the ray and on one side, so
/// it finds each change once. A change at a face is found in the cell before it where the ray
/// enters the inside, and in the cell behind it where the ray leaves.
class AllCrossingsSearch {
 public:
  AllCrossingsSearch(const RayClock& clock, double isovalue, double width, std::size_t most)
      : clock_(clock), isovalue_(isovalue), width_(width), most_(most) {}

  /// As for the first crossing.
  bool skips(const CellRegion& region) {
    if (!common_side(region, isovalue_)) return false;
    inside_.reset();
    return true;
  }

  /// False when there are as many crossings as requested.
  bool look(const Visit& visit) {
    if (!visit.has_data()) {
      inside_.reset();
    } else if (const auto side = common_side(visit, isovalue_); side && inside_.value_or(*side) == *side) {
      inside_ = side;
    } else {
      const auto chord = certain_chord(clock_, visit, isovalue_, width_, inside_);
      if (chord) inside_ = chord->starts_inside;
      if (chord && chord->root_count == 1) change_side(visit, chord->first);
      if (!chord || chord->root_count > 1) look_exactly(visit, chord);
    }
    return crossings.size() < most_;
  }

  std::vector<GridCrossing> crossings;

 private:
  /// @param chord  where it is certain, its enclosure of the first root is taken
  void look_exactly(const Visit& visit, const std::optional<CertainChord>& chord) {
    const exact::SignChart chart = sign_chart(clock_, visit, isovalue_);
    const auto change_at = [&](int root) {
      change_side(visit, chord && root == 0 ? chord->first : chart.enclosing_root(root, width_));
    };
    const bool starts_inside = chart.sign_at_a() >= 0;
    if (inside_.value_or(starts_inside) != starts_inside) change_at(-1);
    inside_ = starts_inside;
    auto piece = chart.pieces().begin();
    if (piece->root_before < 0) ++piece;  // on the side of its start
    for (int root = 0; root < static_cast<int>(chart.roots().size()); ++root) {
      if (!*inside_) change_at(root);
      if (piece == chart.pieces().end()) return;  // a root at the end of the cell: the next one shows what follows
      if (piece->sign < 0) change_at(root);
      ++piece;
    }
  }

  void change_side(const Visit& visit, const Enclosure& t) {
    inside_ = !*inside_;
    if (crossings.size() == most_) return;
    crossings.push_back(
        {.t = crossings.empty() ? t : not_below(crossings.back().t, t), .cell = visit.cell, .to_inside = *inside_});
  }

  const RayClock& clock_;
  double isovalue_, width_;
  std::size_t most_;
  std::optional<bool> inside_;
};

class MaximumSearch {
 public:
  MaximumSearch(const RayClock& clock, ExactEffort& effort) : clock_(clock), effort_(effort) {}

  bool skips(const CellRegion& region) const {
    return region.is_empty() || (best_ && region.largest <= best_->value.lo);
  }

  bool look(const Visit& visit) {
    if (!visit.has_data() || (best_ && visit.largest() <= best_->value.lo)) return true;
    const Enclosure along_ray = largest_value_enclosure(ball_cubic(clock_, visit, 0));
    Candidate here{
        visit, {std::max(along_ray.lo, visit.smallest()), std::min(along_ray.hi, visit.largest())}, std::nullopt};
    if (!best_ || here.value.lo > best_->value.hi) {
      ++effort_.filtered;
      best_ = here;
    } else if (here.value.hi > best_->value.lo) {
      if (compare(exact_value(here), exact_value(*best_)) > 0) best_ = here;
    } else {
      ++effort_.filtered;
    }
    return true;
  }

  void report(GridMaximumVerdict& verdict, double width) const {
    if (!best_) return;
    const exact::ScaledPolynomial field = polynomial(clock_, best_->visit, 0);
    const exact::Maximum maximum =
        exact::largest_value(field.polynomial, clock_.exact(best_->visit.in), clock_.exact(best_->visit.out), width);
    verdict.has_value = true;
    verdict.value = exact::enclosing(scaled(maximum.value, field.scale), 0);
    verdict.t = maximum.at;
    verdict.cell = best_->visit.cell;
    ++effort_.exact;
  }

 private:
  struct Candidate {
    Visit visit;
    Enclosure value;
    std::optional<exact::Surd> exact;
  };

  static exact::Surd scaled(const exact::Surd& x, const Rational& scale) { return {x.a * scale, x.b * scale, x.d}; }

  const exact::Surd& exact_value(Candidate& candidate) const {
    if (!candidate.exact) {
      ++effort_.exact;
      const exact::ScaledPolynomial field = polynomial(clock_, candidate.visit, 0);
      candidate.exact =
          scaled(exact::largest_value(field.polynomial, clock_.exact(candidate.visit.in),
                                      clock_.exact(candidate.visit.out), std::numeric_limits<double>::max())
                     .value,
                 field.scale);
    }
    return *candidate.exact;
  }

  const RayClock& clock_;
  ExactEffort& effort_;
  std::optional<Candidate> best_;
};

}  // namespace

GridRayVerdict exact_first_crossing(const ExactGridSource& grid, const Ray& ray, double isovalue, double width) {
  const RayClock clock(grid, ray);
  CrossingSearch search(clock, isovalue, width);
  if (const std::optional<TimeSpan> part = part_in_box(grid, clock, ray))
    walk(
        grid, clock, *part, search.verdict.effort, [&](const CellRegion& region) { return search.skips(region); },
        [&](const Visit& visit) { return search.look(visit); });
  search.verdict.effort.exact_comparisons = clock.exact_comparisons();
  return search.verdict;
}

std::vector<GridCrossing> exact_crossings(const ExactGridSource& grid, const Ray& ray, double isovalue, double width,
                                          std::size_t most) {
  const RayClock clock(grid, ray);
  AllCrossingsSearch search(clock, isovalue, width, most);
  ExactEffort effort;
  const std::optional<TimeSpan> part = part_in_box(grid, clock, ray);
  if (part && most > 0)
    walk(
        grid, clock, *part, effort, [&](const CellRegion& region) { return search.skips(region); },
        [&](const Visit& visit) { return search.look(visit); });
  return std::move(search.crossings);
}

GridMaximumVerdict exact_largest_value(const ExactGridSource& grid, const Ray& ray, double width) {
  const RayClock clock(grid, ray);
  GridMaximumVerdict verdict;
  MaximumSearch search(clock, verdict.effort);
  if (const std::optional<TimeSpan> part = part_in_box(grid, clock, ray)) {
    walk(
        grid, clock, *part, verdict.effort, [&](const CellRegion& region) { return search.skips(region); },
        [&](const Visit& visit) { return search.look(visit); });
    search.report(verdict, width);
  }
  verdict.effort.exact_comparisons = clock.exact_comparisons();
  return verdict;
}

}  // namespace rhoray::render

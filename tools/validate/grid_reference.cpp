#include "tools/validate/grid_reference.h"

#include <CGAL/Exact_rational.h>

#include <algorithm>
#include <cmath>

namespace rhoray::tools::validate {

namespace {

using Exact = CGAL::Exact_rational;

Exact between(const Exact& a, const Exact& b, const Exact& w) {
  return a + w * (b - a);
}

/// value - isovalue in a cell's local coordinates.
Exact excess(const GridField::Cell& cell, const std::array<Exact, 3>& local, double isovalue) {
  std::array<Exact, 8> corner;
  for (std::size_t c = 0; c < 8; ++c) corner[c] = Exact(cell.corner[c]) - Exact(isovalue);
  std::array<Exact, 4> along_x;
  for (std::size_t e = 0; e < 4; ++e) along_x[e] = between(corner[2 * e], corner[2 * e + 1], local[0]);
  return between(between(along_x[0], along_x[1], local[1]), between(along_x[2], along_x[3], local[1]), local[2]);
}

struct Estimate {
  GridField::Cell cell;
  double excess = 0;
  double uncertainty = 0;  ///< generous bound on the error of the excess
};

std::optional<Estimate> estimate(const GridField& field, double isovalue, const render::Ray& ray, double t) {
  const Vec3 p_frame = ray.at(t), p_index = field.index_from_frame(p_frame);
  const std::optional<Index3> at = field.cell_at(p_index);
  if (!at) return std::nullopt;
  Estimate found{.cell = field.cell(*at)};
  if (!found.cell.has_data()) return std::nullopt;
  found.excess = found.cell.value(p_index - to_vec3(*at)) - isovalue;
  // Rounding errors of the point, in widths of its cell, and of the values.
  const Vec3 widths = field.widths(*at);
  double in_cells = 0;
  for (int axis = 0; axis < 3; ++axis)
    in_cells +=
        (std::abs(ray.origin[axis]) + std::abs(t * ray.direction[axis]) + std::abs(p_frame[axis])) / widths[axis] + 1;
  const auto largest = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const double magnitude =
      std::abs(*std::max_element(found.cell.corner.begin(), found.cell.corner.end(), largest)) + std::abs(isovalue);
  found.uncertainty = 1e-15 * (4 * in_cells * found.cell.range() + 16 * magnitude);
  return found;
}

/// The cell that contains an exact position on one axis, and the local coordinate in it; nothing
/// outside.
struct Place {
  std::int64_t cell;
  Exact local;
};
std::optional<Place> place(const GridField& field, int axis, const Exact& position, std::int64_t guess) {
  const std::int64_t last = field.sample_count()[axis] - 2;
  std::int64_t cell = std::clamp<std::int64_t>(guess, 0, last);
  while (cell > 0 && position < Exact(field.position(axis, cell))) --cell;
  while (cell < last && position >= Exact(field.position(axis, cell + 1))) ++cell;
  const Exact low = field.position(axis, cell), high = field.position(axis, cell + 1);
  if (position < low || position > high) return std::nullopt;
  return Place{cell, (position - low) / (high - low)};
}

std::optional<bool> decide_exactly(const GridField& field, double isovalue, const render::Ray& ray, double t) {
  const Vec3 guess = field.index_from_frame(ray.at(t));
  Index3 at;
  std::array<Exact, 3> local;
  for (int axis = 0; axis < 3; ++axis) {
    const Exact position = Exact(ray.origin[axis]) + Exact(t) * Exact(ray.direction[axis]);
    const auto found = place(field, axis, position, static_cast<std::int64_t>(std::floor(guess[axis])));
    if (!found) return std::nullopt;
    at[axis] = found->cell;
    local[static_cast<std::size_t>(axis)] = found->local;
  }
  const GridField::Cell cell = field.cell(at);
  if (!cell.has_data()) return std::nullopt;
  return excess(cell, local, isovalue) >= 0;
}

}  // namespace

std::optional<bool> GridReference::is_clearly_inside(const render::Ray& ray, double t) const {
  const auto found = estimate(*field_, isovalue_, ray, t);
  if (!found || !(std::abs(found->excess) > found->uncertainty)) return std::nullopt;
  return found->excess > 0;
}

std::optional<bool> GridReference::is_inside(const render::Ray& ray, double t) const {
  const auto clear = is_clearly_inside(ray, t);
  return clear ? clear : decide_exactly(*field_, isovalue_, ray, t);
}

std::optional<double> GridReference::residual(const render::Ray& ray, double t, const Index3& at) const {
  constexpr double slack = 1e-9;  // in the cell's own coordinates
  const GridField::Cell cell = field_->cell(at);
  const Vec3 local = field_->index_from_frame(ray.at(t)) - to_vec3(at);
  for (int axis = 0; axis < 3; ++axis)
    if (!(local[axis] >= -slack && local[axis] <= 1 + slack)) return std::nullopt;
  if (!cell.has_data()) return std::nullopt;
  const double excess = std::abs(cell.value(local) - isovalue_);
  return excess == 0 ? 0 : excess / cell.range();
}

std::optional<double> GridReference::halved(const render::Ray& ray, double lo, double hi, bool side_lo,
                                            double finest) const {
  while (hi - lo > 2 * finest) {
    const double middle = lo + (hi - lo) / 2;
    if (middle <= lo || middle >= hi) break;
    const auto side = is_inside(ray, middle);
    if (!side) return std::nullopt;
    (*side == side_lo ? lo : hi) = middle;
  }
  return lo + (hi - lo) / 2;
}

std::optional<double> GridReference::crossing_near(const render::Ray& ray, double t, double finest,
                                                   double farthest) const {
  for (double reach = finest; reach <= farthest; reach *= 4) {
    const auto before = is_inside(ray, t - reach), after = is_inside(ray, t + reach);
    if (before && after && *before != *after) return halved(ray, t - reach, t + reach, *before, finest);
  }
  return std::nullopt;
}

std::optional<double> GridReference::first_proved(const render::Ray& ray, double t_begin, double t_end,
                                                  double step_cells) const {
  std::optional<bool> side;
  double last = t_begin;
  for (double t = t_begin;;) {
    const Vec3 p_frame = ray.at(t);
    const auto at = field_->cell_at(field_->index_from_frame(p_frame));
    if (!at || !field_->cell(*at).has_data()) {
      side.reset();  // there is no surface across a gap in the data
    } else if (const auto here = is_clearly_inside(ray, t)) {
      if (side && *side != *here)
        if (const auto crossing = halved(ray, last, t, *side, 1e-15 * std::abs(t))) return crossing;
      side = here;
      last = t;
    }
    if (!(t < t_end)) return std::nullopt;
    t = std::min(t_end, t + step_cells / field_->in_cells(ray.direction, p_frame));
  }
}

}  // namespace rhoray::tools::validate

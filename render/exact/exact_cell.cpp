#include "render/exact/exact_cell.h"

#include <optional>

#include "render/exact/cell_polynomial.h"
#include "render/exact/cubic_filter.h"
#include "render/exact/maximum.h"

namespace rhoray::render {

namespace {

bool is_in_cell(const Vec3& p) {
  return p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1 && p.z >= 0 && p.z <= 1;
}

BallCubic ball_cubic(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double offset) {
  return along(cell.corner, offset, {Ball{p0.x}, Ball{p0.y}, Ball{p0.z}}, {Ball{p1.x}, Ball{p1.y}, Ball{p1.z}});
}

exact::ScaledPolynomial polynomial(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double offset) {
  return exact::along_unit_cell(cell.corner, offset, {p0.x, p0.y, p0.z}, {p1.x, p1.y, p1.z});
}

std::optional<CellVerdict> filtered_crossing(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double isovalue,
                                             bool starts_inside, double width) {
  const std::optional<CertainRoots> roots = certain_roots(ball_cubic(cell, p0, p1, isovalue), width);
  if (!roots) return std::nullopt;
  if ((roots->sign_at_0 > 0) != starts_inside) return CellVerdict{.changes = true, .root_count = roots->count};
  if (roots->count == 0) return CellVerdict{};
  if (!(roots->first.width() <= width)) return std::nullopt;
  return CellVerdict{.changes = true, .s = roots->first, .root_count = roots->count};
}

double largest_magnitude(const TrilinearCell& cell) {
  return std::max(std::abs(cell.smallest()), std::abs(cell.largest()));
}

}  // namespace

CellVerdict exact_crossing_unfiltered(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double isovalue,
                                      bool starts_inside, double width) {
  const exact::SignChart chart(polynomial(cell, p0, p1, isovalue).polynomial, 0, 1);
  CellVerdict verdict{.root_count = chart.is_zero_throughout() ? -1 : static_cast<int>(chart.roots().size()),
                      .road = Road::exact};
  if (const auto change = exact::first_change(chart, starts_inside)) {
    verdict.changes = true;
    verdict.touches = change->touches;
    verdict.s = chart.enclosing_root(change->root, width);
  }
  return verdict;
}

CellVerdict exact_crossing(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double isovalue,
                           bool starts_inside, double width) {
  if (is_in_cell(p0) && is_in_cell(p1))
    if (const auto verdict = filtered_crossing(cell, p0, p1, isovalue, starts_inside, width)) return *verdict;
  return exact_crossing_unfiltered(cell, p0, p1, isovalue, starts_inside, width);
}

std::vector<Enclosure> exact_roots(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double isovalue,
                                   double width) {
  const exact::SignChart chart(polynomial(cell, p0, p1, isovalue).polynomial, 0, 1);
  std::vector<Enclosure> roots;
  for (std::size_t r = 0; r < chart.roots().size(); ++r)
    roots.push_back(chart.enclosing_root(static_cast<int>(r), width));
  return roots;
}

MaximumVerdict exact_maximum_unfiltered(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double width) {
  const exact::ScaledPolynomial value = polynomial(cell, p0, p1, 0);
  const exact::Maximum maximum = exact::largest_value(value.polynomial, 0, 1, width);
  const exact::Surd scaled{maximum.value.a * value.scale, maximum.value.b * value.scale, maximum.value.d};
  return {exact::enclosing(scaled, width * largest_magnitude(cell)), maximum.at, Road::exact};
}

MaximumVerdict exact_maximum(const TrilinearCell& cell, const Vec3& p0, const Vec3& p1, double width) {
  if (is_in_cell(p0) && is_in_cell(p1)) {
    const auto maximum = certain_maximum(ball_cubic(cell, p0, p1, 0), width);
    if (maximum && maximum->s.width() <= width && maximum->value.width() <= width * largest_magnitude(cell))
      return {maximum->value, maximum->s, Road::filter};
  }
  return exact_maximum_unfiltered(cell, p0, p1, width);
}

}  // namespace rhoray::render

#include "preprocess/grid/resample/field_view.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "formats/base/parallel.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
Gradient gradient_of(const std::array<Point, 4>& p, const std::array<double, 4>& v) {
  Gradient gradient;
  gradient.has_values = has_data(v[0]) && has_data(v[1]) && has_data(v[2]) && has_data(v[3]);
  const Point e1 = minus(p[1], p[0]), e2 = minus(p[2], p[0]), e3 = minus(p[3], p[0]);
  const Point n1 = cross(e2, e3), n2 = cross(e3, e1), n3 = cross(e1, e2);
  const double six_volumes = dot(n3, e3);
  if (!gradient.has_values || !(six_volumes > 0)) return gradient;
  double change = 0, box = 1, inverse_sides = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    gradient.slope[a] = ((v[1] - v[0]) * n1[a] + (v[2] - v[0]) * n2[a] + (v[3] - v[0]) * n3[a]) / six_volumes;
    const double side = larger(larger(p[0][a], p[1][a]), larger(p[2][a], p[3][a])) -
                        smaller(smaller(p[0][a], p[1][a]), smaller(p[2][a], p[3][a]));
    box *= side;
    inverse_sides += 1 / side;
  }
  for (std::size_t a = 1; a < 4; ++a) change = std::max(change, std::abs(v[a] - v[0]));
  // As in locate.cpp: products of three differences, their rounding bounded by the box.
  const double relative_error = 0x1p-49 * 6 * box / six_volumes;
  gradient.error = relative_error * (8 * change * inverse_sides + 2 * sum_of_magnitudes(gradient.slope));
  return gradient;
}

std::vector<Point> points_in_steps(const CleanMesh& mesh, const SampleLattice& lattice) {
  std::vector<Point> steps(mesh.points.size());
  for (std::size_t p = 0; p < steps.size(); ++p) steps[p] = lattice.in_steps(mesh.points[p]);
  return steps;
}

FieldView view_of(const CleanMesh& mesh, const ScalarField& field, const std::vector<Point>& steps,
                  const SampleLattice& lattice, std::span<const Conflict> conflicts) {
  FieldView view;
  view.conflicts = conflicts;
  bool is_single = false;
  std::visit(
      [&]<class T>(const Array<T>& values) {
        view.values.assign(values.begin(), values.end());
        is_single = std::is_same_v<T, float>;
      },
      field.values);
  Interval<double> range;
  for (const double value : view.values)
    if (has_data(value)) range.include(value);
  if (range.is_empty()) range = {0, 0};
  view.low = range.lo;
  view.range = range.hi - range.lo;
  if (view.range > 0 && has_data(1 / view.range) && has_data(view.range)) view.unit = view.range;
  view.square_unit = std::ldexp(1.0, std::ilogb(view.unit));
  // Samples outside the mesh may exceed the range, by the range at most (extend.h).
  const double largest = std::max(std::abs(range.lo), std::abs(range.hi)) + view.range;
  const auto axis = static_cast<double>(std::max({lattice.count.x, lattice.count.y, lattice.count.z}));
  view.noise = largest * ((is_single ? 0x1p-24 : 0) + 0x1p-50 * axis);
  view.gradients.resize(mesh.cells.size());
  parallel_for(mesh.cells.size(), 4096, [&](const IndexRange& part) {
    for (std::size_t c = part.begin(); c < part.end(); ++c) {
      const auto& cell = mesh.cells[c];
      view.gradients[c] =
          gradient_of({steps[cell[0]], steps[cell[1]], steps[cell[2]], steps[cell[3]]},
                      {view.values[cell[0]], view.values[cell[1]], view.values[cell[2]], view.values[cell[3]]});
    }
  });
  return view;
}

}  // namespace rhoray::preprocess

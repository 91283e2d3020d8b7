#include "preprocess/grid/resample/brick_probes.h"

#include <algorithm>
#include <cmath>

#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

constexpr auto brick_samples = static_cast<std::size_t>(SampleLattice::brick_samples);

double trilinear(const std::array<double, 8>& c, const Point& at) {
  const double x0 = c[0] + at[0] * (c[1] - c[0]), x1 = c[2] + at[0] * (c[3] - c[2]);
  const double x2 = c[4] + at[0] * (c[5] - c[4]), x3 = c[6] + at[0] * (c[7] - c[6]);
  const double y0 = x0 + at[1] * (x1 - x0), y1 = x2 + at[1] * (x3 - x2);
  return y0 + at[2] * (y1 - y0);
}

}  // namespace

void BrickProbes::enter(std::size_t slot, std::int64_t row_step) {
  brick_ = touched_.at(slot);
  probes_ = rows_of_probes(lattice_, brick_, row_step);
  locate(mesh_.points, mesh_.cells, touched_.lists.view().list(touched_.bricks[slot]), lattice_, probes_, places_,
         nullptr);
}

BrickErrors BrickProbes::measure(const FieldView& field, std::size_t f) {
  BrickErrors errors;
  samples_nearby_.gather(touched_, brick_, samples_.fields[f]);
  errors.uncovered_volume = uncovered_volume(field);
  if (samples_nearby_.covered_count() == 0) return errors;
  const Point first = first_sample();
  const auto step = static_cast<std::size_t>(probes_.row_step);
  for (std::size_t k = 0; k < static_cast<std::size_t>(probes_.size.z); k += step)
    for (std::size_t j = 0; j < static_cast<std::size_t>(probes_.size.y); j += step) {
      const std::size_t row = k * PointRows::edge + j;
      const Point in_cell{probes_.shift[row] / lattice_.spacing.x,
                          (probes_.y[row] - row_place(1, j)) / lattice_.spacing.y,
                          (probes_.z[row] - row_place(2, k)) / lattice_.spacing.z};
      for (std::size_t i = 0; i < static_cast<std::size_t>(probes_.size.x); ++i) {
        const std::size_t p = Neighborhood::place(i, j, k);
        if (places_.cell[p] == Places::outside || !samples_nearby_.is_covered(p)) continue;
        const auto& cell = mesh_.cells[places_.cell[p]];
        const auto& weights = places_.weights[p];
        const double linear = weights[0] * field.values[cell[0]] + weights[1] * field.values[cell[1]] +
                              weights[2] * field.values[cell[2]] + weights[3] * field.values[cell[3]];
        const double difference = std::abs(trilinear(samples_nearby_.corners(i, j, k), in_cell) - linear);
        if (!has_data(difference)) continue;
        const double in_unit = difference / field.square_unit;
        errors.sum_of_squares += in_unit * in_unit;
        ++errors.point_count;
        errors.attain(difference, plus(first, plus(corner_of(i, j, k), in_cell)));
      }
    }
  return errors;
}

double BrickProbes::uncovered_volume(const FieldView& field) {
  if (samples_nearby_.is_whole()) return 0;
  LeafParts::Leaves uncovered;
  for (std::size_t p = 0; p < brick_samples; ++p) uncovered[p] = !samples_nearby_.is_covered(p);
  double volume = 0;
  for (const LeafParts::Part& part : parts_.find(
           first_sample(), touched_.lists.view().list(static_cast<std::size_t>(touched_.number(brick_))), uncovered, 0))
    if (field.gradients[part.cell].is_known()) volume += part.volume;
  return volume;
}

Point BrickProbes::first_sample() const {
  return {static_cast<double>(probes_.first.x), static_cast<double>(probes_.first.y),
          static_cast<double>(probes_.first.z)};
}

double BrickProbes::row_place(std::size_t axis, std::size_t i) const {
  return lattice_.places[axis][static_cast<std::size_t>(probes_.first[static_cast<int>(axis)]) + i];
}

}  // namespace rhoray::preprocess

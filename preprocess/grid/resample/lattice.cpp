#include "preprocess/grid/resample/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "formats/base/error.h"

namespace rhoray::preprocess {
namespace {

/// A bound of the rounding errors of a sample's place: of a difference of numbers of this size, a
/// quotient, a product and a sum, together seven half units.
double rounding(const Box3& box, int axis) {
  return 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(box.min[axis]), std::abs(box.max[axis]));
}

void check_count(double samples, int axis) {
  if (samples >= 2 && samples <= static_cast<double>(SampleLattice::largest_axis)) return;
  throw Error(ErrorCode::usage,
              concat("samples on the ", std::string_view("xyz").substr(static_cast<std::size_t>(axis), 1),
                     " axis: found ", samples, "; expected 2 to ", SampleLattice::largest_axis));
}

/// Fits the samples from side to side.
void fit(SampleLattice& lattice, const Box3& box, int axis, double samples) {
  check_count(samples, axis);
  lattice.count[axis] = static_cast<std::int64_t>(samples);
  lattice.spacing[axis] = (box.max[axis] - box.min[axis]) / (samples - 1);
}

void step(SampleLattice& lattice, const Box3& box, int axis, double spacing) {
  if (!(spacing > 0 && std::isfinite(spacing)))
    throw Error(ErrorCode::usage, concat("spacing: found ", spacing, "; expected a number above 0"));
  const double steps = (box.max[axis] - box.min[axis]) / spacing;
  const double samples = std::max(2.0, std::ceil(steps - rounding(box, axis) / spacing) + 1);
  check_count(samples, axis);
  lattice.count[axis] = static_cast<std::int64_t>(samples);
  lattice.spacing[axis] = spacing;
}

void place(SampleLattice& lattice, const Box3& box, int axis) {
  std::vector<double>& places = lattice.places[static_cast<std::size_t>(axis)];
  places.resize(static_cast<std::size_t>(lattice.count[axis]));
  for (std::size_t i = 0; i < places.size(); ++i)
    places[i] = lattice.low[axis] + static_cast<double>(i) * lattice.spacing[axis];
  const double beyond = places.back() - box.max[axis];
  // More than rounding would be a place that the file does not say.
  if (std::abs(beyond) <= 2 * rounding(box, axis)) places.back() = box.max[axis];
}

}  // namespace

SampleLattice choose_samples(const Box3& box, const LatticeRequest& request) {
  SampleLattice lattice;
  lattice.low = box.min;
  const Vec3 extent = box.max - box.min;
  const double longest = std::max({extent.x, extent.y, extent.z});
  if (request.longest_axis != 0)
    check_count(static_cast<double>(request.longest_axis), extent.x == longest ? 0 : extent.y == longest ? 1 : 2);
  for (int axis = 0; axis < 3; ++axis) {
    if (request.spacing != Vec3(0, 0, 0)) {
      step(lattice, box, axis, request.spacing[axis]);
    } else if (request.sample_count != Index3(0, 0, 0)) {
      fit(lattice, box, axis, static_cast<double>(request.sample_count[axis]));
    } else {
      const double steps = extent[axis] / longest * static_cast<double>(request.longest_axis - 1);
      fit(lattice, box, axis, std::max(2.0, std::round(steps) + 1));
    }
    place(lattice, box, axis);
  }
  return lattice;
}

}  // namespace rhoray::preprocess

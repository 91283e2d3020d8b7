#include "preprocess/grid/resample/certify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "formats/base/parallel.h"
#include "preprocess/grid/resample/brick_bounds.h"
#include "preprocess/grid/resample/brick_probes.h"

namespace rhoray::preprocess {
namespace {

/// The more bricks, the fewer of their rows are probed: the whole grid still has enough points for
/// its mean.
std::int64_t probe_row_step(std::size_t brick_count) {
  return brick_count <= 1024 ? 1 : brick_count <= 16384 ? 2 : 4;
}

/// Single precision represents an error well enough where its range is wide enough.
formats::ElementType type_for(double largest_error) {
  const bool fits = largest_error == 0 || (largest_error >= 1e-30 && largest_error <= 1e30);
  return fits ? formats::ElementType::F32 : formats::ElementType::F64;
}

double rounded_up(double value, formats::ElementType type) {
  if (type == formats::ElementType::F64) return value;
  const auto rounded = static_cast<float>(value);
  const bool is_below = static_cast<double>(rounded) < value;
  return static_cast<double>(is_below ? std::nextafter(rounded, std::numeric_limits<float>::infinity()) : rounded);
}

/// Volume of the tetrahedra on which a field is linear, in leaf cells.
double volume_with_data(const CleanMesh& mesh, const FieldView& field, const std::vector<Point>& steps) {
  double volume = 0;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (!field.gradients[c].is_known()) continue;
    const auto& cell = mesh.cells[c];
    const Point &p = steps[cell[0]], a = minus(steps[cell[1]], p), b = minus(steps[cell[2]], p);
    volume += dot(cross(a, b), minus(steps[cell[3]], p)) / 6;
  }
  return volume;
}

/// Marks the bricks with the largest errors so far, one in 128.
void mark_worst(const std::vector<BrickErrors>& errors, std::vector<std::uint8_t>& marks) {
  std::vector<std::uint32_t> order(errors.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto count = static_cast<std::ptrdiff_t>(std::min(errors.size(), errors.size() / 128 + 1));
  std::partial_sort(order.begin(), order.begin() + count, order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return errors[a].attained != errors[b].attained ? errors[a].attained > errors[b].attained : a < b;
  });
  for (auto slot = order.begin(); slot != order.begin() + count; ++slot) marks[*slot] = 1;
}

}  // namespace

Certificates certify(const CleanMesh& mesh, const std::vector<FieldView>& views, const std::vector<Point>& steps,
                     const FaceNeighbors& neighbors, const SampleLattice& lattice, const TouchedBricks& touched,
                     const BrickSamples& samples, const Progress& progress) {
  const std::size_t slot_count = touched.bricks.size(), field_count = views.size();
  std::vector<std::vector<BrickErrors>> errors(field_count, std::vector<BrickErrors>(slot_count));
  ProgressMeter meter(progress, "certifying bricks", 3 * slot_count);
  const auto for_each_brick = [&](auto& workers, auto&& act) {
    parallel_for(slot_count, 16, [&](const IndexRange& part) {
      auto& worker = workers.of(part);
      for (std::size_t slot = part.begin(); slot < part.end(); ++slot) act(worker, slot);
      meter.add(part.size());
    });
  };
  PerWorker<BrickProbes> probes([&] { return BrickProbes(mesh, steps, lattice, touched, samples); });
  for_each_brick(probes, [&](BrickProbes& brick, std::size_t slot) {
    brick.enter(slot, probe_row_step(slot_count));
    for (std::size_t f = 0; f < field_count; ++f) errors[f][slot] = brick.measure(views[f], f);
  });
  // Bound the bricks with the largest errors first: their attained difference is good enough for
  // the others.
  std::vector<double> largest(field_count, 0);
  std::vector<std::uint8_t> is_first(slot_count);
  for (std::size_t f = 0; f < field_count; ++f) mark_worst(errors[f], is_first);
  const std::vector<std::uint8_t> open_faces = find_open_faces(mesh, neighbors, lattice);
  PerWorker<BrickBounds> bounds([&] { return BrickBounds(mesh, neighbors, open_faces, steps, touched, samples); });
  for (const bool first : {true, false}) {
    for_each_brick(bounds, [&](BrickBounds& brick, std::size_t slot) {
      if ((is_first[slot] != 0) != first) return;
      brick.enter(slot);
      for (std::size_t f = 0; f < field_count; ++f)
        brick.bound(views[f], f, (1 + BrickBounds::relative_gap) * largest[f], errors[f][slot]);
    });
    for (std::size_t f = 0; f < field_count; ++f)
      for (const BrickErrors& brick : errors[f]) largest[f] = std::max(largest[f], brick.attained);
  }

  Certificates certificates;
  for (std::size_t f = 0; f < field_count; ++f) {
    const std::vector<BrickErrors>& of_bricks = errors[f];
    const double unit = views[f].square_unit;
    FieldErrors field;
    double sum_of_squares = 0, uncovered = 0, largest_bound = 0;
    for (const BrickErrors& brick : of_bricks) largest_bound = std::max(largest_bound, brick.bound);
    field.type = type_for(largest_bound);
    for (const BrickErrors& brick : of_bricks) {
      const double mean = brick.point_count == 0 ? 0 : unit * std::sqrt(brick.sum_of_squares / brick.point_count);
      field.max.push_back(rounded_up(brick.bound, field.type));
      field.rms.push_back(rounded_up(mean, field.type));
      field.max_error = std::max(field.max_error, field.max.back());
      if (brick.attained > field.attained) {
        field.attained = brick.attained;
        field.attained_at = brick.attained_at;
      }
      sum_of_squares += brick.sum_of_squares;
      field.point_count += brick.point_count;
      uncovered += brick.uncovered_volume;
    }
    const double whole = volume_with_data(mesh, views[f], steps);
    if (whole > 0) field.coverage = std::clamp(1 - uncovered / whole, 0.0, 1.0);
    if (field.point_count > 0)
      field.rms_error = unit * std::sqrt(sum_of_squares / static_cast<double>(field.point_count));
    certificates.fields.push_back(std::move(field));
  }
  return certificates;
}

}  // namespace rhoray::preprocess

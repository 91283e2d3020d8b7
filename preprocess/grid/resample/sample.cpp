#include "preprocess/grid/resample/sample.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/parallel.h"
#include "preprocess/grid/resample/locate.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

constexpr auto brick_samples = static_cast<std::size_t>(SampleLattice::brick_samples);

template <class T>
T interpolate(const Array<T>& values, const std::array<std::uint32_t, 4>& cell, const std::array<double, 4>& weights) {
  const std::array<T, 4> v{values[cell[0]], values[cell[1]], values[cell[2]], values[cell[3]]};
  const double sum = weights[0] * static_cast<double>(v[0]) + weights[1] * static_cast<double>(v[1]) +
                     weights[2] * static_cast<double>(v[2]) + weights[3] * static_cast<double>(v[3]);
  if (!(has_data(v[0]) && has_data(v[1]) && has_data(v[2]) && has_data(v[3])))
    return std::numeric_limits<T>::quiet_NaN();
  const T lo = std::min(std::min(v[0], v[1]), std::min(v[2], v[3]));
  const T hi = std::max(std::max(v[0], v[1]), std::max(v[2], v[3]));
  return std::clamp(static_cast<T>(sum), lo, hi);
}

struct Scratch {
  Places places;
  std::vector<SecondClaim> second;
};

/// True when the difference exceeds rounding.
template <class T>
bool disagree(T a, T b) {
  return std::abs(a - b) > 4 * std::numeric_limits<T>::epsilon() * std::max(std::abs(a), std::abs(b));
}

template <class T>
void fill_brick(const CleanMesh& mesh, const Array<T>& values, const Scratch& scratch, std::uint32_t slot, T* out,
                std::vector<Conflict>& conflicts) {
  for (std::size_t s = 0; s < brick_samples; ++s) {
    const std::uint32_t cell = scratch.places.cell[s];
    out[s] = cell == Places::outside ? std::numeric_limits<T>::quiet_NaN()
                                     : interpolate(values, mesh.cells[cell], scratch.places.weights[s]);
  }
  for (const SecondClaim& claim : scratch.second) {
    const T other = interpolate(values, mesh.cells[claim.cell], claim.weights);
    T& own = out[claim.point];
    if (!has_data(other)) continue;
    if (!has_data(own)) own = other;
    if (disagree(own, other))
      conflicts.push_back({slot, claim.point, std::abs(static_cast<double>(own) - static_cast<double>(other))});
  }
}

std::uint32_t overlaps(const std::vector<SecondClaim>& second) {
  std::array<bool, brick_samples> met{};
  std::uint32_t count = 0;
  for (const SecondClaim& claim : second) {
    if (!claim.overlaps || met[claim.point]) continue;
    met[claim.point] = true;
    ++count;
  }
  return count;
}

/// True when the mesh touches a leaf cell that has a sample of this brick as a corner, or nearly
/// so.
bool is_needed(const TouchedBricks& touched, std::size_t brick) {
  const Index3 at = touched.at_brick(static_cast<std::int64_t>(brick));
  for (std::int64_t side = 0; side < 8; ++side) {
    const Index3 source = at - Index3(side & 1, side >> 1 & 1, side >> 2);
    if (source.x >= 0 && source.y >= 0 && source.z >= 0 &&
        !touched.lists.view().list(static_cast<std::size_t>(touched.number(source))).empty())
      return true;
  }
  return false;
}

}  // namespace

TouchedBricks find_touched_bricks(const CleanMesh& mesh, const SampleLattice& lattice, const Progress& progress) {
  TouchedBricks touched;
  touched.count = lattice.brick_count();
  const formats::LeafLattice leaves{.low = lattice.low,
                                    .leaf_size = lattice.spacing * static_cast<double>(SampleLattice::brick_edge),
                                    .macro = {.leaf_count = touched.count}};
  touched.lists = build_leaf_lists(mesh.points, mesh.cells, leaves, progress);
  touched.slots.assign(static_cast<std::size_t>(volume(touched.count)), TouchedBricks::none);
  for (std::size_t brick = 0; brick < touched.slots.size(); ++brick) {
    if (!is_needed(touched, brick)) continue;
    touched.slots[brick] = static_cast<std::uint32_t>(touched.bricks.size());
    touched.bricks.push_back(static_cast<std::uint32_t>(brick));
  }
  return touched;
}

BrickSamples sample_fields(const CleanMesh& mesh, const std::vector<ScalarField>& fields, const SampleLattice& lattice,
                           const TouchedBricks& touched, const Progress& progress) {
  const std::size_t slot_count = touched.bricks.size();
  BrickSamples samples;
  for (const ScalarField& field : fields)
    std::visit([&]<class T>(const Array<T>&) { samples.fields.emplace_back(Array<T>(slot_count * brick_samples)); },
               field.values);
  samples.inside_counts.resize(slot_count);
  std::vector<std::uint32_t> overlap_counts(slot_count);
  std::vector<std::vector<std::vector<Conflict>>> conflicts(fields.size(),
                                                            std::vector<std::vector<Conflict>>(slot_count));
  ProgressMeter meter(progress, "sampling bricks", slot_count);
  PerWorker<Scratch> scratches([] { return Scratch(); });
  parallel_for(slot_count, 16, [&](const IndexRange& part) {
    Scratch& scratch = scratches.of(part);
    for (std::size_t slot = part.begin(); slot < part.end(); ++slot) {
      scratch.second.clear();
      locate(mesh.points, mesh.cells, touched.lists.view().list(touched.bricks[slot]), lattice,
             rows_of_samples(lattice, touched.at(slot)), scratch.places, &scratch.second);
      samples.inside_counts[slot] =
          static_cast<std::uint32_t>(std::count_if(scratch.places.cell.begin(), scratch.places.cell.end(),
                                                   [](std::uint32_t cell) { return cell != Places::outside; }));
      overlap_counts[slot] = overlaps(scratch.second);
      for (std::size_t f = 0; f < fields.size(); ++f)
        std::visit(
            [&]<class T>(const Array<T>& values) {
              fill_brick(mesh, values, scratch, static_cast<std::uint32_t>(slot),
                         std::get<Array<T>>(samples.fields[f]).data() + slot * brick_samples, conflicts[f][slot]);
            },
            fields[f].values);
    }
    meter.add(part.size());
  });
  samples.conflicts.resize(fields.size());
  for (std::size_t f = 0; f < fields.size(); ++f)
    for (const auto& of_slot : conflicts[f])
      samples.conflicts[f].insert(samples.conflicts[f].end(), of_slot.begin(), of_slot.end());
  for (std::size_t slot = 0; slot < slot_count; ++slot) {
    samples.inside_count += samples.inside_counts[slot];
    samples.overlap_count += overlap_counts[slot];
  }
  return samples;
}

}  // namespace rhoray::preprocess

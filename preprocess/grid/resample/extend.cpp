#include "preprocess/grid/resample/extend.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/parallel.h"
#include "preprocess/grid/resample/brick_errors.h"
#include "preprocess/grid/resample/leaf_parts.h"
#include "preprocess/grid/resample/neighborhood.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

constexpr auto edge = static_cast<std::size_t>(SampleLattice::brick_edge);
constexpr std::size_t wide = edge + 1;
constexpr auto brick_samples = static_cast<std::size_t>(SampleLattice::brick_samples);

/// The predictions of one brick's tetrahedra for a sample. Values are relative to the middle of the
/// field's range.
struct Prediction {
  /// of wide^3 from the brick's first, x fastest: the last layers belong to other bricks
  std::uint16_t sample = 0;
  double weight = 0;
  double predicted = 0;  ///< weighted sums: of the linear functions at the sample
  double squares = 0;    ///< of their squares
  double inside = 0;     ///< of the values at the parts' centres

  void add(double w, double at_sample, double at_center) {
    weight += w;
    predicted += w * at_sample;
    squares += w * at_sample * at_sample;
    inside += w * at_center;
  }
  void add(const Prediction& other) {
    weight += other.weight;
    predicted += other.predicted;
    squares += other.squares;
    inside += other.inside;
  }
};

double value_of(const Prediction& sum, const FieldView& field) {
  const double p = sum.predicted / sum.weight, m = sum.inside / sum.weight;
  const double variance = larger(0.0, sum.squares / sum.weight - p * p), range2 = field.range * field.range;
  const double trust = range2 > 0 ? range2 / (larger(range2, (p - m) * (p - m)) + variance) : 0;
  const double value = field.middle() + m + (p - m) * trust;
  return has_data(value) ? value : field.middle() + m;
}

/// Collects the predictions of the tetrahedra, one brick at a time.
class BrickExtension {
 public:
  BrickExtension(const CleanMesh& mesh, const std::vector<FieldView>& views, const std::vector<Point>& steps,
                 const SampleLattice& lattice, const TouchedBricks& touched, const BrickSamples& samples)
      : mesh_(mesh),
        views_(views),
        steps_(steps),
        lattice_(lattice),
        touched_(touched),
        samples_(samples),
        parts_(mesh, steps),
        nearby_(views.size()) {}

  /// @return  by field
  std::vector<std::vector<Prediction>> collect(std::size_t slot) {
    std::vector<std::vector<Prediction>> found(views_.size());
    const auto cells = touched_.lists.view().list(touched_.bricks[slot]);
    if (cells.empty()) return found;
    const Index3 brick = touched_.at(slot);
    LeafParts::Leaves leaves;
    for (std::size_t f = 0; f < views_.size(); ++f) {
      nearby_[f].gather(touched_, brick, samples_.fields[f]);
      if (nearby_[f].is_whole()) continue;
      for (std::size_t leaf = 0; leaf < brick_samples; ++leaf)
        leaves[leaf] = leaves[leaf] || !nearby_[f].is_covered(leaf);
    }
    remove_beyond_lattice(brick, leaves);
    for (std::size_t a = 0; a < 3; ++a)
      first_[a] = static_cast<double>(brick[static_cast<int>(a)] * SampleLattice::brick_edge);
    const std::vector<LeafParts::Part>& parts = parts_.find(first_, cells, leaves, overlap_margin(lattice_));
    if (parts.empty()) return found;
    for (std::size_t f = 0; f < views_.size(); ++f) collect_field(f, parts, found[f]);
    return found;
  }

 private:
  void remove_beyond_lattice(const Index3& brick, LeafParts::Leaves& leaves) const {
    const Index3 last = lattice_.count - brick * SampleLattice::brick_edge - Index3(2, 2, 2);
    for (std::size_t leaf = 0; leaf < brick_samples; ++leaf) {
      const auto [i, j, k] = place_of(leaf, edge);
      leaves[leaf] = leaves[leaf] && static_cast<std::int64_t>(i) <= last.x && static_cast<std::int64_t>(j) <= last.y &&
                     static_cast<std::int64_t>(k) <= last.z;
    }
  }

  static std::array<std::size_t, 3> place_of(std::size_t n, std::size_t width) {
    return {n % width, n / width % width, n / width / width};
  }

  void collect_field(std::size_t f, const std::vector<LeafParts::Part>& parts, std::vector<Prediction>& found) {
    const FieldView& field = views_[f];
    sums_.assign(wide * wide * wide, Prediction{});
    for (const LeafParts::Part& part : parts) {
      if (!field.gradients[part.cell].is_known() || nearby_[f].is_covered(part.leaf)) continue;
      const auto [i, j, k] = place_of(part.leaf, edge);
      const std::array<double, 8> corners = nearby_[f].corners(i, j, k);
      for (std::size_t c = 0; c < 8; ++c) {
        if (has_data(corners[c])) continue;
        const std::size_t x = i + (c & 1), y = j + (c >> 1 & 1), z = k + (c >> 2);
        add(field, part, corner_of(x, y, z), sums_[(z * wide + y) * wide + x]);
      }
    }
    for (std::size_t s = 0; s < sums_.size(); ++s) {
      if (!(sums_[s].weight > 0)) continue;
      sums_[s].sample = static_cast<std::uint16_t>(s);
      found.push_back(sums_[s]);
    }
  }

  /// @param sample  in steps from the brick's first
  void add(const FieldView& field, const LeafParts::Part& part, const Point& sample, Prediction& sum) const {
    const auto& cell = mesh_.cells[part.cell];
    const Gradient& gradient = field.gradients[part.cell];
    const Point corner = minus(steps_[cell[0]], first_);
    const double base = field.values[cell[0]] - field.middle();
    double lowest = base, highest = base;
    for (std::size_t v = 1; v < 4; ++v) {
      lowest = smaller(lowest, field.values[cell[v]] - field.middle());
      highest = larger(highest, field.values[cell[v]] - field.middle());
    }
    const double at_center = std::clamp(base + dot(gradient.slope, minus(part.center, corner)), lowest, highest);
    const Point way = minus(sample, part.center);
    double weight = 1e-3;  // a part at the far end of the leaf cell counts little, but it counts
    weight += larger(0.0, 1 - std::abs(way[0])) * larger(0.0, 1 - std::abs(way[1])) * larger(0.0, 1 - std::abs(way[2]));
    sum.add(weight * part.volume, at_center + dot(gradient.slope, way), at_center);
  }

  const CleanMesh& mesh_;
  const std::vector<FieldView>& views_;
  const std::vector<Point>& steps_;
  const SampleLattice& lattice_;
  const TouchedBricks& touched_;
  const BrickSamples& samples_;
  LeafParts parts_;
  Point first_{};  ///< the brick's first sample, in steps of the lattice
  std::vector<Neighborhood> nearby_;
  std::vector<Prediction> sums_;
};

using Predictions = std::vector<std::vector<std::vector<Prediction>>>;  // by slot and field

/// Sums the predictions for the samples of one brick, in the order of the bricks below and beside
/// it.
/// @return  number of samples that were given a value
std::size_t fill_brick(const TouchedBricks& touched, const Predictions& predictions, std::size_t slot, std::size_t f,
                       const FieldView& field, BrickSamples& samples) {
  std::array<Prediction, brick_samples> sums{};
  bool is_named = false;
  for (std::size_t side = 0; side < 8; ++side) {
    const std::array<bool, 3> is_beyond{(side & 1) != 0, (side & 2) != 0, (side & 4) != 0};
    const Index3 source = touched.at(slot) - Index3(is_beyond[0], is_beyond[1], is_beyond[2]);
    if (source.x < 0 || source.y < 0 || source.z < 0) continue;
    const std::uint32_t from = touched.slot(source);
    if (from == TouchedBricks::none) continue;
    for (const Prediction& prediction : predictions[from][f]) {
      const std::size_t s = prediction.sample;
      const std::array<std::size_t, 3> place{s % wide, s / wide % wide, s / wide / wide};
      bool is_here = true;
      for (std::size_t a = 0; a < 3; ++a) is_here = is_here && (place[a] == edge) == is_beyond[a];
      if (!is_here) continue;
      sums[Neighborhood::place(place[0] % edge, place[1] % edge, place[2] % edge)].add(prediction);
      is_named = true;
    }
  }
  if (!is_named) return 0;
  std::size_t count = 0;
  std::visit(
      [&]<class T>(Array<T>& values) {
        for (std::size_t s = 0; s < brick_samples; ++s) {
          if (!(sums[s].weight > 0)) continue;
          constexpr auto largest = static_cast<double>(std::numeric_limits<T>::max());
          values[slot * brick_samples + s] = static_cast<T>(std::clamp(value_of(sums[s], field), -largest, largest));
          ++count;
        }
      },
      samples.fields[f]);
  return count;
}

}  // namespace

double overlap_margin(const SampleLattice& lattice) {
  return 0x1p-48 * static_cast<double>(std::max({lattice.count.x, lattice.count.y, lattice.count.z}) + 16);
}

void extend_samples(const CleanMesh& mesh, const std::vector<FieldView>& views, const std::vector<Point>& steps,
                    const SampleLattice& lattice, const TouchedBricks& touched, BrickSamples& samples,
                    const Progress& progress) {
  const std::size_t slot_count = touched.bricks.size();
  Predictions predictions(slot_count);
  samples.extended_counts.assign(slot_count, 0);
  ProgressMeter meter(progress, "extending samples", 2 * slot_count);
  PerWorker<BrickExtension> bricks([&] { return BrickExtension(mesh, views, steps, lattice, touched, samples); });
  parallel_for(slot_count, 16, [&](const IndexRange& part) {
    BrickExtension& brick = bricks.of(part);
    for (std::size_t slot = part.begin(); slot < part.end(); ++slot) predictions[slot] = brick.collect(slot);
    meter.add(part.size());
  });
  parallel_for(slot_count, 16, [&](const IndexRange& part) {
    for (std::size_t slot = part.begin(); slot < part.end(); ++slot)
      for (std::size_t f = 0; f < views.size(); ++f)
        samples.extended_counts[slot] =
            std::max(samples.extended_counts[slot],
                     static_cast<std::uint32_t>(fill_brick(touched, predictions, slot, f, views[f], samples)));
    meter.add(part.size());
  });
  samples.extended_count = 0;
  for (const std::uint32_t count : samples.extended_counts) samples.extended_count += count;
}

}  // namespace rhoray::preprocess

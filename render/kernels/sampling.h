#pragma once

#include <cmath>

#include "render/cells/side.h"
#include "render/kernels/intersection_timer.h"
#include "render/kernels/kernels.h"
#include "render/march/lattice_walk.h"

/// What other renderers do, for comparison: the field is sampled at even steps of t along the ray. A crossing is looked
/// for where two samples in a row lie on different sides; the largest value is the largest sample. Regions whose values
/// all lie on one side, or not above the largest sample so far, are passed over: their samples would say nothing else.
///
/// A Sampler knows one ray in one kind of volume:
///   lattice(), planes(), ray_lattice(), top_level()   the walk
///   steps_per_t()                                     cells of the lattice that the ray passes while t grows by 1
///   range(level, cell)                                of values; level may be 0
///   sample(t)                                         the field there, NaN where there is no data
///   complete(hit)                                     cell and gradient of a hit at hit.t
namespace rhoray::render {

namespace {

/// The samples of a ray: number i at t_first + i * step.
struct SampleTrain {
  double t_first, step;

  RHORAY_INLINE double t(std::int64_t i) const { return t_first + static_cast<double>(i) * step; }
  /// The first sample at or after t.
  RHORAY_INLINE std::int64_t first_from(double from) const {
    return static_cast<std::int64_t>(std::ceil((from - t_first) / step));
  }
};

/// Between samples on different sides: one linear step, or ten halvings.
template <class Sampler>
double refine_between_samples(Sampler& sampler, const Question& question, double t_lo, double f_lo, double t_hi,
                              double f_hi, std::uint32_t& iterations) {
  iterations = 1;
  if (!question.method.bisect) return t_lo + (t_hi - t_lo) * (f_lo / (f_lo - f_hi));
  for (iterations = 0; iterations < 10; ++iterations) {
    const double middle = 0.5 * (t_lo + t_hi);
    (is_inside(sampler.sample(middle) - question.isovalue) == is_inside(f_lo) ? t_lo : t_hi) = middle;
  }
  return 0.5 * (t_lo + t_hi);
}

template <class Sampler>
Hit sampled_crossing(Sampler& sampler, const Question& question, KernelCounters& counters) {
  Hit hit;
  const WalkLattice lattice = sampler.lattice();
  const std::optional<Segment> segment = clip_to_lattice(sampler.ray_lattice(), sampler.planes(), lattice.leaf_count);
  if (!segment) return hit;
  const SampleTrain train{segment->t_in, question.method.step / sampler.steps_per_t()};

  struct Sample {
    std::int64_t number = -2;
    double difference = 0;
  } last;
  const auto take = [&](std::int64_t number) {
    ++counters.samples_taken;
    last = {number, sampler.sample(train.t(number)) - question.isovalue};
  };
  const auto can_cross = [&](const Interval<double>& range) {
    return range.lo < question.isovalue && question.isovalue <= range.hi;
  };
  const auto enters = [&](int level, const CellVisit& visit) {
    ++counters.macrocells_visited;
    return can_cross(sampler.range(level, visit.cell));
  };
  // Up to the sample after the leaf cell: the change may lie before it, in a region that is passed over.
  const auto leaf = [&](const CellVisit& visit) {
    ++counters.cells_visited;
    if (!can_cross(sampler.range(0, visit.cell))) return true;
    const IntersectionTimer timer(question, counters);
    const std::int64_t end = train.first_from(visit.t_out);
    for (std::int64_t i = std::max(train.first_from(visit.t_in), last.number + 1); i <= end; ++i) {
      if (train.t(i) > segment->t_out) return true;
      if (i > 0 && last.number != i - 1) take(i - 1);
      const Sample before = last;
      take(i);
      if (before.number != i - 1 || std::isnan(before.difference) || std::isnan(last.difference)) continue;
      if (is_inside(before.difference) == is_inside(last.difference)) continue;
      ++counters.cells_solved;
      hit.t = refine_between_samples(sampler, question, train.t(i - 1), before.difference, train.t(i), last.difference,
                                     hit.iteration_count);
      return false;
    }
    return true;
  };
  const int top = question.use_hierarchy ? sampler.top_level() : 0;
  walk_hierarchy(sampler.ray_lattice(), sampler.planes(), lattice, top, whole_level(lattice, lattice.cell_edge(top)),
                 segment->t_in, segment->t_out, enters, leaf);
  if (hit.is_miss()) return hit;
  hit.value = question.isovalue;
  hit.root_count = 1;
  sampler.complete(hit);
  return hit;
}

template <class Sampler>
Hit sampled_maximum(Sampler& sampler, const Question& question, KernelCounters& counters) {
  Hit hit;
  const WalkLattice lattice = sampler.lattice();
  const std::optional<Segment> segment = clip_to_lattice(sampler.ray_lattice(), sampler.planes(), lattice.leaf_count);
  if (!segment) return hit;
  const SampleTrain train{segment->t_in, question.method.step / sampler.steps_per_t()};
  const auto is_beaten = [&](double largest) { return !hit.is_miss() && largest <= hit.value; };

  const auto enters = [&](int level, const CellVisit& visit) {
    ++counters.macrocells_visited;
    const Interval<double> range = sampler.range(level, visit.cell);
    return !range.is_empty() && !is_beaten(range.hi);
  };
  const auto leaf = [&](const CellVisit& visit) {
    ++counters.cells_visited;
    const IntersectionTimer timer(question, counters);
    const std::int64_t end = train.first_from(visit.t_out);
    for (std::int64_t i = train.first_from(visit.t_in); i < end; ++i) {
      ++counters.samples_taken;
      const double value = sampler.sample(train.t(i));
      if (std::isnan(value) || is_beaten(value)) continue;
      hit.t = train.t(i);
      hit.value = value;
    }
    return true;
  };
  const int top = question.use_hierarchy ? sampler.top_level() : 0;
  walk_hierarchy(sampler.ray_lattice(), sampler.planes(), lattice, top, whole_level(lattice, lattice.cell_edge(top)),
                 segment->t_in, segment->t_out, enters, leaf);
  if (!hit.is_miss()) sampler.complete(hit);
  return hit;
}

}  // namespace

}  // namespace rhoray::render

#pragma once

#include <cmath>

#include "render/cell/side.h"
#include "render/query/intersection_timer.h"
#include "render/query/kernels.h"
#include "render/traverse/lattice_walk.h"

/// What other renderers do, for comparison: the field is sampled at even steps of t along the ray.
/// A crossing is sought where two consecutive samples lie on different sides; the largest value is
/// the largest sample. Regions are skipped if their values all lie on one side, or not above the
/// largest sample so far: their samples could not change the answer.
///
/// A Sampler knows one ray in one kind of dataset:
///   lattice(), planes(), ray_lattice()   the part of the ray that samples are taken on
///   steps_per_t()                        lattice cells that the ray passes while t grows by 1
///   walk(walk, counters, may_hold, region)
///                                        calls region(t_in, t_out) for parts of the ray, in order
///                                        of t_in. They contain all samples of regions whose range
///                                        satisfies may_hold. Returns when region returns false
///   sample(t)                            the field there, NaN where there is no data
///   complete(hit)                        sets cell and gradient of a hit at hit.t
namespace rhoray::render {

namespace {

/// The samples of a ray: sample i lies at t_first + i * step.
struct SampleTrain {
  double t_first, step;

  RHORAY_INLINE double t(std::int64_t i) const { return t_first + static_cast<double>(i) * step; }
  /// The first sample at or after `from`.
  RHORAY_INLINE std::int64_t first_from(double from) const {
    return static_cast<std::int64_t>(std::ceil((from - t_first) / step));
  }
};

/// How a Sampler walks.
struct SampledWalk {
  Segment segment;
  bool use_hierarchy;
  /// Tests the ranges of leaf cells too, not only those of the regions above them.
  bool asks_cells;
};

/// Walks a lattice, for a Sampler with top_level() and range(level, cell) of values.
template <class Sampler, class MayHold, class Region>
void walk_lattice(const Sampler& sampler, const SampledWalk& walk, KernelCounters& counters, MayHold&& may_hold,
                  Region&& region) {
  const WalkLattice lattice = sampler.lattice();
  const auto enters = [&](int level, const CellVisit& visit) {
    ++counters.macrocells_visited;
    return may_hold(sampler.range(level, visit.cell));
  };
  const auto leaf = [&](const CellVisit& visit) {
    ++counters.cells_visited;
    if (walk.asks_cells && !may_hold(sampler.range(0, visit.cell))) return true;
    return region(visit.t_in, visit.t_out);
  };
  const int top = walk.use_hierarchy ? sampler.top_level() : 0;
  walk_hierarchy(sampler.ray_lattice(), sampler.planes(), lattice, top, whole_level(lattice, lattice.cell_edge(top)),
                 walk.segment.t_in, walk.segment.t_out, enters, leaf);
}

/// Refines a crossing between samples on different sides: one linear step, or ten bisections.
template <class Sampler>
double refine_between_samples(Sampler& sampler, const RayQuery& query, double t_lo, double f_lo, double t_hi,
                              double f_hi, std::uint32_t& iterations) {
  iterations = 1;
  if (!query.method.bisect) return t_lo + (t_hi - t_lo) * (f_lo / (f_lo - f_hi));
  for (iterations = 0; iterations < 10; ++iterations) {
    const double middle = 0.5 * (t_lo + t_hi);
    (is_inside(sampler.sample(middle) - query.isovalue) == is_inside(f_lo) ? t_lo : t_hi) = middle;
  }
  return 0.5 * (t_lo + t_hi);
}

template <class Sampler>
Hit sampled_crossing(Sampler& sampler, const RayQuery& query, KernelCounters& counters) {
  Hit hit;
  const WalkLattice lattice = sampler.lattice();
  const std::optional<Segment> segment = clip_to_lattice(sampler.ray_lattice(), sampler.planes(), lattice.leaf_count);
  if (!segment) return hit;
  const SampleTrain train{segment->t_in, query.method.step / sampler.steps_per_t()};

  struct Sample {
    std::int64_t number = -2;
    double difference = 0;
  } last;
  const auto take = [&](std::int64_t number) {
    ++counters.samples_taken;
    last = {number, sampler.sample(train.t(number)) - query.isovalue};
  };
  const auto can_cross = [&](const Interval<double>& range) {
    return range.lo < query.isovalue && query.isovalue <= range.hi;
  };
  // Up to the first sample behind the region: the change may lie before that sample, in a region
  // that is skipped.
  const auto look_for_change = [&](double t_in, double t_out) {
    const IntersectionTimer timer(query, counters);
    const std::int64_t end = train.first_from(t_out);
    for (std::int64_t i = std::max(train.first_from(t_in), last.number + 1); i <= end; ++i) {
      if (train.t(i) > segment->t_out) return true;
      if (i > 0 && last.number != i - 1) take(i - 1);
      const Sample before = last;
      take(i);
      if (before.number != i - 1 || std::isnan(before.difference) || std::isnan(last.difference)) continue;
      if (is_inside(before.difference) == is_inside(last.difference)) continue;
      ++counters.cells_solved;
      hit.t = refine_between_samples(sampler, query, train.t(i - 1), before.difference, train.t(i), last.difference,
                                     hit.iteration_count);
      return false;
    }
    return true;
  };
  sampler.walk({*segment, query.use_hierarchy, true}, counters, can_cross, look_for_change);
  if (hit.is_miss()) return hit;
  hit.value = query.isovalue;
  hit.root_count = 1;
  sampler.complete(hit);
  return hit;
}

template <class Sampler>
Hit sampled_maximum(Sampler& sampler, const RayQuery& query, KernelCounters& counters) {
  Hit hit;
  const WalkLattice lattice = sampler.lattice();
  const std::optional<Segment> segment = clip_to_lattice(sampler.ray_lattice(), sampler.planes(), lattice.leaf_count);
  if (!segment) return hit;
  const SampleTrain train{segment->t_in, query.method.step / sampler.steps_per_t()};
  const auto is_beaten = [&](double largest) { return !hit.is_miss() && largest <= hit.value; };

  const auto may_hold = [&](const Interval<double>& range) { return !range.is_empty() && !is_beaten(range.hi); };
  std::int64_t next = 0;
  const auto take_samples = [&](double t_in, double t_out) {
    const IntersectionTimer timer(query, counters);
    const std::int64_t end = train.first_from(t_out);
    for (std::int64_t i = std::max(train.first_from(t_in), next); i < end; ++i) {
      ++counters.samples_taken;
      next = i + 1;
      const double value = sampler.sample(train.t(i));
      if (std::isnan(value) || is_beaten(value)) continue;
      hit.t = train.t(i);
      hit.value = value;
    }
    return true;
  };
  sampler.walk({*segment, query.use_hierarchy, false}, counters, may_hold, take_samples);
  if (!hit.is_miss()) sampler.complete(hit);
  return hit;
}

template <class Sampler, class View>
Hit sampled_crossing_of_ray(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  Sampler sampler(view, ray);
  return sampled_crossing(sampler, query, scratch.counters);
}

template <class Sampler, class View>
Hit sampled_maximum_on_ray(const View& view, const RayQuery& query, const Ray& ray, KernelScratch& scratch) {
  Sampler sampler(view, ray);
  return sampled_maximum(sampler, query, scratch.counters);
}

}  // namespace

}  // namespace rhoray::render

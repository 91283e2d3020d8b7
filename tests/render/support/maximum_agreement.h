#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "render/grid/largest/maximum.h"
#include "render/method.h"
#include "render/query/intersectors.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/fields.h"

/// Compares the wide kernels' largest values with the scalar kernel's, and provides samples for it.
namespace rhoray::tests {

inline std::vector<render::Hit> largest_values(const TracedDataset& traced, const render::Method& method,
                                               render::Machine machine, const std::vector<render::Ray>& rays_world) {
  const render::LoadedDataset& dataset = traced.dataset().implementation();
  const render::Intersectors kernels = render::choose_intersectors(dataset, {.method = method}, machine);
  render::KernelScratch scratch;
  scratch.queue.reserve(kernels.queue_entries);
  std::vector<render::Ray> rays;
  for (const render::Ray& ray : rays_world) rays.push_back(traced.ray_data(ray));
  std::vector<render::Hit> hits(rays.size());
  ask(kernels.largest, dataset, {.field_range = traced.dataset().field().range, .method = method}, rays, hits, scratch);
  return hits;
}

inline void expect_same(const std::vector<render::Hit>& wide, const std::vector<render::Hit>& reference,
                        const std::vector<render::Ray>& rays, const std::string& where) {
  int different = 0;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    const render::Hit &a = wide[r], &b = reference[r];
    if (same_bits(a, b) || ++different > 3) continue;
    ADD_FAILURE() << where << ", ray " << r << " from " << rays[r].origin << " along " << rays[r].direction << ": t "
                  << a.t << " instead of " << b.t << ", value " << a.value << " instead of " << b.value << ", cell "
                  << a.cell << " instead of " << b.cell;
  }
  EXPECT_EQ(different, 0) << where;
}

/// Expects the scalar kernel's result on every machine; returns the number of rays that hit.
inline int expect_agreement(const TracedDataset& traced, const std::vector<render::Ray>& rays) {
  const std::vector<render::Hit> reference = largest_values(traced, render::Method{}, render::Machine::scalar, rays);
  for (const render::Machine machine : wide_machines()) {
    EXPECT_NE(render::wide::largest_value_kernel(traced.dataset().implementation(), render::Method{}, machine),
              nullptr);
    expect_same(largest_values(traced, render::Method{}, machine, rays), reference, rays, name_of(machine));
  }
  return static_cast<int>(
      std::count_if(reference.begin(), reference.end(), [](const render::Hit& hit) { return !hit.is_miss(); }));
}

/// Noise of `kinds` different values from `low` upwards.
inline Samples noise(std::int64_t kinds, double low) {
  return [=](const Index3& at) {
    const auto hash = static_cast<std::uint64_t>((at.z * 1009 + at.y) * 1013 + at.x + 7) * 0x9e3779b97f4a7c15U;
    return low + static_cast<double>((hash >> 35) % static_cast<std::uint64_t>(kinds));
  };
}

inline double waves(const Index3& at) {
  const Vec3 p(static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z));
  return std::sin(0.4 * p.x) + std::sin(0.5 * p.y) * std::cos(0.3 * p.z);
}

/// Values from the smallest to the largest number of a type, most of them far below the few that
/// are high.
template <class T>
Samples over_all_of() {
  constexpr double least = std::numeric_limits<T>::lowest(), largest = std::numeric_limits<T>::max();
  return [](const Index3& at) {
    const double kind = noise(97, 0)(at);
    if (kind == 0) return largest;
    if (kind == 1) return least;
    return least + std::floor((largest - least) * (2.2 + waves(at)) / 6);
  };
}

}  // namespace rhoray::tests

#include "render/query/all_hits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "render/method.h"
#include "tests/render/support/bundles.h"
#include "tests/render/support/crossings.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

/// All hits from one traversal of a ray, compared with first crossings in double precision, each
/// traced behind the last.
namespace rhoray::tests {
namespace {

using render::CrossingList;
using render::Hit;
using render::Machine;
using render::Ray;
using render::StartSide;

constexpr render::Method single = render::method_of(render::Accuracy::float32);
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Shown {
  std::string name;
  std::unique_ptr<TracedDataset> traced;
  Vec3 size;
  double isovalues[2];
};

/// Waves around `offset`, which a ray crosses a few times.
template <class T>
Shown grid_of(const std::string& name, const Index3& samples, double scale, double offset,
              const preprocess::PackVolumeOptions& options = {}) {
  const auto wave = [&](const Index3& i) {
    const double x = static_cast<double>(i.x), y = static_cast<double>(i.y), z = static_cast<double>(i.z);
    return static_cast<T>(offset +
                          scale * (std::sin(0.4 * x) + std::sin(0.5 * y) * std::cos(0.3 * z) + 0.3 * std::sin(x * z)));
  };
  Shown shown{name, std::make_unique<TracedDataset>(volume_of<T>(samples, wave), options), {}, {}};
  for (int a = 0; a < 3; ++a) shown.size[a] = static_cast<double>(samples[a] - 1);
  shown.isovalues[0] = offset + 0.1017 * scale, shown.isovalues[1] = offset + 0.13 * scale;
  return shown;
}

std::vector<Shown> all_shown() {
  std::vector<Shown> made;
  preprocess::PackVolumeOptions linear;
  linear.order = preprocess::SampleOrder::linear;
  made.push_back(grid_of<std::uint8_t>("U8", {37, 22, 41}, 40, 120));
  made.push_back(grid_of<std::int16_t>("I16", {21, 50, 33}, 900, -100));
  made.push_back(grid_of<std::uint16_t>("U16 linear", {35, 23, 19}, 400, 1000, linear));
  made.push_back(grid_of<std::int32_t>("I32", {33, 9, 42}, 1e6, -2e9));
  made.push_back(grid_of<float>("F32", {29, 31, 27}, 1e-3, 1));
  made.push_back(grid_of<double>("F64", {25, 26, 27}, 1, 0));
  // Fields that change little inside a block, so that most rays are decided by the block's range.
  const auto slow = [](const Index3& i) {
    const double x = static_cast<double>(i.x), y = static_cast<double>(i.y), z = static_cast<double>(i.z);
    return static_cast<std::uint16_t>(2000 + 900 * std::sin(0.11 * x) * std::cos(0.09 * y) + 600 * std::sin(0.12 * z));
  };
  made.push_back({"U16 slow",
                  std::make_unique<TracedDataset>(volume_of<std::uint16_t>({61, 52, 49}, slow)),
                  {60, 51, 48},
                  {2100.5, 2107.3}});
  const auto plane = [](const Index3& i) {
    return 2.0 * static_cast<double>(i.x) - static_cast<double>(i.y) + 0.5 * static_cast<double>(i.z);
  };
  made.push_back({"F64 plane",
                  std::make_unique<TracedDataset>(volume_of<double>({33, 29, 31}, plane)),
                  {32, 28, 30},
                  {24.0, 24.1}});
  preprocess::NeutralMesh mesh = box_mesh({.cells = {14, 12, 13}, .box = {{0, 0, 0}, {28, 24, 26}}, .jitter = 0.2});
  add_point_field(mesh, "value",
                  [](const Vec3& p) { return std::sin(0.4 * p.x) + std::sin(0.5 * p.y) * std::cos(0.3 * p.z); });
  made.push_back({"mesh", std::make_unique<TracedDataset>(mesh), {28, 24, 26}, {0.1017, 0.13}});
  return made;
}

/// The crossings of each ray, per surface.
struct Crossings {
  std::vector<std::vector<std::vector<Hit>>> of_surfaces;
  std::vector<bool> complete;
};

Crossings crossings_by(Machine machine, const Shown& shown, const std::vector<double>& isovalues,
                       const std::vector<Ray>& rays, float passing = 1, float least_light = 0) {
  const render::LoadedDataset& dataset = shown.traced->dataset().implementation();
  const render::AllHitsKernel kernel =
      render::choose_intersectors(dataset, {.isovalue = isovalues[0], .method = single}, machine).all_hits;
  Crossings found{.of_surfaces = {}, .complete = std::vector<bool>(rays.size())};
  found.of_surfaces.resize(isovalues.size(), std::vector<std::vector<Hit>>(rays.size()));
  if (kernel == nullptr) {
    ADD_FAILURE() << shown.name << ": no kernel";
    return found;
  }
  std::vector<render::TransparentSurface> surfaces;
  for (const double isovalue : isovalues) surfaces.push_back({.isovalue = isovalue, .passing = passing});
  constexpr std::size_t batch = 1024;
  std::vector<render::HitBatch> first;
  std::vector<std::unique_ptr<CrossingList>> made;
  std::vector<CrossingList*> lists;
  for (std::size_t s = 0; s < isovalues.size(); ++s) first.emplace_back(batch);
  for (std::size_t s = 0; s < isovalues.size(); ++s) {
    lists.push_back(made.emplace_back(std::make_unique<CrossingList>(batch)).get());
    lists.back()->put_first_into(first[s]);
  }
  render::RayBatch asked(batch);
  render::Scratch memory;
  render::KernelCounters counters;
  std::uint8_t complete[batch];
  for (std::size_t from = 0; from < rays.size(); from += batch) {
    asked.count = std::min(batch, rays.size() - from);
    for (std::size_t r = 0; r < asked.count; ++r) asked.set(r, rays[from + r]);
    kernel(dataset, {.surfaces = surfaces, .least_light = least_light}, asked, lists, complete, memory, counters);
    for (std::size_t r = 0; r < asked.count; ++r) {
      found.complete[from + r] = complete[r] != 0;
      for (std::size_t s = 0; s < isovalues.size(); ++s)
        for (std::size_t k = 0; k < lists[s]->count[r]; ++k)
          found.of_surfaces[s][from + r].push_back(lists[s]->hits(k)[r]);
      for (std::size_t s = 0; s < isovalues.size(); ++s) EXPECT_EQ(lists[s]->count[r] == 0, first[s].t[r] == infinity);
    }
  }
  return found;
}

/// Traces one crossing after another, at most as many as a list holds.
std::vector<std::vector<Hit>> chains(const Shown& shown, double isovalue, const render::Method& method, Machine machine,
                                     std::vector<Ray> rays) {
  std::vector<std::vector<Hit>> found(rays.size());
  for (std::size_t k = 0; k < CrossingList::most; ++k) {
    const std::vector<Hit> hits = answers(*shown.traced, method, machine, rays, isovalue);
    for (std::size_t r = 0; r < rays.size(); ++r) {
      if (hits[r].is_miss()) {
        rays[r].t_max = -1;
        continue;
      }
      found[r].push_back(hits[r]);
      rays[r].t_min = hits[r].t > rays[r].t_min ? hits[r].t : std::nextafter(hits[r].t, infinity);
      rays[r].start_side = hits[r].gradient.dot(rays[r].direction) > 0 ? StartSide::inside : StartSide::outside;
    }
  }
  return found;
}

/// Rays close together, far apart, cut short, and through lattice points.
std::vector<Ray> rays_at(const Shown& shown, std::size_t count) {
  std::vector<Ray> rays = bundles(shown.size, count, 7);
  Dice dice(8);
  for (std::size_t r = 0; r < rays.size(); r += 5) rays[r].t_max = dice.between(0, 3 * shown.size.length());
  for (std::size_t i = 0; i < count / 4; ++i) {
    const Vec3 point(std::floor(dice.between(0, shown.size.x)), std::floor(dice.between(0, shown.size.y)),
                     std::floor(dice.between(0, shown.size.z)));
    const Vec3 direction = dice.direction();
    rays.push_back({.origin = point - 50.0 * direction, .direction = direction});
  }
  return rays;
}

TEST(OrderedCrossings, begin_with_the_first_crossing_to_the_bit) {
  std::size_t hits = 0;
  for (const Shown& shown : all_shown())
    for (const Machine machine : wide_machines()) {
      const std::vector<Ray> rays = rays_at(shown, 1500);
      const std::vector<double> isovalues(shown.isovalues, shown.isovalues + 2);
      const Crossings found = crossings_by(machine, shown, isovalues, rays);
      for (std::size_t s = 0; s < 2; ++s) {
        const std::vector<Hit> first = answers(*shown.traced, single, machine, rays, isovalues[s]);
        for (std::size_t r = 0; r < rays.size(); ++r) {
          const auto& list = found.of_surfaces[s][r];
          ASSERT_EQ(first[r].is_miss(), list.empty()) << shown.name << " ray " << r;
          if (list.empty()) continue;
          ASSERT_EQ(first[r].t, list[0].t) << shown.name << " ray " << r;
          ASSERT_EQ(first[r].cell, list[0].cell);
          ASSERT_EQ(first[r].gradient, list[0].gradient);
          ASSERT_EQ(first[r].value, list[0].value);
          ASSERT_EQ(first[r].root_count, list[0].root_count);
          ASSERT_EQ(first[r].iteration_count, list[0].iteration_count);
          ++hits;
        }
      }
    }
  EXPECT_GT(hits, 10'000U);
}

TEST(OrderedCrossings, are_those_of_double_precision_one_after_another) {
  std::size_t crossings = 0, others = 0, asked = 0;
  for (const Shown& shown : all_shown()) {
    const std::vector<Ray> rays = rays_at(shown, 1000);
    for (const std::vector<double>& isovalues :
         {std::vector<double>{shown.isovalues[0]}, {shown.isovalues[0], shown.isovalues[1]}}) {
      std::vector<std::vector<std::vector<Hit>>> reference;
      for (const double isovalue : isovalues) reference.push_back(chains(shown, isovalue, {}, Machine::scalar, rays));
      for (const Machine machine : wide_machines()) {
        const Crossings found = crossings_by(machine, shown, isovalues, rays);
        for (std::size_t s = 0; s < isovalues.size(); ++s)
          for (std::size_t r = 0; r < rays.size(); ++r) {
            const auto &list = found.of_surfaces[s][r], &chain = reference[s][r];
            ++asked;
            bool is_same = list.size() == chain.size() || !found.complete[r];
            for (std::size_t k = 0; k < std::min(list.size(), chain.size()); ++k) {
              is_same &= std::abs(list[k].t - chain[k].t) < 1e-3;
              crossings += is_same;
            }
            for (std::size_t k = 1; k < list.size(); ++k) ASSERT_LE(list[k - 1].t, list[k].t) << shown.name;
            others += !is_same;
          }
      }
    }
  }
  // Grazed surfaces: single precision finds a pair of crossings or none, where double finds the
  // opposite.
  EXPECT_LE(others, asked / 250);
  EXPECT_GT(crossings, asked);
}

TEST(OrderedCrossings, of_a_surface_do_not_depend_on_the_other) {
  for (const Shown& shown : all_shown()) {
    const std::vector<Ray> rays = rays_at(shown, 600);
    const Machine machine = wide_machines().back();
    const Crossings both = crossings_by(machine, shown, {shown.isovalues[0], shown.isovalues[1]}, rays);
    for (std::size_t s = 0; s < 2; ++s) {
      const Crossings one = crossings_by(machine, shown, {shown.isovalues[s]}, rays);
      for (std::size_t r = 0; r < rays.size(); ++r) {
        const auto &list = both.of_surfaces[s][r], &alone = one.of_surfaces[0][r];
        if (both.complete[r]) {
          ASSERT_EQ(list.size(), alone.size());
        }
        for (std::size_t k = 0; k < std::min(list.size(), alone.size()); ++k) ASSERT_EQ(list[k].t, alone[k].t);
      }
    }
  }
}

TEST(OrderedCrossings, end_in_the_dark_and_where_a_list_is_full) {
  const auto sheets = [](const Index3& i) { return static_cast<std::int16_t>(i.x % 2 == 0 ? -100 : 100); };
  Shown shown{"sheets",
              std::make_unique<TracedDataset>(volume_of<std::int16_t>({40, 20, 20}, sheets)),
              {39, 19, 19},
              {0.25, 0.5}};
  std::vector<Ray> rays;
  for (int i = 0; i < 64; ++i)
    rays.push_back({.origin = {-3, 5 + 0.1 * (i % 8), 5.3 + 0.1 * (i / 8)}, .direction = {1, 0.01, 0.02}});
  const Crossings all = crossings_by(wide_machines().back(), shown, {0.25, 0.5}, rays);
  const Crossings dark = crossings_by(wide_machines().back(), shown, {0.25, 0.5}, rays, 0.5F, 1.0F / 16 - 1e-4F);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    EXPECT_FALSE(all.complete[r]);
    EXPECT_EQ(std::max(all.of_surfaces[0][r].size(), all.of_surfaces[1][r].size()), CrossingList::most);
    EXPECT_TRUE(dark.complete[r]);
    // Five reduce the light to less than that; what is in their last cell is hit with them.
    const std::size_t met = dark.of_surfaces[0][r].size() + dark.of_surfaces[1][r].size();
    EXPECT_GE(met, 5U);
    EXPECT_LE(met, 6U);
  }
}

TEST(OrderedCrossings, have_no_kernel_where_rays_may_come_out_of_gaps_or_more_is_promised) {
  const Shown shown = grid_of<float>("F32", {19, 17, 15}, 1, 0);
  const render::LoadedDataset& dataset = shown.traced->dataset().implementation();
  for (const Machine machine : wide_machines()) {
    EXPECT_NE(render::choose_intersectors(dataset, {.isovalue = 0.1, .method = single}, machine).all_hits, nullptr);
    for (const render::Accuracy accuracy :
         {render::Accuracy::preview, render::Accuracy::float64, render::Accuracy::certified, render::Accuracy::exact})
      EXPECT_EQ(render::choose_intersectors(dataset, {.isovalue = 0.1, .method = render::method_of(accuracy)}, machine)
                    .all_hits,
                nullptr);
    EXPECT_EQ(render::choose_intersectors(dataset, {.isovalue = 0.1, .method = single, .use_hierarchy = false}, machine)
                  .all_hits,
              nullptr);
  }
  EXPECT_EQ(render::choose_intersectors(dataset, {.isovalue = 0.1, .method = single}, Machine::scalar).all_hits,
            nullptr);
  const auto with_gap = [](const Index3& i) {
    return i == Index3(3, 4, 5) ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(i.x);
  };
  TracedDataset gap(volume_of<float>({9, 9, 9}, with_gap));
  EXPECT_EQ(render::choose_intersectors(gap.dataset().implementation(), {.isovalue = 3.1, .method = single}).all_hits,
            nullptr);
}

}  // namespace
}  // namespace rhoray::tests
